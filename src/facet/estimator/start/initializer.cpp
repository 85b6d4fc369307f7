// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/start/initializer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr int kVisionIterations = 12;
// Gravity from positions alone may be this wrong before the start is refused [m/s^2].
constexpr double kMaxGravityError = 3.0;

// Poses relative to the first frame: rotation from the gyro, no translation.
void PredictRotations(SlidingWindow& window) {
  for (std::size_t i = 1; i < window.frames.size(); ++i) {
    WindowFrame& frame = window.frames[i];
    frame.x.T_WB.q = (window.frames[i - 1].x.T_WB.q * frame.imu_link->measured.dR()).normalized();
    frame.x.T_WB.p = window.frames[i - 1].x.T_WB.p;
    frame.lin = frame.x;
  }
}

// Bundle adjustment of the stereo observations with the first pose held.
bool SolveVisionOnly(const StereoRig& rig, const EstimatorOptions& options, SlidingWindow& window) {
  struct SetAside {
    bool has_motion;
    std::optional<ImuLink> imu_link;
  };
  std::vector<SetAside> aside;
  for (WindowFrame& frame : window.frames) {
    aside.push_back({frame.has_motion, std::move(frame.imu_link)});
    frame.has_motion = false;
    frame.imu_link.reset();
  }
  const std::optional<StartPrior> start_prior = std::exchange(window.start_prior, std::nullopt);
  std::optional<WindowCalibration> calibration = std::exchange(window.calibration, std::nullopt);
  WindowFrame& first = window.frames.front();
  first.FreezePose();
  window.prior.blocks = {MarginalPrior::Block::OfPose(first.id, 0)};
  window.prior.H = 1e10 * MatrixXd::Identity(6, 6);
  window.prior.b = VectorXd::Zero(6);

  WindowSolver solver(rig, options.solver);
  const SolveSummary summary = solver.Solve(window, FactorNoise(options), kVisionIterations);

  window.prior = MarginalPrior();
  window.start_prior = start_prior;
  window.calibration = std::move(calibration);
  first.pose_frozen = false;
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    WindowFrame& frame = window.frames[i];
    frame.has_motion = aside[i].has_motion;
    frame.imu_link = std::move(aside[i].imu_link);
    frame.lin = frame.x;
    frame.delta.setZero();
  }
  return summary.ok;
}

// Equation (6.1): the gyro bias that makes the integrated rotations agree with the seen ones (two
// passes).
void SolveGyroBias(SlidingWindow& window) {
  for (int pass = 0; pass < 2; ++pass) {
    Matrix3d H = 1e-9 * Matrix3d::Identity();
    Vector3d b = Vector3d::Zero();
    for (std::size_t i = 1; i < window.frames.size(); ++i) {
      const ImuPreintegration& imu = window.frames[i].imu_link->measured;
      const Matrix3d J = imu.BiasJacobian().block<3, 3>(0, 0);
      const Quaterniond seen =
          window.frames[i - 1].x.T_WB.q.conjugate() * window.frames[i].x.T_WB.q;
      H += J.transpose() * J;
      b += J.transpose() * LogSO3(imu.dR().conjugate() * seen);
    }
    const Vector3d step = H.ldlt().solve(b);
    for (WindowFrame& frame : window.frames) {
      frame.x.bias.b_g += step;
      if (frame.imu_link) frame.imu_link->measured.Reintegrate(frame.x.bias, window.GyroScale());
    }
  }
}

struct VelocityAndGravity {
  Vector3d v;  // of the first frame, in the vision frame
  Vector3d g;
};

// Equation (6.2) for all k, least squares: p_k - p_0 - R_0 dp_0k = v T + 1/2 g T^2.
VelocityAndGravity SolveVelocityAndGravity(const SlidingWindow& window) {
  const std::vector<WindowFrame>& frames = window.frames;
  ImuPreintegration total = frames[1].imu_link->measured;
  MatrixXd A(3 * (frames.size() - 1), 6);
  VectorXd y(3 * (frames.size() - 1));
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (k > 1) total.Append(frames[k].imu_link->measured);
    const double T = total.dt();
    const long row = static_cast<long>(3 * (k - 1));
    A.block<3, 3>(row, 0) = T * Matrix3d::Identity();
    A.block<3, 3>(row, 3) = 0.5 * T * T * Matrix3d::Identity();
    y.segment<3>(row) = frames[k].x.T_WB.p - frames[0].x.T_WB.p - frames[0].x.T_WB.q * total.dp();
  }
  const VectorXd solution = A.colPivHouseholderQr().solve(y);
  VelocityAndGravity result{solution.head<3>(), solution.tail<3>()};
  // Once more for the velocity, with gravity of the right length.
  const Vector3d g = total.g_W().norm() * result.g.normalized();
  const VectorXd rest = y - A.rightCols<3>() * g;
  const auto A_v = A.leftCols<3>();
  result.v = (A_v.transpose() * A_v).ldlt().solve(A_v.transpose() * rest);
  return result;
}

// Turns the world so that gravity points down, and fills the velocities.
void AlignWithGravity(const VelocityAndGravity& motion, SlidingWindow& window) {
  const Quaterniond q = RotationBetween(motion.g, GravityInWorld());
  const Vector3d origin = window.frames.front().x.T_WB.p;
  for (WindowFrame& frame : window.frames) {
    frame.x.T_WB.q = (q * frame.x.T_WB.q).normalized();
    frame.x.T_WB.p = origin + q * (frame.x.T_WB.p - origin);
  }
  window.frames.front().x.v_WB = q * motion.v;
  for (std::size_t i = 1; i < window.frames.size(); ++i) {
    window.frames[i].x.v_WB =
        window.frames[i].imu_link->measured.Predict(window.frames[i - 1].x).v_WB;
  }
  for (WindowFrame& frame : window.frames)
    frame.lin = frame.x;
}

}  // namespace

InitializationResult InitializeFromStereo(const StereoRig& rig,
                                          const EstimatorOptions& options,
                                          SlidingWindow& window) {
  if (window.frames.size() < 3) return {false, "fewer than three frames"};
  if (std::none_of(window.landmarks().begin(), window.landmarks().end(), IsConstraining)) {
    return {false, "no landmark with depth is seen twice"};
  }
  PredictRotations(window);
  if (!SolveVisionOnly(rig, options, window)) return {false, "stereo bundle adjustment failed"};
  SolveGyroBias(window);
  const VelocityAndGravity motion = SolveVelocityAndGravity(window);
  if (!motion.g.allFinite() ||
      std::abs(motion.g.norm() - options.imu.gravity_mps2) > kMaxGravityError) {
    return {false, "gravity from stereo and IMU is " + std::to_string(motion.g.norm()) + " m/s^2"};
  }
  AlignWithGravity(motion, window);
  return {true, ""};
}

}  // namespace facet
