// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/frame_update.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "facet/base/median.h"
#include "facet/estimator/factors/robust_loss.h"

namespace facet {

namespace {

constexpr double kMinDepth = 0.05;
constexpr double kConverged = 1e-6;  // rad, m, m/s

// Columns: 0..14 the reference, 15..29 the frame.
constexpr int kFrame = 15;

// Inverse of a covariance whose variances span ten orders of magnitude.
Matrix<15, 15> Information(const Matrix<15, 15>& covariance) {
  const Vector<15> inv_sigma = covariance.diagonal().cwiseMax(1e-18).cwiseSqrt().cwiseInverse();
  const Matrix<15, 15> correlation = inv_sigma.asDiagonal() * covariance * inv_sigma.asDiagonal();
  const Matrix<15, 15> inverse =
      (correlation + 1e-10 * Matrix<15, 15>::Identity()).llt().solve(Matrix<15, 15>::Identity());
  return inv_sigma.asDiagonal() * inverse * inv_sigma.asDiagonal();
}

// How the frame moves (theta p) when the reference and all that is held to it moves rigidly.
Matrix<6, 6> RigidMotion(const SE3& reference, const SE3& frame) {
  Matrix<6, 6> G = Matrix<6, 6>::Zero();
  const Matrix3d R_ref = reference.R();
  G.block<3, 3>(0, 0) = frame.R().transpose() * R_ref;
  G.block<3, 3>(3, 0) = -Hat(frame.p - reference.p) * R_ref;
  G.block<3, 3>(3, 3) = Matrix3d::Identity();
  return G;
}

}  // namespace

void FrameUpdater::SetReference(const SlidingWindow& window, const Matrix<15, 15>& covariance) {
  const int newest = static_cast<int>(window.frames.size()) - 1;
  reference_ = window.frames.back();
  reference_.pose_frozen = reference_.motion_frozen = false;
  reference_information_ = Information(covariance);

  geometry_.Update(window.frames);
  landmarks_.clear();
  LandmarkBlock block;
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.has_depth || landmark.observations.back().frame != newest) continue;
    LinearizeLandmark(geometry_, window.planes, landmark, robust_, block);
    HeldLandmark held;
    const FrameGeometry::Pose& host = geometry_.current(landmark.host);
    held.d_W = host.R_WC0 * landmark.bearing_H;
    held.B_W = host.R_WC0 * TangentBasis(landmark.bearing_H);
    held.rho = landmark.inverse_distance;
    held.p_WH = host.p_WC0;
    held.is_projection = landmark.is_projection;
    // The ridge stands for a distance known to 1/m at best.
    held.covariance = (block.V + Matrix3d(Vector3d(1e-6, 1e-6, 1.0).asDiagonal())).inverse();
    landmarks_.emplace(landmark.id, held);
  }
}

double FrameUpdater::MedianError(const std::vector<Match>& matches,
                                 const WindowFrame& reference,
                                 const WindowFrame& frame) {
  const SE3 T_HB = reference_.x.T_WB * (reference.x.T_WB.Inverse() * frame.x.T_WB);
  const Matrix3d R_CW = geometry_.R_CB[0] * T_HB.R().transpose();
  const Vector3d p_WC = T_HB * geometry_.p_BC[0];
  errors_.clear();
  for (const auto& [landmark, observation] : matches) {
    const Vector3d h = R_CW * (landmark->d_W + landmark->rho * (landmark->p_WH - p_WC));
    if (h.z() < kMinDepth || landmark->is_projection) continue;
    errors_.push_back(
        (observation->sqrt_info[0] * (h.head<2>() / h.z() - observation->xy[0])).norm());
  }
  return Median(errors_).value_or(0.0);
}

