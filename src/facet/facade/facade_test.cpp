// SPDX-License-Identifier: BSD-2-Clause
// The facade gives what the pipeline gives, and says what is wrong. That facet/facet.h is C++17 and
// links into a shared library is tested by package_test.
#include <algorithm>
#include <atomic>
#include <limits>
#include <map>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/calibration/calibration_vector.h"
#include "facet/facade/plain_calibration.h"
#include "facet/facet.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/testing/pipeline/painted_recording.h"
#include "facet/testing/wall_image.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 640, kHeight = 480;
constexpr std::int64_t kFrameNs = 50'000'000, kImuNs = 5'000'000;

api::Camera CameraAt(double y_m) {
  api::Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = camera.fy = 400;
  camera.cx = 320;
  camera.cy = 240;
  camera.T_BC.p = {0, y_m, 0};
  camera.T_BC.q = {0.5, -0.5, 0.5, -0.5};
  return camera;
}

api::Calibration TestCalibration() {
  api::Calibration calibration;
  calibration.left = CameraAt(0.055);
  calibration.right = CameraAt(-0.055);
  return calibration;
}

class FacadeTest : public ::testing::Test {
 protected:
  /// Two seconds at rest; calls `use` after each frame.
  template <class Use>
  void Fly(api::Odometry& odometry, const Use& use) {
    std::int64_t imu_ns = 0;
    for (std::int64_t t_ns = 0; t_ns < 40 * kFrameNs; t_ns += kFrameNs) {
      for (; imu_ns <= t_ns + kImuNs; imu_ns += kImuNs)
        odometry.AddImu({imu_ns, {0, 0, 0}, {0, 0, 9.81}});
      use(odometry.AddStereo(
          t_ns, {left_.data(), kWidth, kHeight}, {right_.data(), kWidth, kHeight}));
    }
  }

  std::vector<std::uint8_t> left_ = testing::WallImage(kWidth, kHeight, 0),
                            right_ = testing::WallImage(kWidth, kHeight, 20);  // at 2.2 m
};

TEST_F(FacadeTest, GivesWhatThePipelineGives) {
  api::Odometry odometry(TestCalibration());
  StereoRig rig;
  CameraIntrinsics k;
  k.width = kWidth;
  k.height = kHeight;
  k.fx = k.fy = 400;
  k.cx = 320;
  k.cy = 240;
  for (std::size_t c = 0; c < 2; ++c) {
    rig.cameras[c] = CameraModel(k);
    rig.T_BC[c] = {Quaterniond(0.5, -0.5, 0.5, -0.5), Vector3d(0, c == 0 ? 0.055 : -0.055, 0)};
  }
  VioPipeline pipeline(rig, ImuNoise(), VioOptions());
  const cv::Mat left(kHeight, kWidth, CV_8UC1, left_.data());
  const cv::Mat right(kHeight, kWidth, CV_8UC1, right_.data());
  std::int64_t imu_ns = 0;
  int num_poses = 0;
  Fly(odometry, [&](const api::State& state) {
    for (; imu_ns <= state.t_ns + kImuNs; imu_ns += kImuNs)
      pipeline.AddImu({{imu_ns}, Vector3d::Zero(), Vector3d(0, 0, 9.81)});
    const VioOutput output = pipeline.AddStereo({{state.t_ns}, left, right});
    ASSERT_EQ(state.has_pose, output.has_pose);
    EXPECT_EQ(
        state.T_WB.p,
        (api::Vec3{output.state.T_WB.p.x(), output.state.T_WB.p.y(), output.state.T_WB.p.z()}));
    EXPECT_EQ(state.sigma_theta,
              (api::Vec3{output.sigma_theta.x(), output.sigma_theta.y(), output.sigma_theta.z()}));
    EXPECT_EQ(state.covariance[15 * 3 + 4], output.covariance(3, 4));
    for (std::size_t i = 0; i < 3 && output.has_pose; ++i)
      EXPECT_NEAR(std::sqrt(state.covariance[16 * (3 + i)]), state.sigma_p[i], 1e-15);
    num_poses += output.has_pose ? 1 : 0;
  });
  EXPECT_GT(num_poses, 20);
  EXPECT_EQ(odometry.Planes().size(), pipeline.Result().planes->size());
  EXPECT_EQ(odometry.Map().faces, pipeline.Result().map->faces);
}

