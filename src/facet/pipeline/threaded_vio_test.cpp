// SPDX-License-Identifier: BSD-2-Clause
// The whole system on painted images of a wall and a floor: pose, planes and map are right, and on
// two threads they are the same bit for bit. Also the run for the thread sanitizer.
#include "facet/pipeline/threaded_vio.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "facet/base/median.h"
#include "facet/base/types.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/testing/pipeline/painted_recording.h"

namespace facet {
namespace {

using testing::Feed;
using testing::kBegin;
using testing::kFloorZ;
using testing::kWallX;
using testing::PaintedRecording;
using testing::Sway;

class ThreadedVioTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    recording_ = new PaintedRecording(testing::PaintRecording());
    one_ = new VioPipeline(recording_->rig, ImuNoise{}, VioOptions{});
    outputs_ = new std::vector<VioOutput>;
    Feed(
        *recording_,
        [](const ImuSample& sample) { one_->AddImu(sample); },
        [](const StereoFrame& frame) { outputs_->push_back(one_->AddStereo(frame)); });
  }
  static void TearDownTestSuite() {
    delete outputs_;
    delete one_;
    delete recording_;
  }

  static SE3 TruePose(Timestamp t) {
    return {recording_->T_WB0.q, Sway::Position(ToSeconds(t - kBegin))};
  }
  static const VioOutput& First() {
    return *std::find_if(outputs_->begin(), outputs_->end(), [](const VioOutput& output) {
      return output.has_pose;
    });
  }
  // W has its origin at the first pose that is output.
  static SE3 TrueToWorld() { return First().state.T_WB * TruePose(First().t).Inverse(); }

  static inline PaintedRecording* recording_ = nullptr;
  static inline VioPipeline* one_ = nullptr;
  static inline std::vector<VioOutput>* outputs_ = nullptr;
};

TEST_F(ThreadedVioTest, FollowsThePath) {
  ASSERT_TRUE(outputs_->back().has_pose);
  EXPECT_LE(ToSeconds(First().t - kBegin), 1);
  const SE3 T_W_true = TrueToWorld();
  for (const VioOutput& output : *outputs_) {
    if (!output.has_pose) continue;
    const SE3 expected = T_W_true * TruePose(output.t);
    EXPECT_LT((output.state.T_WB.p - expected.p).norm(), 0.003) << ToSeconds(output.t - kBegin);
    EXPECT_LT(output.state.T_WB.q.angularDistance(expected.q), 0.005);
  }
}

