// SPDX-License-Identifier: BSD-2-Clause
// The whole front end and the stereo matcher on a rendered textured wall with known geometry.
#include "facet/frontend/stereo_frontend.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory_resource>
#include <optional>
#include <set>
#include <unordered_map>

#include <gtest/gtest.h>

#include "facet/frontend/stereo_matcher.h"
#include "facet/frontend/temporal_tracker.h"
#include "facet/geometry/so3.h"
#include "facet/testing/frontend/synthetic_image.h"

namespace facet {
namespace {

using testing::Render;
using testing::WaveTexture;

constexpr int kImageWidth = 376, kImageHeight = 240;
constexpr double kFrameInterval = 0.05;

StereoRig MakeRig() {
  CameraIntrinsics k;
  k.width = kImageWidth;
  k.height = kImageHeight;
  k.fx = k.fy = 230;
  k.cx = 184;
  k.cy = 121;
  k.distortion = DistortionModel::kRadialTangential;
  k.coefficients = {-0.28, 0.07, 2e-4, 2e-5};
  StereoRig rig;
  rig.cameras = {CameraModel(k), CameraModel(k)};
  const Quaterniond q = ExpSO3(Vector3d(0.01, -0.02, 1.5));
  rig.T_BC[0] = SE3(q, Vector3d(0.02, -0.05, 0.01));
  // 0.11 m along x of the left camera, slightly turned.
  rig.T_BC[1] = rig.T_BC[0] * SE3(ExpSO3(Vector3d(0.003, 0.01, -0.012)), Vector3d(0.11, 0.001, 0));
  return rig;
}

// A textured wall through (0, 0, depth) of the world; the world is the first left camera.
struct Wall {
  WaveTexture texture{8, 0.55};
  Vector3d normal = Vector3d(0.15, -0.1, 1).normalized();
  double depth = 2;

  double InverseDistance(const SE3& T_WC, const Vector3d& ray) const {
    const double distance = normal.z() * depth - normal.dot(T_WC.p);
    return normal.dot(T_WC.q * ray) / distance;
  }

  static std::vector<Vector3d> Rays(const CameraModel& camera) {
    std::vector<Vector3d> rays;
    for (int i = 0; i < kImageWidth * kImageHeight; ++i) {
      rays.push_back(*camera.Unproject(Vector2d(i % kImageWidth, i / kImageWidth)));
    }
    return rays;
  }

  cv::Mat See(const CameraModel& camera,
              const SE3& T_WC,
              double gain = 1,
              double noise = 1.5) const {
    const double texels_per_m = camera.mean_focal_px() / depth;
    static const std::vector<Vector3d> rays = Rays(camera);  // both cameras have the same
    const auto map = [&](double x, double y) -> Vector2d {
      const Vector3d& ray = rays[static_cast<std::size_t>(y * kImageWidth + x)];
      const Vector3d p_W = T_WC * (ray / InverseDistance(T_WC, ray));
      return texels_per_m * p_W.head<2>();
    };
    return Render(texture, kImageWidth, kImageHeight, map, gain, 0, noise);
  }
};

class FrontendTest : public ::testing::Test {
 protected:
  static SE3 PoseAt(int i) {
    const double t = kFrameInterval * i;
    return {ExpSO3(Vector3d(0.05 * std::sin(2 * t), 0.06 * std::sin(1.5 * t), 0.1 * t)),
            Vector3d(0.3 * t, 0.1 * std::sin(3 * t), 0.15 * t)};
  }

  // Body pose in the world of the wall.
  SE3 BodyAt(int i) const { return PoseAt(i) * rig_.T_BC[0].Inverse(); }