TEST_F(FacadeTest, TheWallIsAMeshAndThePoseComesFirst) {
  api::Odometry odometry(TestCalibration());
  EXPECT_TRUE(odometry.HorizonMesh().faces.empty());
  int num_observed = 0;
  odometry.OnPose([&](const api::State&) { ++num_observed; });
  int num_frames = 0;
  Fly(odometry, [&](const api::State&) { EXPECT_EQ(num_observed, ++num_frames); });
  const api::Mesh mesh = odometry.HorizonMesh();
  ASSERT_GT(mesh.faces.size(), 20u);
  EXPECT_EQ(mesh.plane_ids.size(), mesh.faces.size());
  double mean_x = 0;
  for (const api::Vec3& vertex : mesh.vertices)
    mean_x += vertex[0] / static_cast<double>(mesh.vertices.size());
  EXPECT_NEAR(mean_x, 2.2, 0.05);
}

TEST_F(FacadeTest, LiveOdometryPredictsBetweenPairs) {
  api::LiveOdometry::Options options;
  options.max_waiting_pairs = 100;
  options.T_BF.p = {0.5, 0, 0};
  options.world = api::LiveOdometry::World::kNed;
  std::atomic<int> num_poses = 0;
  api::LiveOdometry odometry(
      TestCalibration(), options, [&](const api::State& state) { num_poses += state.has_pose; });
  EXPECT_FALSE(odometry.PredictAt(0));
  std::int64_t imu_ns = 0, t_ns = 0;
  for (; t_ns < 40 * kFrameNs; t_ns += kFrameNs) {
    for (; imu_ns <= t_ns + kImuNs; imu_ns += kImuNs)
      odometry.AddImu({imu_ns, {0, 0, 0}, {0, 0, 9.81}});
    std::vector<std::uint8_t> left = left_, right = right_;
    odometry.AddStereo(t_ns, {left.data(), kWidth, kHeight}, {right.data(), kWidth, kHeight});
    std::fill(left.begin(), left.end(), std::uint8_t{0});
  }
  EXPECT_TRUE(odometry.Map().faces.empty()) << "not before the end";
  odometry.Finish();
  odometry.Finish();
  EXPECT_GT(odometry.Map().faces.size(), 20u);
  EXPECT_GT(num_poses, 20);
  EXPECT_EQ(odometry.counts().done_pairs, 40);
  EXPECT_EQ(odometry.counts().dropped_pairs + odometry.counts().dropped_imu, 0);
  EXPECT_GT(odometry.HorizonMesh().faces.size(), 20u);
  const std::int64_t last_ns = t_ns - kFrameNs;
  EXPECT_FALSE(odometry.PredictAt(last_ns - 1));
  const auto motion = odometry.PredictAt(last_ns + 7'000'000);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->status, api::Status::kOk);
  EXPECT_NEAR(motion->since_pair_s, 0.007, 1e-9);
  EXPECT_NEAR(motion->since_imu_s, 0.002, 1e-9);
  EXPECT_NEAR(motion->T_WF.p[0], 0, 0.01) << "x is W's y";
  EXPECT_NEAR(motion->T_WF.p[1], 0.5, 0.01);
  EXPECT_NEAR(motion->T_WF.p[2], 0, 0.01);
  for (const double v : motion->v_WF)
    EXPECT_NEAR(v, 0, 0.02);
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_GT(motion->covariance[16 * i], 0);
    for (std::size_t j = 0; j < 15; ++j)
      EXPECT_NEAR(motion->covariance[15 * i + j], motion->covariance[15 * j + i], 1e-12);
  }
}