TEST_F(ThreadedVioTest, FollowsThePathWithoutRightImages) {
  constexpr Timestamp kRightEnds{kBegin.ns + 1'200'000'000};
  VioPipeline vio(recording_->rig, ImuNoise{}, VioOptions{});
  const SE3 T_W_true = TrueToWorld();
  int num_mono = 0;
  Feed(
      *recording_,
      [&](const ImuSample& sample) { vio.AddImu(sample); },
      [&](StereoFrame frame) {
        if (frame.t > kRightEnds) frame.right = cv::Mat();
        const VioOutput output = vio.AddStereo(frame);
        if (frame.t <= kRightEnds) return;
        ++num_mono;
        ASSERT_TRUE(output.has_pose);
        const SE3 expected = T_W_true * TruePose(output.t);
        EXPECT_LT((output.state.T_WB.p - expected.p).norm(), 0.006) << ToSeconds(output.t - kBegin);
        EXPECT_NE(output.status, TrackingStatus::kLost);
      });
  EXPECT_GT(num_mono, 40);
}

TEST_F(ThreadedVioTest, FindsFloorAndWallWhereTheyAre) {
  const SE3 T_true_W = TrueToWorld().Inverse();
  int num_floors = 0, num_walls = 0;
  const RunResult result = one_->Result();
  for (const PlaneRecord& plane : *result.planes) {
    const bool is_wall = plane.label == PlaneLabel::kWall;
    num_floors += plane.label == PlaneLabel::kFloor ? 1 : 0;
    num_walls += is_wall ? 1 : 0;
    const Vector3d n = T_true_W.q * plane.plane_W.n, centre = T_true_W * plane.centroid_W;
    EXPECT_GT(is_wall ? -n.x() : n.z(), std::cos(0.01));
    EXPECT_NEAR(is_wall ? centre.x() - kWallX : centre.z() - kFloorZ, 0, 0.02);
  }
  EXPECT_EQ(num_floors, 1);
  EXPECT_EQ(num_walls, 1);
}

TEST_F(ThreadedVioTest, MapsFloorAndWall) {
  const std::optional<TriangleMesh> map = one_->Result().map;
  ASSERT_TRUE(map);
  EXPECT_GT(map->faces.size(), 3000U);
  const SE3 T_true_W = TrueToWorld().Inverse();
  std::vector<double> distances_m;
  for (const Vector3d& vertex : map->vertices) {
    const Vector3d p = T_true_W * vertex;
    distances_m.push_back(std::min(std::abs(p.x() - kWallX), std::abs(p.z() - kFloorZ)));
  }
  EXPECT_LT(*Median(distances_m), 0.02);
}

void ExpectSame(const VioOutput& a, const VioOutput& b) {
  EXPECT_EQ(a.t, b.t);
  EXPECT_EQ(a.has_pose, b.has_pose);
  EXPECT_EQ(a.is_keyframe, b.is_keyframe);
  EXPECT_EQ(a.state.T_WB.p, b.state.T_WB.p);
  EXPECT_EQ(a.state.T_WB.q.coeffs(), b.state.T_WB.q.coeffs());
  EXPECT_EQ(a.state.v_WB, b.state.v_WB);
  EXPECT_EQ(a.sigma_p, b.sigma_p);
  EXPECT_EQ(a.num_constraints, b.num_constraints);
  ASSERT_EQ(a.mesh == nullptr, b.mesh == nullptr);
  if (!a.mesh) return;
  EXPECT_EQ(a.mesh->mesh.vertices, b.mesh->mesh.vertices);
  EXPECT_EQ(a.mesh->mesh.plane_ids, b.mesh->mesh.plane_ids);
}

TEST_F(ThreadedVioTest, GivesTheSameBitsAsOneThread) {
  ThreadedVio two(recording_->rig, ImuNoise{}, VioOptions{});
  std::vector<VioOutput> outputs;
  const auto append = [&](const std::vector<VioOutput>& ready) {
    outputs.insert(outputs.end(), ready.begin(), ready.end());
  };
  Feed(
      *recording_,
      [&](const ImuSample& sample) { two.AddImu(sample); },
      [&](const StereoFrame& frame) { append(two.AddStereo(frame)); });
  append(two.Finish());
  ASSERT_EQ(outputs.size(), outputs_->size());
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectSame(outputs[i], (*outputs_)[i]);
  }
  const RunResult result = two.TakeResult(), expected = one_->Result();
  ASSERT_TRUE(result.map && expected.map);
  EXPECT_EQ(result.map->vertices, expected.map->vertices);
  EXPECT_EQ(result.map->faces, expected.map->faces);
  EXPECT_EQ(result.map->plane_ids, expected.map->plane_ids);
  ASSERT_TRUE(result.planes && expected.planes);
  ASSERT_EQ(result.planes->size(), expected.planes->size());
  for (std::size_t i = 0; i < result.planes->size(); ++i) {
    const PlaneRecord &plane = (*result.planes)[i], &other = (*expected.planes)[i];
    EXPECT_EQ(plane.id, other.id);
    EXPECT_EQ(plane.plane_W.n, other.plane_W.n);
    EXPECT_EQ(plane.plane_W.d, other.plane_W.d);
  }
  EXPECT_EQ(result.window_keyframes.size(), expected.window_keyframes.size());
}

}  // namespace
}  // namespace facet
