// SPDX-License-Identifier: BSD-2-Clause
// Random sliding windows with known truth, for the tests of this folder: frames along a smooth
// motion, landmarks in front of them with stereo and mono observations, IMU preintegrated between
// the frames.
#pragma once

#include <vector>

#include "facet/base/random.h"
#include "facet/camera/stereo_rig.h"
#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/solver/linearized_window.h"

namespace facet::testing {

/// Applies a step in the order theta p v b_g b_a.
NavState Retract(const NavState& x, const Vector<15>& step);

/// The step that leads from a to b.
Vector<15> Difference(const NavState& a, const NavState& b);

/// Small random step: rotation [rad], position [m], velocity [m/s], gyro and accelerometer bias.
struct StepSigmas {
  double theta = 0.01, p = 0.02, v = 0.02, b_g = 1e-3, b_a = 0.01;
};
Vector<15> RandomStep(const StepSigmas& sigmas, Rng& rng);

/// A motion with analytic derivatives: sines in position, and a rotation about one axis.
struct TestMotion {
  Quaterniond q0 = Quaterniond::Identity();
  Vector3d v0 = Vector3d::Zero(), amplitude = Vector3d::Zero(), frequency = Vector3d::Ones();
  Vector3d axis_B = Vector3d::UnitZ();
  double rate = 0, swing = 0, swing_frequency = 1;  // angle: rate t + swing sin(swing_frequency t)

  /// Speeds around 1 m/s, accelerations of some m/s^2, turning by less than 30 deg.
  static TestMotion Random(Rng& rng);

  NavState At(double t) const;
  /// Perfect measurements, plus the bias.
  ImuSample ImuAt(double t, const ImuBias& bias) const;
};

/// Two pinhole cameras, 0.11 m apart, turned against the body and slightly against each other.
StereoRig MakeTestRig();

/// 1-sigma of the rows of planes in tests that do not weigh them.
inline constexpr double kPlaneSigma_m = 0.02;

struct TestWindowOptions {
  int num_frames = 6;
  int num_pose_frames = 0;  ///< the oldest ones have a pose only
  int num_landmarks = 40;
  double frame_interval_s = 0.1;
  double max_depth = 8;      ///< of landmarks in their first frame [m]
  double right_share = 0.6;  ///< of observations
  double miss_share = 0.15;  ///< of possible observations
  double pixel_sigma = 0.5;  ///< 450 pixels to the unit of xy
  double noise = 1.0;        ///< times the noise of pixels and IMU that the window assumes
  double outlier_share = 0;  ///< observations that are some ten sigma off
  ImuBias bias{Vector3d(0.01, -0.02, 0.015), Vector3d(0.05, -0.1, 0.08)};
};

/// A window whose states and landmarks are the truth (noise is in the measurements).
struct TestWindow {
  StereoRig rig;
  TestMotion motion;
  SlidingWindow window;
  std::vector<NavState> truth;   ///< by frame
  std::vector<Vector3d> points;  ///< p_W by landmark
};
TestWindow MakeTestWindow(const TestWindowOptions& options, const TestMotion& motion, Rng& rng);
/// Along a random motion.
TestWindow MakeTestWindow(const TestWindowOptions& options, Rng& rng);

/// Makes the calibration a variable, at the exact one; gives all frames rates. Coefficients of
/// distortion are no parameters of the test rig.
void AddCalibration(TestWindow& test, Rng& rng);

/// Moves all states and landmarks, and the calibration if it is a variable, away from where they
/// are. Frozen variables move in delta.
void Disturb(SlidingWindow& window, const StepSigmas& sigmas, Rng& rng);

/// What the frame measures of the plane about the point of it that is nearest to `near_W`, off by
/// `noise` times its sigmas.
PlaneMeasurement MakeMeasurement(const WindowFrame& frame,
                                 const WindowPlane& plane,
                                 const Vector3d& near_W,
                                 double noise,
                                 Rng& rng);

/// World point of a landmark with inverse distance > 0.
Vector3d PointOf(const SlidingWindow& window, const WindowLandmark& landmark);

/// Whitened measurement of one camera of a frame whose true direction is h (z > 0).
void SetMeasurement(const Vector3d& h,
                    int camera,
                    double pixel_sigma,
                    WindowObservation& observation);

/// Moves a measurement of SetMeasurement on the plane z = 1.
void ShiftMeasurement(const Vector2d& xy, int camera, WindowObservation& observation);

/// Columns: how far a measurement moves on the plane z = 1 for one sigma of each of its rows.
Matrix2d OneSigmaOnPlane(const MeasuredRay& ray);

/// The default noise, with reprojections that count ever less beyond this many sigma.
FactorNoise NoiseOfWidth(double reprojection_width);

/// The default walk of the biases.
BiasWalk DefaultBiasWalk();

/// Linearises the window where it is.
void Linearize(const TestWindow& test,
               const FactorNoise& noise,
               LinearizedWindow& linear,
               CalibrationStep calibration_step = CalibrationStep::kFree);

/// Normal equations of everything in the window but the landmarks, which are eliminated exactly as
/// the solver does it without damping. Full symmetric matrix.
NormalEquations Assemble(const SlidingWindow& window,
                         const StereoRig& rig,
                         double reprojection_width);

/// A Schur complement; it has no layout.
struct ReducedEquations {
  MatrixXd H;
  VectorXd b;
};

/// That of the columns `keep`.
ReducedEquations ReduceTo(const NormalEquations& equations, const std::vector<int>& keep);

}  // namespace facet::testing