TEST_F(FacadeTest, SceneChangesComeOnRequest) {
  std::atomic<int> num_meshes = 0;
  api::LiveOdometry::Options options;
  options.max_waiting_pairs = 100;
  options.on_mesh = [&](std::int64_t) { ++num_meshes; };
  api::LiveOdometry odometry(TestCalibration(), options);
  odometry.RequestScene();
  EXPECT_FALSE(odometry.TakeScene());
  std::int64_t imu_ns = 0;
  for (std::int64_t t_ns = 0; t_ns < 40 * kFrameNs; t_ns += kFrameNs) {
    for (; imu_ns <= t_ns + kImuNs; imu_ns += kImuNs)
      odometry.AddImu({imu_ns, {0, 0, 0}, {0, 0, 9.81}});
    odometry.AddStereo(t_ns, {left_.data(), kWidth, kHeight}, {right_.data(), kWidth, kHeight});
  }
  odometry.Finish();
  EXPECT_GT(num_meshes, 2);
  EXPECT_EQ(odometry.HorizonMesh().t_ns % kFrameNs, 0);
  EXPECT_EQ(odometry.HorizonMesh().colours.size(), odometry.HorizonMesh().vertices.size());
  const auto changes = odometry.TakeScene();
  ASSERT_TRUE(changes) << "one was requested before the first keyframe";
  EXPECT_FALSE(changes->is_partial);
  EXPECT_FALSE(odometry.TakeScene()) << "nothing more was requested";
}

// The same numbers as `facet run` uses.
TEST(ImageDecoderTest, DecodesWhatDriversSend) {
  api::ImageDecoder decoder;
  const std::vector<std::uint8_t> bgr = {10, 20, 30, 200, 100, 0};
  api::EncodedImage image{"bgr8", 2, 1, 6, false, bgr.data(), bgr.size()};
  const api::Image grey = decoder.Decode(image);
  ASSERT_EQ(grey.width * 10 + grey.height, 21);
  EXPECT_NEAR(grey.pixels[0], 0.114 * 10 + 0.587 * 20 + 0.299 * 30, 0.51);
  EXPECT_NEAR(grey.pixels[1], 0.114 * 200 + 0.587 * 100, 0.51);
  image.num_bytes = 5;
  EXPECT_THROW(decoder.Decode(image), api::Error);
  EXPECT_EQ(grey.pixels[1], decoder.Decode({"bgr8", 1, 1, 3, false, bgr.data() + 3, 3}).pixels[0]);
  image.encoding = "";
  EXPECT_THROW(decoder.Decode(image), api::Error) << "no file";
  EXPECT_THROW(decoder.Decode({}), api::Error);
  EXPECT_THROW(api::ImageDecoder(4), api::Error);
}

