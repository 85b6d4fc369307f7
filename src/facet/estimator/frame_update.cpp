// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/frame_update.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace facet {

namespace {

constexpr double kMinDepth = 0.05;
constexpr double kConverged = 1e-6;  // rad, m, m/s

// Columns: 0..8 motion of the reference, 9..23 the frame.
constexpr int kFrame = 9;

}  // namespace

void FrameUpdater::SetReference(const SlidingWindow& window, const Matrix<15, 15>& covariance) {
  const int newest = static_cast<int>(window.frames.size()) - 1;
  reference_ = window.frames.back();
  reference_covariance_ = covariance;
  const Matrix<9, 6> P_mp = covariance.bottomLeftCorner<9, 6>();
  const Matrix<6, 6> P_pp = covariance.topLeftCorner<6, 6>();
  const Matrix<9, 9> given_pose =
      covariance.bottomRightCorner<9, 9>() - P_mp * P_pp.ldlt().solve(P_mp.transpose());
  motion_information_ = (given_pose + 1e-14 * Matrix<9, 9>::Identity()).inverse();

  geometry_.Update(window.frames);
  landmarks_.clear();
  LandmarkBlock block;
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.has_depth || landmark.observations.back().frame != newest) continue;
    LinearizeLandmark(geometry_, landmark, RobustOptions{options_.huber_sigma}, block);
    HeldLandmark held;
    const FrameGeometry::Pose& host = geometry_.current(landmark.host);
    held.d_W = host.R_WC0 * landmark.bearing_H;
    held.B_W = host.R_WC0 * TangentBasis(landmark.bearing_H);
    held.rho = landmark.inverse_distance;
    held.p_WH = host.p_WC0;
    // The ridge stands for a distance known to 1/m at best.
    held.covariance = (block.V + Matrix3d(Vector3d(1e-6, 1e-6, 1.0).asDiagonal())).inverse();
    landmarks_.emplace(landmark.id, held);
  }
}

void FrameUpdater::AddVision(const std::vector<Match>& matches, const WindowFrame& frame, System& system) const {
  auto& [H, b] = system;
  const Matrix3d R_BW = frame.x.T_WB.R().transpose();
  for (const auto& [landmark, observation] : matches) {
    const Vector3d l_B = R_BW * (landmark->d_W + landmark->rho * (landmark->p_WH - frame.x.T_WB.p));
    const Vector3d baseline_B = R_BW * (landmark->p_WH - frame.x.T_WB.p);
    for (int c = 0; c < (observation->has_right ? 2 : 1); ++c) {
      const Vector3d h = geometry_.R_CB[c] * (l_B - landmark->rho * geometry_.p_BC[c]);
      if (h.z() < kMinDepth) continue;
      const Vector2d r = observation->sqrt_info[c] * (h.head<2>() / h.z() - observation->xy[c]);
      Matrix<2, 3> J_h;
      J_h << 1, 0, -h.x() / h.z(), 0, 1, -h.y() / h.z();
      const Matrix<2, 3> A = (1.0 / h.z()) * (observation->sqrt_info[c] * J_h) * geometry_.R_CB[c];
      Matrix<2, 3> Jl;
      Jl.leftCols<2>() = A * (R_BW * landmark->B_W);
      Jl.col(2) = A * (baseline_B - geometry_.p_BC[c]);
      Matrix<2, 6> Jp;
      Jp.leftCols<3>() = A * Hat(l_B);
      Jp.rightCols<3>() = -landmark->rho * (A * R_BW);
      // What the landmark's own uncertainty adds to the pixel noise.
      const Matrix2d S = Matrix2d::Identity() + Jl * landmark->covariance * Jl.transpose();
      const Matrix2d S_inv = S.inverse();
      const double s = std::sqrt(r.dot(S_inv * r));
      if (s > options_.outlier_sigma) continue;
      const double weight = s <= options_.huber_sigma ? 1.0 : options_.huber_sigma / s;
      const Matrix<6, 2> JtS = weight * Jp.transpose() * S_inv;
      H.block<6, 6>(kFrame, kFrame).noalias() += JtS * Jp;
      b.segment<6>(kFrame).noalias() += JtS * r;
    }
  }
}

void FrameUpdater::AddImu(const WindowFrame& reference, const WindowFrame& frame, System& system) const {
  auto& [H, b] = system;
  const ImuResidual linear = LinearizeImu(frame.imu, reference.x, frame.x);
  Matrix<15, 24> J;
  J.leftCols<9>() = frame.imu_sqrt_info * linear.J_i.rightCols<9>();
  J.rightCols<15>() = frame.imu_sqrt_info * linear.J_j;
  H.noalias() += J.transpose() * J;
  b.noalias() += J.transpose() * (frame.imu_sqrt_info * linear.r);
}

FrameUpdateResult FrameUpdater::Update(const std::vector<PreparedObservation>& observations, WindowFrame& frame) const {
  FrameUpdateResult result;
  std::vector<Match> matches;
  matches.reserve(observations.size());
  for (const PreparedObservation& o : observations) {
    const auto it = landmarks_.find(o.landmark);
    if (it != landmarks_.end()) matches.push_back({&it->second, &o.observation});
  }
  result.num_used = static_cast<int>(matches.size());

  WindowFrame reference = reference_;
  Vector<9> motion_step = Vector<9>::Zero();
  System system;
  for (int iteration = 0; iteration < options_.frame_iterations; ++iteration) {
    auto& [H, b] = system;
    H.setZero();
    b.setZero();
    H.topLeftCorner<9, 9>() = motion_information_;
    b.head<9>() = motion_information_ * motion_step;
    AddImu(reference, frame, system);
    AddVision(matches, frame, system);
    const Eigen::LLT<Matrix<24, 24>> factor(H);
    if (factor.info() != Eigen::Success) return result;
    const Vector<24> step = -factor.solve(b);
    if (!step.allFinite()) return result;
    motion_step += step.head<9>();
    reference.x.v_WB += step.segment<3>(0);
    reference.x.bias.b_g += step.segment<3>(3);
    reference.x.bias.b_a += step.segment<3>(6);
    frame.ApplyStep(step.tail<15>());
    if (step.segment<9>(kFrame).cwiseAbs().maxCoeff() < kConverged) break;
  }
  result.covariance = Covariance(system, frame);
  result.ok = true;
  return result;
}

Matrix<15, 15> FrameUpdater::Covariance(const System& system, const WindowFrame& frame) const {
  const Matrix<24, 24> inverse = system.first.llt().solve(Matrix<24, 24>::Identity());
  // The held pose moves everything with it: rotated about the reference, and shifted.
  const Matrix3d R_ref = reference_.x.T_WB.R();
  const Matrix3d R = frame.x.T_WB.R();
  Matrix<15, 6> G = Matrix<15, 6>::Zero();
  G.block<3, 3>(0, 0) = R.transpose() * R_ref;
  G.block<3, 3>(3, 0) = -R_ref * Hat(R_ref.transpose() * (frame.x.T_WB.p - reference_.x.T_WB.p));
  G.block<3, 3>(3, 3) = Matrix3d::Identity();
  G.block<3, 3>(6, 0) = -R_ref * Hat(R_ref.transpose() * frame.x.v_WB);
  const Matrix<6, 6> P_pp = reference_covariance_.topLeftCorner<6, 6>();
  // Biases go with the pose as they do in the reference.
  G.bottomRows<6>() = P_pp.ldlt().solve(reference_covariance_.block<6, 6>(0, 9)).transpose();
  return inverse.bottomRightCorner<15, 15>() + G * P_pp * G.transpose();
}

}  // namespace facet
