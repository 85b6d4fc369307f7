// SPDX-License-Identifier: BSD-2-Clause
// Two seconds at rest before a wall: what a node tells is what the odometry says, whatever comes.
#include "facet/robot/robot_node.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/facade/plain_calibration.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/testing/pipeline/painted_recording.h"
#include "facet/testing/wall_image.h"

namespace facet::robot {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 640, kHeight = 480;
constexpr std::int64_t kFrame_ns = 50'000'000, kImu_ns = 5'000'000;
constexpr int kFrames = 40;

api::Calibration TestCalibration() {
  api::Calibration calibration;
  for (api::Camera* camera : {&calibration.left, &calibration.right}) {
    camera->width = kWidth;
    camera->height = kHeight;
    camera->fx = camera->fy = 400;
    camera->cx = 320;
    camera->cy = 240;
    camera->T_BC.q = {{0.5, -0.5, 0.5, -0.5}};
  }
  calibration.left.T_BC.p[1] = 0.055;
  calibration.right.T_BC.p[1] = -0.055;
  return calibration;
}

class RecordingListener : public RobotListener {
 public:
  void OnOdometry(const OdometryOutput& output) override { Keep(odometry, output); }
  void OnPose(const PoseOutput& output) override { Keep(poses, output); }
  void OnPath(const std::vector<PathPose>& output) override { Keep(paths, output); }
  void OnMapTransform(const api::Pose& output) override { Keep(map_transforms, output); }
  void OnMesh(const api::Mesh& output) override { Keep(meshes, output); }
  void OnMap(std::int64_t, const std::vector<MapPartOutput>& output) override {
    Keep(parts, output);
  }
  void OnPlanes(const PlanesOutput& output) override { Keep(planes, output); }
  void OnClear() override { Keep(clears, 1); }
  void OnLog(LogLevel level, const std::string& text) override {
    const std::lock_guard lock(mutex_);
    log += (level == LogLevel::kError ? "E " : "- ") + text + "\n";
  }

  int num_told() const {
    const std::lock_guard lock(mutex_);
    return num_told_;
  }

  std::vector<OdometryOutput> odometry;
  std::vector<PoseOutput> poses;
  std::vector<std::vector<PathPose>> paths;
  std::vector<api::Pose> map_transforms;
  std::vector<api::Mesh> meshes;
  std::vector<std::vector<MapPartOutput>> parts;
  std::vector<PlanesOutput> planes;
  std::vector<int> clears;
  std::string log;

 private:
  template <class T>
  void Keep(std::vector<T>& kept, const T& output) {
    const std::lock_guard lock(mutex_);
    kept.push_back(output);
    ++num_told_;
  }
  mutable std::mutex mutex_;
  int num_told_ = 0;
};

class RobotNodeTest : public ::testing::Test {
 protected:
  RobotNodeTest() {
    options_.calibration = TestCalibration();
    options_.max_waiting_pairs = 100;
    options_.scene_period_s = 0.2;
    options_.silence_s = 3600;  // of the machine's clock, while the test waits
  }

  ReceivedImage Grey(std::int64_t t_ns, const std::vector<std::uint8_t>& pixels) const {
    return {t_ns, {"mono8", kWidth, kHeight, kWidth, false, pixels.data(), pixels.size()}, nullptr};
  }

  /// Samples and pairs of two seconds; the last sample is after the last pair.
  void Play(RobotNode& node, std::int64_t begin_ns = 0) {
    std::int64_t imu_ns = 0;
    for (std::int64_t t_ns = 0; t_ns < kFrames * kFrame_ns; t_ns += kFrame_ns) {
      for (; imu_ns <= t_ns + kImu_ns; imu_ns += kImu_ns)
        node.AddImu({begin_ns + imu_ns, {{0, 0, 0}}, {{0, 0, 9.81}}});
      node.AddImage(0, Grey(begin_ns + t_ns, left_));
      node.AddImage(1, Grey(begin_ns + t_ns, right_));
    }
  }

  static std::int64_t Value(RobotNode& node, const std::string& name) {
    for (const auto& [key, value] : node.Diagnose().values) {
      if (key == name) return std::stoll(value);
    }
    ADD_FAILURE() << "no value " << name;
    return -1;
  }

