// SPDX-License-Identifier: BSD-2-Clause
// The columns of the calibration against numeric derivatives of all reprojection residuals.
#include "facet/estimator/solver/vision_system.h"

#include <gtest/gtest.h>

#include "facet/estimator/factors/reprojection_factor.h"
#include "facet/estimator/window/landmark_depth.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestWindow;

constexpr double kNoLoss = 1e6;

// Landmarks stay where they are in the world, whatever becomes of the cameras.
void HoldLandmarks(const std::vector<Vector3d>& points_W, SlidingWindow& window) {
  for (std::size_t l = 0; l < points_W.size(); ++l) {
    WindowLandmark& landmark = window.landmarks()[l];
    const Vector3d p_H = window.LeftCameraAt(landmark.host).Inverse() * points_W[l];
    landmark.bearing_H = p_H.normalized();
    landmark.inverse_distance = 1 / p_H.norm();
  }
}

VectorXd Residuals(const StereoRig& rig, const SlidingWindow& window) {
  FrameGeometry geometry(rig);
  geometry.Update(window);
  std::vector<double> r;
  for (const WindowLandmark& landmark : window.landmarks()) {
    for (const WindowObservation& o : landmark.observations) {
      for (int c = 0; c < (o.has_right ? 2 : 1); ++c) {
        const auto error = ReprojectionError(geometry, landmark, o, c);
        if (!error) continue;
        r.push_back(error->x());
        r.push_back(error->y());
      }
    }
  }
  return Eigen::Map<const VectorXd>(r.data(), static_cast<Eigen::Index>(r.size()));
}

struct Numeric {
  MatrixXd J_calibration, J_pose;  // of one frame
  VectorXd r;
};

Numeric Differentiate(const TestWindow& test, int frame) {
  std::vector<Vector3d> points_W;
  for (const WindowLandmark& landmark : test.window.landmarks())
    points_W.push_back(testing::PointOf(test.window, landmark));
  const auto at = [&](const CalibrationVector& delta, const Vector<6>& pose) {
    SlidingWindow window = test.window;
    window.calibration->SetDelta(delta);
    Vector<15> step = Vector<15>::Zero();
    step.head<6>() = pose;
    window.frames[frame].ApplyStep(step);
    HoldLandmarks(points_W, window);
    return Residuals(test.rig, window);
  };
  const CalibrationVector no_delta = CalibrationVector::Zero();
  const Vector<6> no_pose = Vector<6>::Zero();
  Numeric out;
  out.r = at(no_delta, no_pose);
  out.J_calibration.resize(out.r.size(), kNumCalibration);
  out.J_pose.resize(out.r.size(), 6);
  constexpr double kStep = 1e-5;
  for (int k = 0; k < kNumCalibration; ++k) {
    const CalibrationVector d = kStep * CalibrationVector::Unit(k);
    out.J_calibration.col(k) = (at(d, no_pose) - at(-d, no_pose)) / (2 * kStep);
  }
  for (int k = 0; k < 6; ++k) {
    const Vector<6> d = kStep * Vector<6>::Unit(k);
    out.J_pose.col(k) = (at(no_delta, d) - at(no_delta, -d)) / (2 * kStep);
  }
  return out;
}

double Relative(const MatrixXd& a, const MatrixXd& b) {
  return (a - b).norm() / (1e-9 + b.norm());
}

TEST(VisionSystemTest, CalibrationColumnsAreTheDerivativesOfAllReprojections) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Rng rng(seed);
    testing::TestWindowOptions options;
    options.num_pose_frames = 2;
    TestWindow test = testing::MakeTestWindow(options, rng);
    testing::AddCalibration(test, rng);
    const int frame = 3;
    const Numeric numeric = Differentiate(test, frame);

    LinearizedWindow linear;
    testing::Linearize(test, testing::NoiseOfWidth(kNoLoss), linear);
    const StateLayout& layout = linear.layout();
    MatrixXd H = linear.vision_H;
    VectorXd b = linear.vision_b;
    FillMountColumns(linear.mounts, layout, H, b);
    const int c = layout.calibration_column;
    const MatrixXd full = H.selfadjointView<Eigen::Lower>();
    const MatrixXd& J = numeric.J_calibration;
    const VectorXd s = (J.transpose() * J).diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
    EXPECT_LT(Relative(s.asDiagonal() * full.block<kNumCalibration, kNumCalibration>(c, c) *
                           s.asDiagonal(),
                       s.asDiagonal() * J.transpose() * J * s.asDiagonal()),
              1e-4);
    EXPECT_LT(Relative(s.cwiseProduct(b.segment<kNumCalibration>(c)),
                       s.cwiseProduct(J.transpose() * numeric.r)),
              1e-4);
    EXPECT_LT(
        Relative(full.block<6, kNumCalibration>(layout.pose_column[frame], c) * s.asDiagonal(),
                 numeric.J_pose.transpose() * J * s.asDiagonal()),
        1e-4);
  }
}

// What moves all cameras of a frame alike is a step of its pose, so poses can make up for it.
TEST(VisionSystemTest, AMountStepIsAStepOfEveryPose) {
  Rng rng(5);
  TestWindow test = testing::MakeTestWindow({}, rng);
  testing::AddCalibration(test, rng);
  LinearizedWindow linear;
  testing::Linearize(test, testing::NoiseOfWidth(kNoLoss), linear);
  const StateLayout& layout = linear.layout();
  VectorXd step = VectorXd::Zero(layout.dim);
  step.segment<3>(layout.calibration_column + kMountTranslation) = Vector3d(0.01, 0.02, 0.03);
  const VectorXd moved = WithMountAsPoses(linear.mounts, layout, step);
  for (std::size_t i = 0; i < test.window.frames.size(); ++i) {
    const Vector3d expected = test.window.frames[i].x.T_WB.q * Vector3d(0.01, 0.02, 0.03);
    EXPECT_LT((moved.segment<3>(layout.pose_column[i] + 3) - expected).norm(), 1e-12);
    EXPECT_EQ(moved.segment<3>(layout.pose_column[i]).norm(), 0);
  }
}

}  // namespace
}  // namespace facet