api::CameraInfo Info() {
  api::CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = "plumb_bob";
  info.D = {0.1, -0.05, 0.001, 0.002, 0};
  info.K = {400, 0, 320, 0, 410, 240, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {400, 0, 320, 0, 0, 400, 240, 0, 0, 0, 1, 0};
  return info;
}

std::string ErrorOfInfo(const api::CameraInfo& left,
                        const api::CameraInfo& right,
                        const api::CameraMount& mount) {
  try {
    api::CalibrationFromCameraInfo(left, right, mount);
  } catch (const api::Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(CameraInfoTest, BaselineAndRotationComeFromRAndP) {
  const api::CameraInfo left = Info();
  api::CameraInfo right = Info();
  right.P[3] = -44;                        // 0.11 m
  right.R = {0, 1, 0, -1, 0, 0, 0, 0, 1};  // x of the rectified camera is y of the raw one
  api::CameraMount mount;
  mount.T_BC.p = {1, 2, 3};
  const api::Calibration raw = api::CalibrationFromCameraInfo(left, right, mount);
  EXPECT_EQ(raw.left.distortion, api::Camera::Distortion::kRadialTangential);
  EXPECT_EQ(raw.left.fy, 410);
  EXPECT_NEAR(raw.right.T_BC.p[0], 1.11, 1e-9);
  EXPECT_NEAR(raw.right.T_BC.q[3], -raw.right.T_BC.q[0], 1e-9) << "-90 deg about z takes y to x";
  mount.are_rectified = true;
  const api::Calibration rectified = api::CalibrationFromCameraInfo(left, right, mount);
  EXPECT_EQ(rectified.left.distortion, api::Camera::Distortion::kNone);
  EXPECT_EQ(rectified.left.fy, 400);
  EXPECT_NEAR(rectified.right.T_BC.p[0], 1.11, 1e-9);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(rectified.right.T_BC.q[i], rectified.left.T_BC.q[i], 1e-9) << "rectified: parallel";
}

TEST(CameraInfoTest, SaysWhatIsMissing) {
  api::CameraMount mount;
  EXPECT_THAT(ErrorOfInfo(Info(), Info(), mount), HasSubstr("no baseline"));
  mount.T_C0C1 = api::Pose{{0.1, 0, 0}, {1, 0, 0, 0}};
  EXPECT_EQ(ErrorOfInfo(Info(), Info(), mount), "no error");
  api::CameraInfo strange = Info();
  strange.distortion_model = "cubist";
  EXPECT_THAT(ErrorOfInfo(Info(), strange, mount), HasSubstr("'cubist'"));
  mount.imu_noise = "nowhere.yaml";
  EXPECT_THAT(ErrorOfInfo(Info(), Info(), mount), HasSubstr("nowhere.yaml"));
}

std::string ErrorOfLive(const api::LiveOdometry::Options& options) {
  try {
    api::LiveOdometry odometry(TestCalibration(), options);
  } catch (const api::Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(FacadeErrorTest, SaysWhatIsWrongWithLiveOptions) {
  api::LiveOdometry::Options options;
  EXPECT_EQ(ErrorOfLive(options), "no error");
  options.smoothing_s = -1;
  EXPECT_THAT(ErrorOfLive(options), HasSubstr("smoothing_s"));
  options = {};
  options.max_age_s = 0;
  EXPECT_THAT(ErrorOfLive(options), HasSubstr("max_age_s"));
  options = {};
  options.max_waiting_pairs = 0;
  EXPECT_THAT(ErrorOfLive(options), HasSubstr("max_waiting_pairs"));
  options = {};
  options.T_BF.q = {0, 0, 0, 0};
  EXPECT_THAT(ErrorOfLive(options), HasSubstr("T_BF: the quaternion"));
  options = {};
  options.T_BF.p[1] = std::nan("");
  EXPECT_THAT(ErrorOfLive(options), HasSubstr("T_BF: the position"));
  options = {};
  options.overrides = {"frontend.max_feature=7"};
  EXPECT_THAT(ErrorOfLive(options), HasSubstr("unknown key"));
}

/// What both runs of the test below see: the first one all of it, the second from the middle on.
class MapTest : public ::testing::Test {
 protected:
  static api::Image ViewOf(const cv::Mat& image) { return {image.data, image.cols, image.rows}; }

  /// States by stamp.
  std::map<std::int64_t, api::State> Fly(api::Odometry& odometry, std::size_t first_frame) const {
    std::map<std::int64_t, api::State> states;
    std::size_t next = 0;
    for (std::size_t i = first_frame; i < recording_.frames.size(); ++i) {
      const StereoFrame& frame = recording_.frames[i];
      for (; next < recording_.imu.size() &&
             recording_.imu[next].t <= frame.t + testing::kImuInterval;
           ++next) {
        const facet::ImuSample& imu = recording_.imu[next];
        if (imu.t < recording_.frames[first_frame].t) continue;
        odometry.AddImu({imu.t.ns,
                         {imu.gyro.x(), imu.gyro.y(), imu.gyro.z()},
                         {imu.accel.x(), imu.accel.y(), imu.accel.z()}});
      }
      states[frame.t.ns] = odometry.AddStereo(frame.t.ns, ViewOf(frame.left), ViewOf(frame.right));
    }
    return states;
  }

  testing::PaintedRecording recording_ = testing::PaintRecording();
  api::Calibration calibration_ = api::PlainCalibration(recording_.rig, ImuNoise());
};

Vector3d InMap(const api::State& state) {
  const auto& [w, x, y, z] = state.T_MW.q;
  const auto vector = [](const api::Vec3& v) { return Vector3d(v[0], v[1], v[2]); };
  return Quaterniond(w, x, y, z) * vector(state.T_WB.p) + vector(state.T_MW.p);
}

TEST_F(MapTest, ALaterRunKnowsWhereItIsInTheMapOfTheFirst) {
  TempFolder folder;
  const std::string map = (folder / "map").string();
  api::Odometry::Options options;
  options.keeps_map = true;
  api::Odometry first(calibration_, options);
  EXPECT_FALSE(first.SaveMap(map)) << "no places yet";
  const auto then = Fly(first, 0);
  ASSERT_TRUE(first.SaveMap(map));
  EXPECT_THROW(first.SaveMap(map), api::Error) << "that of another run";
  EXPECT_THROW(api::Odometry(calibration_).SaveMap(map), api::Error);

  options.known_map = map;
  api::Odometry later(calibration_, options);
  int num_in_map = 0;
  bool was_in_map = false;
  for (const auto& [t_ns, state] : Fly(later, 24)) {
    EXPECT_GE(state.is_in_map, was_in_map);
    was_in_map = state.is_in_map;
    if (!state.has_pose || !state.is_in_map) continue;
    ++num_in_map;
    EXPECT_LT((InMap(state) - InMap(then.at(t_ns))).norm(), 0.03) << t_ns;
  }
  EXPECT_GT(num_in_map, 10);
  EXPECT_TRUE(later.SaveMap(map)) << "the known map, with this run";
  options.known_map = (folder / "nowhere").string();
  EXPECT_THROW(api::Odometry(calibration_, options), api::Error);
}

TEST_F(FacadeTest, ImagesMayGoAfterTheCall) {
  api::Odometry odometry(TestCalibration());
  bool has_pose = false;
  std::int64_t imu_ns = 0;
  for (std::int64_t t_ns = 0; t_ns < 40 * kFrameNs; t_ns += kFrameNs) {
    for (; imu_ns <= t_ns + kImuNs; imu_ns += kImuNs)
      odometry.AddImu({imu_ns, {0, 0, 0}, {0, 0, 9.81}});
    std::vector<std::uint8_t> left = left_, right = right_;
    has_pose =
        odometry.AddStereo(t_ns, {left.data(), kWidth, kHeight}, {right.data(), kWidth, kHeight})
            .has_pose;
    std::fill(left.begin(), left.end(), std::uint8_t{0});
    std::fill(right.begin(), right.end(), std::uint8_t{0});
  }
  EXPECT_TRUE(has_pose);
}

// A live run has no file whose lines could be sorted.
TEST_F(FacadeTest, OneImuStampFarInTheFutureDoesNotStopTheImu) {
  api::Odometry odometry(TestCalibration());
  api::State last;
  int num_frames = 0;
  Fly(odometry, [&](const api::State& state) {
    last = state;
    if (++num_frames == 20)
      odometry.AddImu({state.t_ns + 3'600'000'000'000, {0, 0, 0}, {0, 0, 9.81}});
  });
  EXPECT_EQ(last.status, api::Status::kOk) << last.reason;
  EXPECT_TRUE(last.has_pose);
}

TEST_F(FacadeTest, MissingImagesAreNoCrash) {
  api::Odometry odometry(TestCalibration());
  const api::State state = odometry.AddStereo(0, {}, {});
  EXPECT_FALSE(state.has_pose);
  EXPECT_EQ(state.status, api::Status::kInitialising);
}

std::string ErrorOf(const api::Calibration& calibration,
                    const api::Odometry::Options& options = {}) {
  try {
    api::Odometry odometry(calibration, options);
  } catch (const api::Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(FacadeErrorTest, SaysWhatIsWrong) {
  api::Calibration no_focal = TestCalibration();
  no_focal.right.fx = 0;
  EXPECT_THAT(ErrorOf(no_focal), HasSubstr("right camera: "));
  api::Calibration no_baseline = TestCalibration();
  no_baseline.right.T_BC = no_baseline.left.T_BC;
  EXPECT_THAT(ErrorOf(no_baseline), HasSubstr("same place"));
  api::Calibration no_rotation = TestCalibration();
  no_rotation.left.T_BC.q = {0, 0, 0, 0};
  EXPECT_THAT(ErrorOf(no_rotation), HasSubstr("quaternion"));
  api::Calibration no_noise = TestCalibration();
  no_noise.gyro_noise = 0;
  EXPECT_THAT(ErrorOf(no_noise), HasSubstr("noise"));
  api::Calibration absurd = TestCalibration();
  absurd.time_offset_s = 1e300;
  EXPECT_THAT(ErrorOf(absurd), HasSubstr("time_offset_s"));
  absurd = TestCalibration();
  absurd.right.T_BC.p[0] = 1e300;
  EXPECT_THAT(ErrorOf(absurd), HasSubstr("T_BC"));
  absurd = TestCalibration();
  absurd.accel_walk = std::numeric_limits<double>::infinity();
  EXPECT_THAT(ErrorOf(absurd), HasSubstr("noise"));
  absurd = TestCalibration();
  absurd.gyro_scale[1] = 2;
  EXPECT_THAT(ErrorOf(absurd), HasSubstr("gyro_scale"));
  absurd = TestCalibration();
  absurd.covariance = {1, 2, 3};
  EXPECT_THAT(ErrorOf(absurd), HasSubstr("covariance: neither empty"));
  absurd.covariance.assign(kNumCalibration * kNumCalibration, 0);
  EXPECT_THAT(ErrorOf(absurd), HasSubstr("covariance: a covariance has a positive diagonal"));
  api::Odometry::Options options;
  options.overrides = {"frontend.klt.simd=neon512"};
  EXPECT_THAT(ErrorOf(TestCalibration(), options), HasSubstr("frontend.klt.simd"));
  options.overrides = {"frontend.max_feature=7"};
  EXPECT_THAT(ErrorOf(TestCalibration(), options), HasSubstr("unknown key"));
  options = {"nowhere.yaml", {}};
  EXPECT_THAT(ErrorOf(TestCalibration(), options), HasSubstr("nowhere.yaml"));
  EXPECT_THROW(api::ReadCalibration("/nowhere"), api::Error);
}

TEST(FacadeErrorTest, SaysWhichOptionsHaveNoEffectAnyMore) {
  api::Odometry::Options options;
  options.overrides = {"mesh.map.truncation_m=0.16", "frontend.max_features=100"};
  const api::Odometry odometry(TestCalibration(), options);
  ASSERT_EQ(odometry.Notices().size(), 1u);
  EXPECT_THAT(odometry.Notices()[0], HasSubstr("truncation_m is now twice mesh.map.voxel_m"));
  EXPECT_TRUE(api::Odometry(TestCalibration()).Notices().empty());
}

TEST(FacadeErrorTest, ReadsTheCalibrationOfASequence) {
  TempFolder folder;
  WriteTestSequence(folder / "seq");
  const api::Calibration calibration = api::ReadCalibration((folder / "seq").string());
  EXPECT_EQ(calibration.left.width, 160);
  EXPECT_EQ(ErrorOf(calibration), "no error");
  EXPECT_THAT(api::Version(), HasSubstr("0."));
}

// calibration.yaml of a run has the covariance; a controller that goes on with it has the same.
TEST(FacadeErrorTest, WhatAFormerRunEstimatedIsHandedOn) {
  StereoRig rig;
  rig.T_BC[1].p = Vector3d(0, -0.11, 0);
  rig.gyro_scale = Vector3d(0.003, -0.001, 0.002);
  rig.lens_modes[1](3) = 0.07;
  CalibrationMatrix A = CalibrationMatrix::Identity();
  A(3, 1) = 0.25;
  rig.covariance = std::make_shared<const MatrixXd>(A * A.transpose());
  const api::Calibration plain = api::PlainCalibration(rig, ImuNoise());
  EXPECT_EQ(plain.gyro_scale, (api::Vec3{0.003, -0.001, 0.002}));
  EXPECT_EQ(plain.left.lens_modes[3], 0);
  EXPECT_EQ(plain.right.lens_modes[3], 0.07);
  ASSERT_EQ(plain.covariance.size(), static_cast<std::size_t>(rig.covariance->size()));
  EXPECT_EQ(plain.covariance[3 * kNumCalibration + 1], 0.25);
  api::Calibration usable = TestCalibration();
  usable.gyro_scale = plain.gyro_scale;
  usable.covariance = plain.covariance;
  usable.right.lens_modes = plain.right.lens_modes;
  EXPECT_EQ(ErrorOf(usable), "no error");
  usable.right.lens_modes[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorOf(usable), HasSubstr("lens_modes"));
  usable.right.lens_modes[5] = 21;
  EXPECT_THAT(ErrorOf(usable), HasSubstr("lens_modes"));
}

}  // namespace
}  // namespace facet