  /// Until every pair that was given is done.
  void Wait(RobotNode& node) const {
    for (int i = 0; i < 3000; ++i) {
      if (Value(node, "done pairs") + Value(node, "dropped pairs") >= Value(node, "pairs")) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    // What the threads still have to tell of the last ones.
    for (int before = -1, i = 0; before != listener_.num_told() && i < 60; ++i) {
      before = listener_.num_told();
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
  }

  const std::vector<std::uint8_t> left_ = testing::WallImage(kWidth, kHeight, 0),
                                  right_ = testing::WallImage(kWidth, kHeight, 20);
  RobotOptions options_;
  RecordingListener listener_;
};

TEST_F(RobotNodeTest, PosesAreThoseOfTheOdometry) {
  RobotNode node(options_, listener_);
  Play(node);
  Wait(node);
  api::Odometry odometry(TestCalibration());
  std::map<std::int64_t, api::State> expected;
  std::int64_t imu_ns = 0;
  for (std::int64_t t_ns = 0; t_ns < kFrames * kFrame_ns; t_ns += kFrame_ns) {
    for (; imu_ns <= t_ns + kImu_ns; imu_ns += kImu_ns)
      odometry.AddImu({imu_ns, {{0, 0, 0}}, {{0, 0, 9.81}}});
    const api::State state =
        odometry.AddStereo(t_ns, {left_.data(), kWidth, kHeight}, {right_.data(), kWidth, kHeight});
    if (state.has_pose) expected[t_ns] = state;
  }
  ASSERT_GT(expected.size(), 20u);
  ASSERT_EQ(listener_.poses.size(), expected.size());
  for (const PoseOutput& pose : listener_.poses) {
    ASSERT_EQ(expected.count(pose.t_ns), 1u);
    EXPECT_EQ(pose.T_odom_base.p, expected[pose.t_ns].T_WB.p);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(std::sqrt(pose.covariance[7 * i]), expected[pose.t_ns].sigma_p[i], 1e-12);
  }
  ASSERT_FALSE(listener_.meshes.empty());
  EXPECT_GT(listener_.meshes.back().faces.size(), 20u);
  EXPECT_EQ(listener_.meshes.back().faces, odometry.HorizonMesh().faces);
  EXPECT_FALSE(listener_.planes.empty());
  EXPECT_FALSE(listener_.paths.empty());
  ASSERT_EQ(listener_.map_transforms.size(), 1u) << "the identity, once";
  EXPECT_EQ(listener_.map_transforms[0].p, api::Pose().p);
  EXPECT_EQ(listener_.map_transforms[0].q, api::Pose().q);
  const Diagnosis diagnosis = node.Diagnose();
  EXPECT_NE(diagnosis.level, Diagnosis::Level::kError) << diagnosis.summary;
  EXPECT_EQ(Value(node, "dropped pairs") + Value(node, "lone images"), 0);
}

TEST_F(RobotNodeTest, OdometryComesWithEverySampleInTheFrameOfTheBase) {
  options_.T_base_imu.p = {{0.5, 0, 0.2}};
  RobotNode node(options_, listener_);
  Play(node);
  Wait(node);
  const std::size_t num_before = listener_.odometry.size();
  const std::int64_t last_ns = (kFrames - 1) * kFrame_ns;
  for (std::int64_t t_ns = last_ns + 2 * kImu_ns; t_ns <= last_ns + 12 * kImu_ns; t_ns += kImu_ns)
    node.AddImu({t_ns, {{0, 0, 0.1}}, {{0, 0, 9.81}}});
  ASSERT_EQ(listener_.odometry.size(), num_before + 11);
  const OdometryOutput& output = listener_.odometry.back();
  EXPECT_EQ(output.t_ns, last_ns + 12 * kImu_ns);
  EXPECT_NEAR(output.T_odom_base.p[0], -0.5, 0.01);
  EXPECT_NEAR(output.T_odom_base.p[2], -0.2, 0.01);
  EXPECT_NEAR(output.w_base[2], 0.1, 0.01);
  EXPECT_NEAR(output.v_base[1], -0.05, 0.02) << "the base is half a metre behind the axis";
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_GT(output.pose_covariance[7 * i], 0);
    EXPECT_GT(output.twist_covariance[7 * i], 0);
  }
  const double white = std::pow(1.6968e-4, 2) / 0.005;
  EXPECT_GE(output.twist_covariance[35], 0.9 * white);
}

TEST_F(RobotNodeTest, AClockThatGoesBackBeginsAnew) {
  RobotNode node(options_, listener_);
  constexpr std::int64_t kBegin_ns = 1'000'000'000'000;
  Play(node, kBegin_ns);
  Wait(node);
  const std::size_t num_poses = listener_.poses.size();
  ASSERT_GT(num_poses, 20u);
  Play(node, kBegin_ns);
  Wait(node);
  EXPECT_EQ(Value(node, "restarts"), 1);
  EXPECT_THAT(listener_.log, HasSubstr("gone back"));
  EXPECT_GT(listener_.poses.size(), num_poses + 20);
  EXPECT_LT(listener_.poses[num_poses].t_ns, kBegin_ns + 1'000'000'000);
  EXPECT_GE(listener_.clears.size(), 2u);
}

TEST_F(RobotNodeTest, OneStrayStampDoesNotRestart) {
  RobotNode node(options_, listener_);
  Play(node, 1'000'000'000'000);
  node.AddImu({5, {{0, 0, 0}}, {{0, 0, 9.81}}});
  node.AddImage(0, Grey(5, left_));
  EXPECT_EQ(Value(node, "restarts"), 0);
}

TEST_F(RobotNodeTest, OneStampOfTheFutureDoesNotRestart) {
  RobotNode node(options_, listener_);
  constexpr std::int64_t kLater_ns = 3'600'000'000'000;
  node.AddImu({kLater_ns / 2, {{0, 0, 0}}, {{0, 0, 9.81}}});
  node.AddImu({kLater_ns, {{0, 0, 0}}, {{0, 0, 9.81}}});
  Play(node, kLater_ns / 2);
  EXPECT_EQ(Value(node, "restarts"), 0);
}

TEST_F(RobotNodeTest, OneSampleIsToldOnce) {
  RobotNode node(options_, listener_);
  Play(node);
  Wait(node);
  const std::size_t num_before = listener_.odometry.size();
  const std::int64_t t_ns = kFrames * kFrame_ns;
  for (const std::int64_t stamp_ns : {t_ns, t_ns, t_ns - kImu_ns})
    node.AddImu({stamp_ns, {{0, 0, 0}}, {{0, 0, 9.81}}});
  EXPECT_EQ(listener_.odometry.size(), num_before + 1);
}

TEST_F(RobotNodeTest, WhatCannotBeUsedIsCountedAndSaid) {
  RobotNode node(options_, listener_);
  Play(node);
  ReceivedImage small = Grey(kFrames * kFrame_ns, left_);
  small.image.num_bytes = 1000;
  node.AddImage(0, small);
  node.AddImage(1, Grey(kFrames * kFrame_ns, right_));
  EXPECT_EQ(Value(node, "bad images"), 1);
  EXPECT_THAT(listener_.log, HasSubstr("E left image: an image of 640 x 480"));
  ReceivedImage half = Grey((kFrames + 1) * kFrame_ns, right_);
  half.image.height = kHeight / 2;
  node.AddImage(0, Grey((kFrames + 1) * kFrame_ns, left_));
  node.AddImage(1, half);
  EXPECT_EQ(Value(node, "bad images"), 2);
  EXPECT_THAT(listener_.log, HasSubstr("right image: it has 640 x 240 pixels"));
  node.AddImu({(kFrames + 2) * kFrame_ns,
               {{std::numeric_limits<double>::quiet_NaN(), 0, 0}},
               {{0, 0, 9.81}}});
  EXPECT_EQ(Value(node, "bad IMU samples"), 1);
  Wait(node);
  EXPECT_EQ(Value(node, "done pairs"), kFrames + 1) << "the frame with one eye is used";
}

TEST_F(RobotNodeTest, StartsStopsAndResets) {
  options_.is_started = false;
  RobotNode node(options_, listener_);
  EXPECT_EQ(node.Diagnose().summary, "stopped");
  Play(node);
  EXPECT_EQ(Value(node, "pairs"), 0);
  EXPECT_FALSE(node.Stop().is_done);
  EXPECT_FALSE(node.Reset().is_done);
  EXPECT_TRUE(node.Start().is_done);
  EXPECT_FALSE(node.Start().is_done);
  Play(node);
  Wait(node);
  const std::size_t num_poses = listener_.poses.size();
  EXPECT_GT(num_poses, 20u);
  EXPECT_TRUE(node.Reset().is_done);
  Play(node);
  Wait(node);
  EXPECT_EQ(listener_.poses.size(), 2 * num_poses) << "a reset is a beginning";
  EXPECT_TRUE(node.Stop().is_done);
  EXPECT_EQ(Value(node, "done pairs"), 2 * kFrames) << "totals stay";
}

TEST_F(RobotNodeTest, CalibratesFromCameraInfo) {
  api::CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.K = {{400, 0, 320, 0, 400, 240, 0, 0, 1}};
  info.P = {{400, 0, 320, 0, 0, 400, 240, 0, 0, 0, 1, 0}};
  options_.calibration.reset();
  options_.mount.T_BC = TestCalibration().left.T_BC;
  RobotNode node(options_, listener_);
  EXPECT_EQ(node.Diagnose().summary, "waiting for camera_info of both cameras");
  node.AddCameraInfo(0, info);
  node.AddCameraInfo(1, info);
  EXPECT_THAT(node.Diagnose().summary, HasSubstr("no baseline"));
  info.P[3] = -44;
  node.AddCameraInfo(1, info);
  Play(node);
  Wait(node);
  EXPECT_GT(listener_.poses.size(), 20u);
}

std::string ErrorOf(const RobotOptions& options) {
  RecordingListener listener;
  try {
    const RobotNode node(options, listener);
  } catch (const api::Error& error) {
    return error.what();
  }
  return "no error";
}

// A painted recording, and the second half of it as a later run that looks for itself.
TEST_F(RobotNodeTest, TellsWhereItsWorldIsInTheMapOfAnEarlierRun) {
  const facet::testing::PaintedRecording recording = facet::testing::PaintRecording();
  const TempFolder folder;
  options_.calibration = api::PlainCalibration(recording.rig, ImuNoise());
  api::Odometry::Options keeping;
  keeping.keeps_map = true;
  api::Odometry first(*options_.calibration, keeping);
  std::map<std::int64_t, api::State> then;
  const auto sample_of = [](const facet::ImuSample& imu) {
    return api::ImuSample{imu.t.ns,
                          {{imu.gyro.x(), imu.gyro.y(), imu.gyro.z()}},
                          {{imu.accel.x(), imu.accel.y(), imu.accel.z()}}};
  };
  const auto view_of = [](const cv::Mat& image) {
    return api::Image{image.data, image.cols, image.rows};
  };
  facet::testing::Feed(
      recording,
      [&](const facet::ImuSample& imu) { first.AddImu(sample_of(imu)); },
      [&](const StereoFrame& frame) {
        then[frame.t.ns] = first.AddStereo(frame.t.ns, view_of(frame.left), view_of(frame.right));
      });
  options_.known_map = (folder / "map").string();
  ASSERT_TRUE(first.SaveMap(options_.known_map));

  RobotNode node(options_, listener_);
  constexpr std::size_t kFirstFrame = 24;
  const auto image_of = [](const StereoFrame& frame, const cv::Mat& image) {
    const std::size_t size = image.total();
    return ReceivedImage{frame.t.ns,
                         {"mono8",
                          image.cols,
                          image.rows,
                          static_cast<std::size_t>(image.cols),
                          false,
                          image.data,
                          size},
                         nullptr};
  };
  facet::testing::Feed(
      recording,
      [&](const facet::ImuSample& imu) {
        if (imu.t >= recording.frames[kFirstFrame].t) node.AddImu(sample_of(imu));
      },
      [&](const StereoFrame& frame) {
        if (frame.t < recording.frames[kFirstFrame].t) return;
        node.AddImage(0, image_of(frame, frame.left));
        node.AddImage(1, image_of(frame, frame.right));
      });
  Wait(node);
  ASSERT_FALSE(listener_.map_transforms.empty());
  ASSERT_FALSE(listener_.poses.empty());
  const PoseOutput& pose = listener_.poses.back();
  const SE3 T_map_odom = api::Internal(listener_.map_transforms.back(), "map");
  const SE3 T_odom_base = api::Internal(pose.T_odom_base, "odom");
  const SE3 expected = api::Internal(then.at(pose.t_ns).T_WB, "then");
  EXPECT_LT(((T_map_odom * T_odom_base).p - expected.p).norm(), 0.03);
  EXPECT_GT((T_odom_base.p - expected.p).norm(), 0.05) << "its world began elsewhere";
}

TEST(RobotOptionsTest, SaysWhatIsWrong) {
  RobotOptions options;
  EXPECT_EQ(ErrorOf(options), "no error");
  options.pair_tolerance_s = 1;
  EXPECT_THAT(ErrorOf(options), HasSubstr("pair_tolerance_s"));
  options = {};
  options.overrides = {"mesh.colour=red"};
  EXPECT_THAT(ErrorOf(options), HasSubstr("mesh.colour"));
  options = {};
  options.T_base_imu.q = {{2, 0, 0, 0}};
  EXPECT_THAT(ErrorOf(options), HasSubstr("T_base_imu"));
  options = {};
  options.sample_bits = 3;
  EXPECT_THAT(ErrorOf(options), HasSubstr("sample_bits"));
}

}  // namespace
}  // namespace facet::robot