  // Rendered once for all tests.
  StereoFrame FrameAt(int i) const {
    static std::map<int, StereoFrame> rendered;
    StereoFrame& frame = rendered[i];
    if (!frame.left.empty()) return frame;
    frame.t = Timestamp{1'000'000'000} + FromSeconds(kFrameInterval * i);
    frame.left = wall_.See(rig_.cameras[0], BodyAt(i) * rig_.T_BC[0]);
    frame.right = wall_.See(rig_.cameras[1], BodyAt(i) * rig_.T_BC[1], 0.85);
    return frame;
  }

  FrontendHint HintAt(int i) const {
    FrontendHint hint;
    if (i > 0) hint.R_prev_now = (BodyAt(i - 1).Inverse() * BodyAt(i)).q;
    return hint;
  }

  static FrontendOptions Options() {
    FrontendOptions options;
    options.max_features = 80;
    options.detector.cell_px = 30;
    return options;
  }

  std::vector<FrontendResult> Run(const FrontendOptions& options, int num_frames) const {
    StereoFrontend frontend(rig_, options);
    std::vector<FrontendResult> results;
    StageTimes times;
    for (int i = 0; i < num_frames; ++i) {
      results.push_back(frontend.Process(FrameAt(i), HintAt(i), times));
    }
    return results;
  }

  // Where the point of the wall that was first seen at `px` in frame `first` is in frame i.
  Vector2d Truth(int first, const Vector2d& px, int i, int camera) const {
    const SE3 T_WC = BodyAt(first) * rig_.T_BC[0];
    const Vector3d ray = *rig_.cameras[0].Unproject(px);
    const Vector3d p_W = T_WC * (ray / wall_.InverseDistance(T_WC, ray));
    const auto c = static_cast<std::size_t>(camera);
    return *rig_.cameras[c].Project((BodyAt(i) * rig_.T_BC[c]).Inverse() * p_W);
  }

  // As the estimator would know them.
  std::pmr::unordered_map<LandmarkId, double> TrueDepths(int i,
                                                         const FrontendResult& result) const {
    std::pmr::unordered_map<LandmarkId, double> depths;
    for (const FeatureObservation& f : result.observations.features) {
      depths[f.landmark] =
          wall_.InverseDistance(BodyAt(i) * rig_.T_BC[0], *rig_.cameras[0].Unproject(f.px_left));
    }
    return depths;
  }

  /// As the estimator would: with the motion and the depths of before, which become those of now.
  FrontendResult ProcessKnowingDepths(int i,
                                      const StereoFrame& frame,
                                      StereoFrontend& frontend,
                                      std::pmr::unordered_map<LandmarkId, double>& depths,
                                      const std::shared_ptr<const StereoRig>& rig = {}) const {
    FrontendHint hint = HintAt(i);
    hint.rig = rig;
    hint.inverse_distance = &depths;
    hint.is_motion_known = true;
    StageTimes times;
    FrontendResult result = frontend.Process(frame, hint, times);
    depths = TrueDepths(i, result);
    return result;
  }

  /// With a right camera that is turned from the frame `knock` on.
  StereoFrame FrameWithKnock(int i, int knock, const Vector3d& omega) const {
    StereoFrame frame = FrameAt(i);
    const SE3 T_WC1 = BodyAt(i) * TurnedRig(rig_, omega).T_BC[1];
    if (i >= knock) frame.right = wall_.See(rig_.cameras[1], T_WC1, 0.85);
    return frame;
  }

  /// All are where the right camera, as it was calibrated, sees the points. Returns how many.
  int CheckRightPixels(int i, const FrontendResult& result) const {
    int num = 0;
    for (const FeatureObservation& f : result.observations.features) {
      if (!f.px_right) continue;
      EXPECT_LT((*f.px_right - Truth(i, f.px_left, i, 1)).norm(), 1.0) << i;
      ++num;
    }
    return num;
  }

  StereoRig rig_ = MakeRig();
  Wall wall_;
};

TEST_F(FrontendTest, TracksAndMatchesStayOnTheWall) {
  constexpr int kFrames = 17;
  const std::vector<FrontendResult> results = Run(Options(), kFrames);
  std::map<LandmarkId, std::pair<int, Vector2d>> born;
  double left2 = 0, right2 = 0;
  int num_left = 0, num_right = 0, num_bad = 0;
  for (int i = 0; i < kFrames; ++i) {
    const FrontendResult& result = results[static_cast<std::size_t>(i)];
    EXPECT_EQ(result.observations.frame.value, i);
    EXPECT_EQ(result.observations.is_keyframe, i % 4 == 0);
    EXPECT_GT(result.observations.features.size(), 40U) << "frame " << i;
    for (const FeatureObservation& o : result.observations.features) {
      const auto [entry, is_new] = born.try_emplace(o.landmark, i, o.px_left);
      const auto& [first, px] = entry->second;
      EXPECT_TRUE(rig_.cameras[0].IsInside(o.px_left, 4));
      const Vector2d left = o.px_left - Truth(first, px, i, 0);
      num_bad += left.norm() > 1 ? 1 : 0;
      if (left.norm() > 1) continue;
      if (!is_new) left2 += left.squaredNorm() / 2, ++num_left;
      if (!o.px_right) continue;
      right2 += (*o.px_right - Truth(first, px, i, 1)).squaredNorm() / 2;
      ++num_right;
    }
  }
  EXPECT_GT(num_left, 600);
  EXPECT_GT(num_right, 200);
  EXPECT_LE(num_bad, num_left / 100);
  EXPECT_LT(std::sqrt(left2 / num_left), 0.12);
  EXPECT_LT(std::sqrt(right2 / num_right), 0.12);
}

TEST_F(FrontendTest, OnlyKeyframesBeginTracksAndHaveRightPixels) {
  const std::vector<FrontendResult> results = Run(Options(), 9);
  for (const FrontendResult& result : results) {
    if (result.observations.is_keyframe) {
      EXPECT_GT(result.num_stereo, 40);
      continue;
    }
    EXPECT_EQ(result.num_stereo, 0);
    EXPECT_EQ(result.num_new, 0);
  }
}

// From then on pixels are those that the camera would see if it were still as it was calibrated. A
// turn about y is seen by the depths that were known before.
TEST_F(FrontendTest, ATurnOfTheRightCameraIsNoticedAndCorrected) {
  constexpr int kFrames = 60, kKnock = 12;
  std::pmr::unordered_map<LandmarkId, double> depths;
  for (const Vector3d& omega : {Vector3d(0.01, 0, 0),
                                Vector3d(-0.006, 0, 0.012),
                                Vector3d(0, 0.008, 0),
                                Vector3d(0, -0.021, 0)}) {
    SCOPED_TRACE(omega.transpose());
    StereoFrontend frontend(rig_, Options());
    std::optional<StereoTurn> turn;
    int num_checked = 0;
    for (int i = 0; i < kFrames; ++i) {
      const StereoFrame frame = FrameWithKnock(i, kKnock, omega);
      const FrontendResult result = ProcessKnowingDepths(i, frame, frontend, depths);
      if (result.right.turn) {
        EXPECT_GE(i, kKnock);
        EXPECT_FALSE(turn) << "once";
        turn = result.right.turn;
      }
      if (i < kKnock || turn) {
        EXPECT_FALSE(result.right.contradiction_px) << i;
      }
      if (!turn || !result.observations.is_keyframe) continue;
      EXPECT_GT(result.num_stereo, 35) << i;
      num_checked += CheckRightPixels(i, result);
    }
    ASSERT_TRUE(turn) << omega.transpose();
    EXPECT_LT((turn->omega - omega).norm(), 6e-4) << turn->omega.transpose();
    EXPECT_GT(num_checked, 100);
  }
}

// One knock turns a camera about all its axes, and what is off along the lines is found before what
// is off across them.
TEST_F(FrontendTest, AKnockAboutAllAxesIsCorrectedStepByStep) {
  constexpr int kFrames = 90, kKnock = 12, kCorrected = 70;
  const Vector3d omega(0.004, 0.021, 0.002);
  std::pmr::unordered_map<LandmarkId, double> depths;
  StereoFrontend frontend(rig_, Options());
  Quaterniond turned = Quaterniond::Identity();
  int num_checked = 0, num_wrong = 0;
  for (int i = 0; i < kFrames; ++i) {
    const StereoFrame frame = FrameWithKnock(i, kKnock, omega);
    const FrontendResult result = ProcessKnowingDepths(i, frame, frontend, depths);
    if (result.right.turn) turned = turned * ExpSO3(result.right.turn->omega);
    if (!result.observations.is_keyframe) continue;
    for (const FeatureObservation& f : result.observations.features) {
      if (!f.px_right) continue;
      const bool is_wrong = (*f.px_right - Truth(i, f.px_left, i, 1)).norm() > 1.0;
      num_wrong += is_wrong ? 1 : 0;
      num_checked += i >= kCorrected ? 1 : 0;
    }
  }
  EXPECT_LT((LogSO3(turned) - omega).norm(), 1.5e-3) << LogSO3(turned).transpose();
  EXPECT_GT(num_checked, 100) << "right images are used again";
  EXPECT_LE(num_wrong, 10) << "none was used while it was wrong";
}

// Depths are those of a calibration that the estimator has refined. By the one that was given they
// contradict all disparities, which is no knock; one that comes later is found.
TEST_F(FrontendTest, WhatTheEstimatorHasLearntOfTheCalibrationIsNoKnock) {
  constexpr int kFrames = 70, kLearnt = 6, kKnock = 45;
  const Vector3d omega(0, 0.008, 0);
  StereoRig given = TurnedRig(rig_, Vector3d(0, 0.007, 0));
  CameraIntrinsics left = given.cameras[0].intrinsics();
  left.cx += 2;
  given.cameras[0] = CameraModel(left);
  const auto learnt = std::make_shared<const StereoRig>(rig_);
  std::pmr::unordered_map<LandmarkId, double> depths;
  StereoFrontend frontend(given, Options());
  std::optional<StereoTurn> turn;
  int num_checked = 0;
  for (int i = 0; i < kFrames; ++i) {
    StereoFrame frame = FrameWithKnock(i, kKnock, omega);
    frame.t = Timestamp{1'000'000'000} + FromSeconds(2 * kFrameInterval * i);
    if (i <= kLearnt) depths.clear();
    const FrontendResult result =
        ProcessKnowingDepths(i, frame, frontend, depths, i < kLearnt ? nullptr : learnt);
    EXPECT_GT(result.observations.features.size(), 40U) << i;
    if (result.right.turn) {
      EXPECT_GE(i, kKnock);
      EXPECT_FALSE(turn) << "once";
      turn = result.right.turn;
    }
    if (i < kKnock || turn) {
      EXPECT_FALSE(result.right.contradiction_px) << i;
    }
    if (i < kLearnt || !result.observations.is_keyframe || (i >= kKnock && !turn)) continue;
    EXPECT_GT(result.num_stereo, 35) << i;
    num_checked += CheckRightPixels(i, result);
  }
  EXPECT_EQ(frontend.rig().cameras[0].intrinsics().cx, rig_.cameras[0].intrinsics().cx);
  ASSERT_TRUE(turn);
  EXPECT_LT((turn->omega - omega).norm(), 6e-4) << turn->omega.transpose();
  EXPECT_GT(num_checked, 100);
}

// The other way round: a camera that was knocked stays turned when the calibration changes.
TEST_F(FrontendTest, AKnockIsRememberedWhenTheCalibrationChanges) {
  constexpr int kFrames = 76, kKnock = 12, kLearnt = 52;
  const Vector3d omega(0, 0.008, 0);
  StereoRig given = rig_;
  for (CameraModel& camera : given.cameras) {
    CameraIntrinsics k = camera.intrinsics();
    k.cx += 6;
    camera = CameraModel(k);
  }
  const auto learnt = std::make_shared<const StereoRig>(rig_);
  std::pmr::unordered_map<LandmarkId, double> depths;
  StereoFrontend frontend(given, Options());
  std::optional<StereoTurn> turn;
  int num_checked = 0;
  for (int i = 0; i < kFrames; ++i) {
    const StereoFrame frame = FrameWithKnock(i, kKnock, omega);
    const FrontendResult result =
        ProcessKnowingDepths(i, frame, frontend, depths, i < kLearnt ? nullptr : learnt);
    if (result.right.turn) {
      EXPECT_FALSE(turn) << "once";
      EXPECT_LT(i, kLearnt);
      turn = result.right.turn;
    }
    if (i < kLearnt || !result.observations.is_keyframe) continue;
    EXPECT_FALSE(result.right.contradiction_px) << i;
    EXPECT_GT(result.num_stereo, 30) << i;
    num_checked += CheckRightPixels(i, result);
    for (std::size_t n = 0; n < result.observations.features.size(); ++n) {
      const FeatureObservation& f = result.observations.features[n];
      if (!f.px_right) continue;
      EXPECT_NEAR(result.depths.inverse_distances[n], depths.at(f.landmark), 0.05) << i;
    }
  }
  ASSERT_TRUE(turn);
  EXPECT_EQ(frontend.rig().cameras[0].intrinsics().cx, rig_.cameras[0].intrinsics().cx);
  EXPECT_GT(num_checked, 100);
}

// A right image that belongs to another pair: it is not used, and the next one is.
TEST_F(FrontendTest, ARightImageOfAnotherMomentIsNotUsed) {
  std::pmr::unordered_map<LandmarkId, double> depths;
  StereoFrontend frontend(rig_, Options());
  for (int i = 0; i < 25; ++i) {
    StereoFrame frame = FrameAt(i);
    const bool is_wrong = i == 12;
    if (is_wrong) {
      const SE3 turned(ExpSO3(Vector3d(0, 0.01, 0)), Vector3d::Zero());
      frame.right = wall_.See(rig_.cameras[1], BodyAt(i) * rig_.T_BC[1] * turned, 0.85);
    }
    const FrontendResult result = ProcessKnowingDepths(i, frame, frontend, depths);
    if (!result.observations.is_keyframe) continue;
    EXPECT_EQ(result.right.contradiction_px.has_value(), is_wrong) << i;
    EXPECT_EQ(result.num_stereo > 0, !is_wrong) << i;
    EXPECT_EQ(result.right_ok, !is_wrong) << i;
    EXPECT_FALSE(result.right.turn);
  }
}

TEST_F(FrontendTest, ATrackWithANewReferenceIsAnotherLandmark) {
  constexpr int kFrames = 9;
  FrontendOptions options = Options();
  options.tracking.min_reference_zncc = 1;  // no reference is ever similar enough
  options.keyframe.min_landmark_ratio = 0;
  const std::vector<FrontendResult> results = Run(options, kFrames);
  const std::vector<FrontendResult> usual = Run(Options(), kFrames);
  std::set<LandmarkId> earlier;
  for (std::size_t i = 0; i < results.size(); ++i) {
    SCOPED_TRACE(i);
    const FrontendResult& result = results[i];
    EXPECT_EQ(result.tracking.num_refreshed, result.tracking.num_tracked + result.num_outliers);
    for (const FeatureObservation& o : result.observations.features)
      EXPECT_TRUE(earlier.insert(o.landmark).second) << o.landmark.value;
    // The tracks go on.
    EXPECT_EQ(result.observations.is_keyframe, usual[i].observations.is_keyframe);
    if (!result.observations.is_keyframe) {
      EXPECT_EQ(result.num_new, 0);
      EXPECT_GT(result.observations.features.size(), 40U);
    }
  }
  std::set<LandmarkId> first;
  for (const FeatureObservation& o : usual.front().observations.features)
    first.insert(o.landmark);
  const auto& last = usual.back().observations.features;
  EXPECT_GT(
      std::count_if(
          last.begin(), last.end(), [&](const auto& o) { return first.contains(o.landmark); }),
      30)
      << "a good reference keeps its landmark";
}

TEST_F(FrontendTest, WithoutSharedLandmarksEveryFrameIsAKeyframe) {
  FrontendOptions options = Options();
  options.tracking.min_reference_zncc = 1;
  const std::vector<FrontendResult> results = Run(options, 5);
  for (std::size_t i = 1; i < results.size(); ++i) {
    EXPECT_EQ(results[i].keyframe_reason, KeyframeReason::kFewTracks);
    EXPECT_GT(results[i].num_stereo, 40);
  }
}

void ExpectSame(const std::vector<FrontendResult>& a, const std::vector<FrontendResult>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto &x = a[i].observations.features, &y = b[i].observations.features;
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      EXPECT_EQ(x[k].landmark, y[k].landmark);
      EXPECT_EQ(x[k].px_left, y[k].px_left);
      EXPECT_EQ(x[k].px_right.has_value(), y[k].px_right.has_value());
      EXPECT_EQ(x[k].px_right.value_or(Vector2d::Zero()), y[k].px_right.value_or(Vector2d::Zero()));
      EXPECT_EQ(x[k].sigma_left_px, y[k].sigma_left_px);
    }
  }
}

TEST_F(FrontendTest, RepeatsItselfExactlyWithEveryInstructionSet) {
  FrontendOptions options = Options();
  options.klt.simd = "scalar";
  const std::vector<FrontendResult> reference = Run(options, 9);
  for (const char* simd : {"scalar", "sse2", "avx2", "neon"}) {
    if (FindPatchKernels(simd) == nullptr) continue;
    SCOPED_TRACE(simd);
    options.klt.simd = simd;
    ExpectSame(reference, Run(options, 9));
  }
}

TEST_F(FrontendTest, SurvivesUnusableImages) {
  StereoFrontend frontend(rig_, Options());
  StageTimes times;
  std::vector<LandmarkId> before;
  for (int i = 0; i < 12; ++i) {
    StereoFrame frame = FrameAt(i);
    if (i == 4) frame.right = cv::Mat();
    if (i == 5) frame.left = cv::Mat();
    if (i == 6) frame.left = cv::Mat(100, 100, CV_8UC1, cv::Scalar(0));
    if (i == 7) frame.left = cv::Mat(kImageHeight, kImageWidth, CV_32FC1, cv::Scalar(0));
    const FrontendResult result = frontend.Process(frame, HintAt(i), times);
    EXPECT_EQ(result.image_ok, i < 5 || i > 7);
    if (i == 4) {
      EXPECT_TRUE(result.observations.is_keyframe);
      EXPECT_EQ(result.num_stereo, 0);
      EXPECT_FALSE(result.right_ok);
      for (const FeatureObservation& o : result.observations.features)
        before.push_back(o.landmark);
    }
    if (i == 0) {
      EXPECT_TRUE(result.right_ok);
    }
    if (!result.image_ok) {
      EXPECT_TRUE(result.observations.features.empty());
    }
    if (i == 8) {
      EXPECT_GT(result.tracking.num_tracked, static_cast<int>(before.size()) / 2)
          << "the tracks are found again after the gap";
    }
  }
}

TEST_F(FrontendTest, ABlackOrWhiteImageLosesEverythingQuietly) {
  StereoFrontend frontend(rig_, Options());
  StageTimes times;
  StereoFrame frame = FrameAt(0);
  EXPECT_GT(frontend.Process(frame, {}, times).observations.features.size(), 40U);
  for (const double grey : {0.0, 255.0}) {
    frame.t = frame.t + FromSeconds(kFrameInterval);
    frame.left = cv::Mat(kImageHeight, kImageWidth, CV_8UC1, cv::Scalar(grey));
    frame.right = frame.left;
    const FrontendResult result = frontend.Process(frame, {}, times);
    EXPECT_TRUE(result.image_ok);
    EXPECT_TRUE(result.observations.features.empty());
  }
  const Timestamp next = frame.t + FromSeconds(kFrameInterval);
  frame = FrameAt(1);
  frame.t = next;
  const FrontendResult result = frontend.Process(frame, {}, times);
  EXPECT_TRUE(result.observations.is_keyframe) << "nothing is tracked any more";
  EXPECT_GT(result.observations.features.size(), 40U);
}

TEST_F(FrontendTest, AnOlderImageIsNotUsed) {
  StereoFrontend frontend(rig_, Options());
  StageTimes times;
  FrontendHint turning;
  turning.R_prev_now = ExpSO3(Vector3d(0, 0.01, 0));
  turning.is_motion_known = true;
  const StereoFrame old = FrameAt(0);
  for (int i = 0; i < 5; ++i)
    EXPECT_FALSE(frontend.Process(FrameAt(i), turning, times).is_repeated) << i;
  StereoFrame frame = FrameAt(5);
  frame.left = old.left.clone();
  frame.right = old.right.clone();
  const FrontendResult repeated = frontend.Process(frame, turning, times);
  EXPECT_TRUE(repeated.is_repeated);
  EXPECT_TRUE(repeated.observations.features.empty());
  const FrontendResult next = frontend.Process(FrameAt(6), turning, times);
  EXPECT_FALSE(next.is_repeated);
  EXPECT_GT(next.observations.features.size(), 40U);
}

// A covered lens is no frozen camera.
TEST_F(FrontendTest, BlackImagesAreBlankAndNotRepeated) {
  StereoFrontend frontend(rig_, Options());
  StageTimes times;
  FrontendHint turning;
  turning.R_prev_now = ExpSO3(Vector3d(0, 0.05, 0));
  turning.is_motion_known = true;
  StereoFrame frame = FrameAt(0);
  EXPECT_FALSE(frontend.Process(frame, {}, times).is_blank);
  for (int i = 0; i < 4; ++i) {
    frame.t = frame.t + FromSeconds(kFrameInterval);
    frame.left = frame.right = cv::Mat(kImageHeight, kImageWidth, CV_8UC1, cv::Scalar(0));
    const FrontendResult result = frontend.Process(frame, turning, times);
    EXPECT_TRUE(result.is_blank);
    EXPECT_FALSE(result.is_repeated);
    EXPECT_TRUE(result.observations.features.empty());
  }
  frame = FrameAt(1);
  frame.t = frame.t + FromSeconds(1);
  frontend.Process(frame, turning, times);
  frame.t = frame.t + FromSeconds(kFrameInterval);
  const FrontendResult frozen = frontend.Process(frame, turning, times);
  EXPECT_TRUE(frozen.is_repeated);
  EXPECT_FALSE(frozen.is_blank);
}

TEST_F(FrontendTest, FindsTracksInSpiteOfAWrongRotationHint) {
  StereoFrontend frontend(rig_, Options());
  StageTimes times;
  FrontendResult result;
  for (int i = 0; i < 9; ++i) {
    FrontendHint hint = HintAt(i);
    hint.R_prev_now = hint.R_prev_now * ExpSO3(Vector3d(0.02, -0.02, 0.03));
    result = frontend.Process(FrameAt(i), hint, times);
    EXPECT_TRUE(i == 0 || result.tracking.num_tracked > 25) << i;
  }
}

class MatcherTest : public FrontendTest {
 protected:
  // Errors of inverse distances of matches without any earlier one, at a grid of points.
  void ExpectDepths(double depth) {
    wall_.depth = depth;
    const SE3 T_WC = PoseAt(0);
    const cv::Mat left = wall_.See(rig_.cameras[0], T_WC);
    const cv::Mat right = wall_.See(rig_.cameras[1], BodyAt(0) * rig_.T_BC[1]);
    ImagePyramid left_pyramid, right_pyramid;
    left_pyramid.Build(left, 4);
    right_pyramid.Build(right, 4);
    const FrontendOptions options = Options();
    StereoMatcher matcher(rig_, options);
    TemporalTracker tracker(rig_.cameras[0], options);
    int tried = 0, wrong = 0, matched = 0;
    for (int y = 40; y < kImageHeight - 40; y += 16) {
      for (int x = 40; x < kImageWidth - 40; x += 16) {
        Track track;
        if (!tracker.Begin(left_pyramid, Vector2d(x, y), track)) continue;
        const Vector2d truth = Truth(0, Vector2d(x, y), 0, 1);
        if (!rig_.cameras[1].IsInside(truth, 12)) continue;
        ++tried;
        const auto match = matcher.Match(track, left_pyramid, right_pyramid);
        if (!match) continue;
        ++matched;
        wrong += (match->px - truth).norm() > 0.5 ? 1 : 0;
      }
    }
    EXPECT_GT(matched, tried * 3 / 4) << "depth " << depth;
    // The wall is seen straight; patches are expected half-way to across their rays.
    EXPECT_LE(wrong, 1 + matched / 30) << "depth " << depth;
  }
};

TEST_F(MatcherTest, FindsNearAndFarPointsWithoutAnyHint) {
  for (const double depth : {0.5, 1.0, 3.0, 20.0, 1000.0})
    ExpectDepths(depth);
}

}  // namespace
}  // namespace facet
