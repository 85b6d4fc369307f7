// SPDX-License-Identifier: BSD-2-Clause
// The whole system on images of a wall and a floor that are painted here: pose, planes and map are
// right, and on two threads they are the same bit for bit. Also the run for the thread sanitizer.
#include "facet/pipeline/threaded_vio.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "facet/base/median.h"
#include "facet/base/types.h"
#include "facet/geometry/se3.h"
#include "facet/imu/imu_types.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/frontend/synthetic_image.h"

namespace facet {
namespace {

constexpr Timestamp kBegin{1'400'000'000'000'000'000};
constexpr Duration kFrameInterval{50'000'000};
constexpr Duration kImuInterval{5'000'000};
constexpr Timestamp kEnd{kBegin.ns + 3'500'000'000};
constexpr double kWallX = 2.5, kFloorZ = -0.8;

constexpr double kTexel_m = 0.006;  // about a pixel

cv::Mat MakeTexture() {
  constexpr int kTexels = 1024;
  return testing::Render(
      testing::WaveTexture(1), kTexels, kTexels, [](double x, double y) { return Vector2d(x, y); });
}

/// A wall ahead and the floor, seen by one camera that does not turn.
class Painter {
 public:
  Painter(const CameraModel& camera, const Matrix3d& R_WC) {
    for (int row = 0; row < camera.height(); ++row) {
      for (int column = 0; column < camera.width(); ++column) {
        const auto ray_C = camera.Unproject({column, row});
        rays_W_.push_back(ray_C ? Vector3d(R_WC * *ray_C) : Vector3d::UnitX());
      }
    }
    u_.create(camera.height(), camera.width(), CV_32FC1);
    v_.create(camera.height(), camera.width(), CV_32FC1);
  }

  cv::Mat Paint(const Vector3d& p_WC, const cv::Mat& texture) {
    for (std::size_t i = 0; i < rays_W_.size(); ++i) {
      const Vector3d& ray = rays_W_[i];
      const double to_wall = (kWallX - p_WC.x()) / ray.x();
      const double to_floor = ray.z() < 0 ? (kFloorZ - p_WC.z()) / ray.z() : 1e9;
      const Vector3d p = p_WC + std::min(to_wall, to_floor) * ray;
      const double along = to_wall < to_floor ? p.z() : p.x() + 7;
      u_.ptr<float>()[i] = static_cast<float>(512 + p.y() / kTexel_m);
      v_.ptr<float>()[i] = static_cast<float>(512 + along / kTexel_m);
    }
    cv::Mat image;
    cv::remap(texture, image, u_, v_, cv::INTER_LINEAR, cv::BORDER_WRAP);
    return image;
  }

 private:
  std::vector<Vector3d> rays_W_;
  cv::Mat u_, v_;
};

/// The body sways without turning; its left camera looks along x.
struct Sway {
  static constexpr double kX = 0.15, kY = 0.3, kZ = 0.1;           // [m]
  static constexpr double kRateX = 1.3, kRateY = 2, kRateZ = 1.7;  // [rad/s]

  static Vector3d Position(double t) {
    return {kX * std::sin(kRateX * t), kY * std::sin(kRateY * t), kZ * std::sin(kRateZ * t)};
  }
  static Vector3d Acceleration(double t) {
    const Vector3d p = Position(t);
    return {-kRateX * kRateX * p.x(), -kRateY * kRateY * p.y(), -kRateZ * kRateZ * p.z()};
  }
};

struct Recording {
  StereoRig rig = EurocRig();
  std::vector<StereoFrame> frames;
  std::vector<ImuSample> imu;
  SE3 T_WB0;  // where the body is at first
};

Recording MakeRecording() {
  Recording out;
  Matrix3d R_WC0;
  R_WC0 << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Matrix3d R_WB = R_WC0 * out.rig.T_BC[0].R().transpose();
  out.T_WB0 = {Quaterniond(R_WB), Sway::Position(0)};
  const cv::Mat texture = MakeTexture();
  Painter left(out.rig.cameras[0], R_WC0);
  Painter right(out.rig.cameras[1], R_WB * out.rig.T_BC[1].R());
  for (Timestamp t = kBegin; t < kEnd; t = t + kFrameInterval) {
    const SE3 T_WB(out.T_WB0.q, Sway::Position(ToSeconds(t - kBegin)));
    out.frames.push_back({t,
                          left.Paint(T_WB * out.rig.T_BC[0].p, texture),
                          right.Paint(T_WB * out.rig.T_BC[1].p, texture)});
  }
  for (Timestamp t = kBegin; t <= kEnd; t = t + kImuInterval) {
    const Vector3d force_W =
        Sway::Acceleration(ToSeconds(t - kBegin)) + kGravity * Vector3d::UnitZ();
    out.imu.push_back({t, Vector3d::Zero(), R_WB.transpose() * force_W});
  }
  return out;
}

/// Calls add_imu and add_stereo in the order of time.
template <class AddImu, class AddStereo>
void Feed(const Recording& recording, const AddImu& add_imu, const AddStereo& add_stereo) {
  std::size_t next = 0;
  for (const StereoFrame& frame : recording.frames) {
    for (; next < recording.imu.size() && recording.imu[next].t <= frame.t + kImuInterval; ++next)
      add_imu(recording.imu[next]);
    add_stereo(frame);
  }
}

class ThreadedVioTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    recording_ = new Recording(MakeRecording());
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

  static inline Recording* recording_ = nullptr;
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
  const RunResult result = two.Result(), expected = one_->Result();
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
