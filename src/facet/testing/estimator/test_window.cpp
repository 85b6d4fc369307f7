// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/estimator/test_window.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "facet/estimator/factors/landmark_factors.h"
#include "facet/estimator/factors/window_factors.h"
#include "facet/estimator/solver/landmark_elimination.h"
#include "facet/geometry/so3.h"

namespace facet::testing {

namespace {

// 1-sigma of a calibration: intrinsics, stereo pair, modes of the lenses, mount, clock.
const CalibrationVector kCalibrationSigmas = [] {
  CalibrationVector sigmas;
  const Vector<kNumIntrinsics> lens{0.5, 0.5, 0.4, 0.4, 2e-3, 2e-3, 2e-4, 2e-4};
  sigmas << lens, lens, Vector3d::Constant(3e-4), Vector3d::Constant(2e-4),
      LensModeVector::Constant(0.05), LensModeVector::Constant(0.05), Vector3d::Constant(1e-3),
      Vector3d::Constant(2e-3), 1e-3, Vector3d::Constant(3e-3);
  return sigmas;
}();

constexpr double kFocal = 450.0;
constexpr double kImuRate = 200.0;
constexpr double kFieldOfView = 0.9;  // |x/z|, |y/z|

// White noise of variance density^2 * rate in samples between two frames.
std::vector<ImuSample> NoisySamples(const TestMotion& motion,
                                    double t0,
                                    double t1,
                                    const TestWindowOptions& options,
                                    const ImuParameters& noise,
                                    Rng& rng) {
  std::vector<ImuSample> samples;
  const int n = static_cast<int>(std::lround((t1 - t0) * kImuRate));
  const double scale = options.noise * std::sqrt(kImuRate);
  for (int i = 0; i <= n; ++i) {
    ImuSample sample = motion.ImuAt(t0 + i / kImuRate, options.bias);
    sample.gyro += scale * noise.gyro * rng.Normal3();
    sample.accel += scale * noise.accel * rng.Normal3();
    samples.push_back(sample);
  }
  return samples;
}

void AddFrames(const TestWindowOptions& options, Rng& rng, TestWindow& out) {
  ImuParameters noise;
  noise.gyro = 5e-4;
  noise.accel = 1e-2;
  for (int i = 0; i < options.num_frames; ++i) {
    const double t = i * options.frame_interval_s;
    NavState truth = out.motion.At(t);
    truth.bias = options.bias;
    out.truth.push_back(truth);
    WindowFrame frame;
    frame.id = FrameId{i};
    frame.is_keyframe = true;
    frame.x = frame.lin = truth;
    frame.has_motion = i >= options.num_pose_frames;
    if (i > options.num_pose_frames) {
      ImuPreintegration measured({0.9 * options.bias.b_g, 0.9 * options.bias.b_a}, noise);
      measured.Integrate(
          NoisySamples(out.motion, t - options.frame_interval_s, t, options, noise, rng));
      frame.imu_link = ImuLink{measured, ImuSqrtInfo(measured, DefaultBiasWalk())};
    }
    out.window.frames.push_back(std::move(frame));
  }
}

// A point in view of a random frame.
Vector3d RandomPoint(const TestWindowOptions& options, const TestWindow& window, Rng& rng) {
  const SE3 T_WC = window.truth[rng.Index(options.num_frames)].T_WB * window.rig.T_BC[0];
  const double x = rng.Uniform(-0.6, 0.6), y = rng.Uniform(-0.6, 0.6);
  return T_WC * (rng.Uniform(1.5, options.max_depth) * Vector3d(x, y, 1));
}

void Observe(const TestWindowOptions& options, Rng& rng, TestWindow& out) {
  const Vector3d p_W = RandomPoint(options, out, rng);
  WindowLandmark landmark;
  for (int i = 0; i < options.num_frames; ++i) {
    WindowObservation observation;
    observation.frame = i;
    observation.has_right = rng.Uniform() < options.right_share;
    bool visible = rng.Uniform() >= options.miss_share;
    for (int c = 0; c < 2; ++c) {
      const Vector3d h = (out.truth[i].T_WB * out.rig.T_BC[c]).Inverse() * p_W;
      const double x = rng.Normal(), y = rng.Normal();
      const double size = options.noise + (rng.Uniform() < options.outlier_share ? 10.0 : 0.0);
      visible &= h.z() > 0.3 && h.head<2>().cwiseAbs().maxCoeff() < kFieldOfView * h.z();
      SetMeasurement(h, c, options.pixel_sigma, observation);
      ShiftMeasurement(size * options.pixel_sigma / kFocal * Vector2d(x, y), c, observation);
      const auto px = out.rig.cameras[static_cast<std::size_t>(c)].Project(h);
      visible &= px.has_value();
      if (px) observation.px[c] = *px + size * options.pixel_sigma * Vector2d(x, y);
    }
    if (visible) landmark.observations.push_back(observation);
  }
  if (landmark.observations.size() < 2) return;
  const int host = landmark.observations[0].frame;
  const Vector3d p_H = (out.truth[host].T_WB * out.rig.T_BC[0]).Inverse() * p_W;
  const LandmarkId id{static_cast<std::int64_t>(100 + out.points.size())};
  WindowLandmark& added = out.window.AddLandmark(id, host);
  added.observations = landmark.observations;
  added.has_depth = true;
  added.bearing_H = p_H.normalized();
  added.inverse_distance = 1 / p_H.norm();
  out.points.push_back(p_W);
}

}  // namespace

NavState Retract(const NavState& x, const Vector<15>& step) {
  NavState y = x;
  y.T_WB = x.T_WB.Retract(step.head<3>(), step.segment<3>(3));
  y.v_WB += step.segment<3>(6);
  y.bias.b_g += step.segment<3>(9);
  y.bias.b_a += step.segment<3>(12);
  return y;
}

Vector<15> Difference(const NavState& a, const NavState& b) {
  Vector<15> d;
  d << LogSO3(a.T_WB.q.conjugate() * b.T_WB.q), b.T_WB.p - a.T_WB.p, b.v_WB - a.v_WB,
      b.bias.b_g - a.bias.b_g, b.bias.b_a - a.bias.b_a;
  return d;
}

Vector<15> RandomStep(const StepSigmas& sigmas, Rng& rng) {
  Vector<15> step;
  const double scale[5] = {sigmas.theta, sigmas.p, sigmas.v, sigmas.b_g, sigmas.b_a};
  for (int k = 0; k < 5; ++k)
    step.segment<3>(3 * k) = scale[k] * rng.Normal3();
  return step;
}

TestMotion TestMotion::Random(Rng& rng) {
  TestMotion motion;
  motion.q0 = ExpSO3(rng.Uniform(0, M_PI) * rng.UnitVector());
  motion.v0 = 0.5 * rng.Normal3();
  motion.amplitude = 0.15 * rng.Normal3();
  for (int k = 0; k < 3; ++k)
    motion.frequency(k) = rng.Uniform(2, 5);
  motion.axis_B = rng.UnitVector();
  motion.rate = rng.Uniform(-0.3, 0.3);
  motion.swing = rng.Uniform(0.05, 0.15);
  motion.swing_frequency = rng.Uniform(2, 5);
  return motion;
}

NavState TestMotion::At(double t) const {
  NavState state;
  state.t = Timestamp{} + FromSeconds(t);
  const Eigen::Array3d phase = frequency.array() * t;
  const double angle = rate * t + swing * std::sin(swing_frequency * t);
  state.T_WB.q = (q0 * ExpSO3(angle * axis_B)).normalized();
  state.T_WB.p = v0 * t + Vector3d(amplitude.array() * phase.sin());
  state.v_WB = v0 + Vector3d(amplitude.array() * frequency.array() * phase.cos());
  return state;
}

ImuSample TestMotion::ImuAt(double t, const ImuBias& bias) const {
  const Eigen::Array3d phase = frequency.array() * t;
  const Vector3d a_W = -amplitude.array() * frequency.array().square() * phase.sin();
  const double w = rate + swing * swing_frequency * std::cos(swing_frequency * t);
  const Quaterniond q_BW = At(t).T_WB.q.conjugate();
  return {Timestamp{} + FromSeconds(t),
          w * axis_B + bias.b_g,
          q_BW * (a_W - GravityInWorld()) + bias.b_a};
}

StereoRig MakeTestRig() {
  CameraIntrinsics intrinsics;
  intrinsics.width = 752;
  intrinsics.height = 480;
  intrinsics.fx = intrinsics.fy = kFocal;
  intrinsics.cx = 376;
  intrinsics.cy = 240;
  StereoRig rig;
  rig.cameras = {CameraModel(intrinsics), CameraModel(intrinsics)};
  rig.T_BC[0] = {ExpSO3(Vector3d(0.4, -0.9, 1.1)), Vector3d(0.05, -0.03, 0.02)};
  rig.T_BC[1] =
      rig.T_BC[0] * SE3(ExpSO3(Vector3d(0.01, 0.02, -0.015)), Vector3d(0.11, 0.003, -0.002));
  return rig;
}

TestWindow MakeTestWindow(const TestWindowOptions& options, Rng& rng) {
  const TestMotion motion = TestMotion::Random(rng);
  return MakeTestWindow(options, motion, rng);
}

TestWindow MakeTestWindow(const TestWindowOptions& options, const TestMotion& motion, Rng& rng) {
  TestWindow out;
  out.rig = MakeTestRig();
  out.motion = motion;
  out.window.T_BC0 = out.rig.T_BC[0];
  AddFrames(options, rng, out);
  for (int l = 0; l < options.num_landmarks; ++l)
    Observe(options, rng, out);
  return out;
}

void AddCalibration(TestWindow& test, Rng& rng) {
  CalibrationMatrix covariance = kCalibrationSigmas.cwiseAbs2().asDiagonal();
  // Left and right go together, as after a calibration with both.
  for (int k = 0; k < kNumIntrinsics; ++k) {
    covariance(k, k + kNumIntrinsics) = covariance(k + kNumIntrinsics, k) =
        0.8 * kCalibrationSigmas(k) * kCalibrationSigmas(k);
  }
  test.window.calibration.emplace(test.rig, covariance);
  for (WindowFrame& frame : test.window.frames) {
    frame.to_image.w_B = 0.5 * rng.Normal3();
    frame.last_v_B = 0.5 * rng.Normal3();
  }
}

void Disturb(SlidingWindow& window, const StepSigmas& sigmas, Rng& rng) {
  std::vector<Vector3d> points;
  for (const WindowLandmark& landmark : window.landmarks())
    points.push_back(PointOf(window, landmark));
  for (WindowFrame& frame : window.frames)
    frame.ApplyStep(RandomStep(sigmas, rng));
  if (window.calibration) {
    CalibrationVector step;
    for (int k = 0; k < kNumCalibration; ++k)
      step(k) = 0.1 * kCalibrationSigmas(k) * rng.Normal();
    window.calibration->ApplyStep(step);
  }
  for (std::size_t l = 0; l < points.size(); ++l) {
    WindowLandmark& landmark = window.landmarks()[l];
    const SE3 T_WH = window.LeftCameraAt(landmark.host);
    const Vector3d p_H = T_WH.Inverse() * (points[l] + sigmas.p * rng.Normal3());
    landmark.bearing_H = p_H.normalized();
    landmark.inverse_distance = 1 / p_H.norm();
  }
}

PlaneMeasurement MakeMeasurement(const WindowFrame& frame,
                                 const WindowPlane& plane,
                                 const Vector3d& near_W,
                                 double noise,
                                 Rng& rng) {
  PlaneMeasurement measurement;
  measurement.frame = frame.id;
  measurement.plane = plane.id;
  measurement.sigma_m = rng.Uniform(0.005, 0.02);
  measurement.sigma_rad = {rng.Uniform(0.005, 0.02), rng.Uniform(0.005, 0.02)};
  const Matrix<3, 2> tangents = TangentBasis(plane.n);
  const double turn = rng.Uniform(-3, 3);
  const Vector3d a_W = tangents * Vector2d(std::cos(turn), std::sin(turn));
  const Vector3d b_W = plane.n.cross(a_W);
  const double slope_a = noise * measurement.sigma_rad[0] * rng.Normal();
  const double slope_b = noise * measurement.sigma_rad[1] * rng.Normal();
  // Small turns of the measured surface about its own directions.
  const Eigen::AngleAxisd error_a(slope_b, a_W), error_b(-slope_a, b_W);
  const Quaterniond q_BW = frame.x.T_WB.q.conjugate();
  const Quaterniond error(error_a * error_b);
  const double distance = plane.SignedDistance(near_W) + noise * measurement.sigma_m * rng.Normal();
  measurement.centre_B = frame.x.T_WB.Inverse() * Vector3d(near_W - distance * plane.n);
  measurement.along_B = {q_BW * (error * a_W), q_BW * (error * b_W)};
  return measurement;
}

Vector3d PointOf(const SlidingWindow& window, const WindowLandmark& landmark) {
  const SE3 T_WH = window.LeftCameraAt(landmark.host);
  return T_WH * (landmark.bearing_H / landmark.inverse_distance);
}

void SetMeasurement(const Vector3d& h,
                    int camera,
                    double pixel_sigma,
                    WindowObservation& observation) {
  // Not a multiple of the identity, as behind a distorting lens.
  Matrix2d by_xy;
  by_xy << kFocal, 0.05 * kFocal, -0.03 * kFocal, 1.1 * kFocal;
  MeasuredRay& ray = observation.rays[camera];
  ray.bearing = h.normalized();
  ray.whitening.leftCols<2>() = by_xy / (pixel_sigma * ray.bearing.z());
  ray.whitening.col(2) = -ray.whitening.leftCols<2>() * (h.head<2>() / h.z());
  observation.sigma_px[camera] = pixel_sigma;
}

void ShiftMeasurement(const Vector2d& xy, int camera, WindowObservation& observation) {
  const Vector3d& bearing = observation.rays[camera].bearing;
  const Vector3d moved = bearing / bearing.z() + Vector3d(xy.x(), xy.y(), 0);
  SetMeasurement(moved, camera, observation.sigma_px[camera], observation);
}

Matrix2d OneSigmaOnPlane(const MeasuredRay& ray) {
  return Matrix2d(ray.bearing.z() * ray.whitening.leftCols<2>()).inverse();
}

FactorNoise NoiseOfWidth(double reprojection_width) {
  FactorNoise noise{EstimatorOptions{}};
  noise.reprojection_width = reprojection_width;
  return noise;
}

BiasWalk DefaultBiasWalk() {
  return {ImuNoise{}, ImuOptions{}};
}

void Linearize(const TestWindow& test,
               const FactorNoise& noise,
               LinearizedWindow& linear,
               CalibrationStep calibration_step) {
  FrameGeometry geometry(test.rig);
  geometry.Update(test.window);
  facet::Linearize(test.window, geometry, noise, calibration_step, linear);
}

NormalEquations Assemble(const SlidingWindow& window,
                         const StereoRig& rig,
                         double reprojection_width) {
  const FactorNoise noise = NoiseOfWidth(reprojection_width);
  NormalEquations out;
  out.Clear(window);
  VisitFactors(window, noise, [&](const Factor auto& factor) { factor.AddTo(out); });
  FrameGeometry geometry(rig);
  geometry.Update(window);
  MatrixXd lower = MatrixXd::Zero(out.layout.dim, out.layout.dim);
  VectorXd b = VectorXd::Zero(out.layout.dim);
  LandmarkBlock block;
  LensSums sums;
  LensSums* const lens = window.calibration ? &sums : nullptr;
  sums.Clear(window.frames.size());
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!IsConstraining(landmark)) continue;
    LinearizeLandmark(geometry, window.planes, landmark, noise, block, lens);
    Eliminate(0.0, block);
    AddDiagonal(block, out.layout, lower, b);
    SubtractSchur(block, out.layout, lower, b);
  }
  if (lens != nullptr) {
    AddLensSums(sums, out.layout, lower, b);
    FillMountColumns(MountJacobiansOf(window, geometry), out.layout, lower, b);
  }
  out.b += b;
  out.H += lower.selfadjointView<Eigen::Lower>();
  return out;
}

ReducedEquations ReduceTo(const NormalEquations& equations, const std::vector<int>& keep) {
  const MatrixXd& H = equations.H;
  std::vector<char> kept(equations.b.size(), 0);
  for (int k : keep)
    kept[k] = 1;
  std::vector<int> leave;
  for (int k = 0; k < equations.b.size(); ++k) {
    if (!kept[k]) leave.push_back(k);
  }
  ReducedEquations out{H(keep, keep), equations.b(keep)};
  if (leave.empty()) return out;
  // Scaled to unit diagonal: the columns have very different units.
  const VectorXd scale = H.diagonal()(leave).cwiseSqrt().cwiseInverse();
  const MatrixXd H_MM = scale.asDiagonal() * H(leave, leave) * scale.asDiagonal();
  const MatrixXd H_KM = H(keep, leave) * scale.asDiagonal();
  const Eigen::LDLT<MatrixXd> ldlt(H_MM);
  out.H -= H_KM * ldlt.solve(H_KM.transpose());
  out.b -= H_KM * ldlt.solve(scale.asDiagonal() * equations.b(leave));
  return out;
}

}  // namespace facet::testing