void FrameUpdater::AddVision(const std::vector<Match>& matches,
                             const WindowFrame& reference,
                             const WindowFrame& frame,
                             double width,
                             System& system) const {
  // The landmarks are held to the reference: they see the frame from where it was first estimated.
  const SE3 T_HB = reference_.x.T_WB * (reference.x.T_WB.Inverse() * frame.x.T_WB);
  const Matrix3d R_BH = T_HB.R().transpose();
  const Matrix3d R_BW = frame.x.T_WB.R().transpose();
  Matrix<6, 6> H = Matrix<6, 6>::Zero();
  Vector<6> b = Vector<6>::Zero();
  for (const auto& [landmark, observation] : matches) {
    const Vector3d baseline_B = R_BH * (landmark->p_WH - T_HB.p);
    const Vector3d l_B = R_BH * landmark->d_W + landmark->rho * baseline_B;
    for (int c = 0; c < (observation->has_right ? 2 : 1); ++c) {
      const Vector3d h = geometry_.R_CB[c] * (l_B - landmark->rho * geometry_.p_BC[c]);
      if (h.z() < kMinDepth) continue;
      const double scale =
          landmark->is_projection ? observation->sigma_px[c] / robust_.projection.sigma_px : 1.0;
      const Matrix2d sqrt_info = scale * observation->sqrt_info[c];
      const Vector2d r = sqrt_info * (h.head<2>() / h.z() - observation->xy[c]);
      Matrix<2, 3> J_h;
      J_h << 1, 0, -h.x() / h.z(), 0, 1, -h.y() / h.z();
      const Matrix<2, 3> A = (1.0 / h.z()) * (sqrt_info * J_h) * geometry_.R_CB[c];
      Matrix<2, 3> Jl;
      Jl.leftCols<2>() = A * (R_BH * landmark->B_W);
      Jl.col(2) = A * (baseline_B - geometry_.p_BC[c]);
      Matrix<2, 6> Jp;
      Jp.leftCols<3>() = A * Hat(l_B);
      Jp.rightCols<3>() = -landmark->rho * (A * R_BW);
      // What the landmark's own uncertainty adds to the pixel noise.
      const Matrix2d S = Matrix2d::Identity() + Jl * landmark->covariance * Jl.transpose();
      const Matrix2d S_inv = S.inverse();
      const double s = std::sqrt(r.dot(S_inv * r));
      if (s > std::max(options_.outlier_sigma, width)) continue;
      const double root_weight = GemanMcClureLoss(s, width).root_weight;
      const Matrix<6, 2> JtS = (root_weight * root_weight) * Jp.transpose() * S_inv;
      H.noalias() += JtS * Jp;
      b.noalias() += JtS * r;
    }
  }
  // Only the motion between the two counts: J_reference = -J_frame G.
  const Matrix<6, 6> G = RigidMotion(reference.x.T_WB, frame.x.T_WB);
  const Matrix<6, 6> HG = H * G;
  system.first.block<6, 6>(kFrame, kFrame) += H;
  system.first.block<6, 6>(kFrame, 0) -= HG;
  system.first.block<6, 6>(0, kFrame) -= HG.transpose();
  system.first.block<6, 6>(0, 0) += G.transpose() * HG;
  system.second.segment<6>(kFrame) += b;
  system.second.head<6>() -= G.transpose() * b;
}

void FrameUpdater::AddImu(const WindowFrame& reference,
                          const WindowFrame& frame,
                          System& system) const {
  const ImuResidual linear = LinearizeImu(frame.imu, reference.x, frame.x);
  Matrix<15, 30> J;
  J.leftCols<15>().noalias() = frame.imu_sqrt_info * linear.J_i;
  J.rightCols<15>().noalias() = frame.imu_sqrt_info * linear.J_j;
  system.first.noalias() += J.transpose() * J;
  system.second.noalias() += J.transpose() * (frame.imu_sqrt_info * linear.r);
}

FrameUpdateResult FrameUpdater::Update(const std::vector<PreparedObservation>& observations,
                                       WindowFrame& frame) {
  FrameUpdateResult result;
  std::vector<Match> matches;
  matches.reserve(observations.size());
  for (const PreparedObservation& o : observations) {
    const auto it = landmarks_.find(o.landmark);
    if (it != landmarks_.end()) matches.push_back({&it->second, &o.observation});
  }
  result.num_used = static_cast<int>(matches.size());

  WindowFrame reference = reference_;
  Vector<15> reference_step = Vector<15>::Zero();
  System system;
  Eigen::LLT<Matrix<30, 30>> factor;
  for (int iteration = 0; iteration < options_.frame_iterations; ++iteration) {
    auto& [H, b] = system;
    H.setZero();
    b.setZero();
    H.topLeftCorner<15, 15>() = reference_information_;
    b.head<15>() = reference_information_ * reference_step;
    AddImu(reference, frame, system);
    // After a poor prediction everything would look like an outlier.
    const double width = std::max(robust_.reprojection_width,
                                  options_.loss_width * MedianError(matches, reference, frame));
    AddVision(matches, reference, frame, width, system);
    factor.compute(H);
    if (factor.info() != Eigen::Success) return result;
    const Vector<30> step = -factor.solve(b);
    if (!step.allFinite()) return result;
    reference_step += step.head<15>();
    reference.ApplyStep(step.head<15>());
    frame.ApplyStep(step.tail<15>());
    if (step.segment<9>(kFrame).cwiseAbs().maxCoeff() < kConverged) break;
  }
  Matrix<30, 15> columns = Matrix<30, 15>::Zero();
  columns.bottomRows<15>().setIdentity();
  factor.matrixL().solveInPlace(columns);
  result.covariance = columns.transpose() * columns;
  result.ok = true;
  return result;
}

}  // namespace facet
