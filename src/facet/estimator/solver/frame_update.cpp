// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/frame_update.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "facet/base/median.h"
#include "facet/estimator/factors/imu_factor.h"
#include "facet/estimator/factors/landmark_factors.h"
#include "facet/estimator/factors/robust_loss.h"
#include "facet/estimator/window/dead_reckoning.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr double kConverged = 1e-6;  // rad, m, m/s
// Sigmas. On clean recordings 0.1 to 0.2 % of the observations are beyond, most of them mismatches.
constexpr double kMaxInnovation = 8;

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

// Place and heading are left out, the tilt is not: with it gravity turns.
Matrix<15, 15> MotionCovariance(const Matrix<15, 15>& covariance, const Matrix3d& R_WB) {
  Matrix<15, 15> motion = covariance;
  motion.middleRows<3>(3).setZero();
  motion.middleCols<3>(3).setZero();
  Matrix3d without_heading = Matrix3d::Identity();
  without_heading(2, 2) = 0;
  const Matrix3d keep = R_WB.transpose() * without_heading * R_WB;
  motion.topRows<3>() = keep * motion.topRows<3>();
  motion.leftCols<3>() = motion.leftCols<3>() * keep.transpose();
  return motion;
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

NavState Moved(const NavState& x, const Vector<15>& step) {
  NavState moved = x;
  moved.T_WB = x.T_WB.Retract(step.head<3>(), step.segment<3>(3));
  moved.v_WB += step.segment<3>(6);
  moved.bias.b_g += step.segment<3>(9);
  moved.bias.b_a += step.segment<3>(12);
  return moved;
}

}  // namespace

// Landmarks that no solve has used, or that have lost something since, are linearised, and so are
// all after a solve whose loss had to be wide until the end.
LandmarkInformation FrameUpdater::InformationOn(const WindowLandmark& landmark,
                                                const SlidingWindow& window,
                                                const FactorNoise& noise) {
  constexpr double kTooWide = 1.5;
  const LandmarkInformation& known = landmark.information;
  if (known.num_rows > 0 && known.num_rows == CountRows(landmark) &&
      known.loss_width <= kTooWide * noise.reprojection_width)
    return known;
  LinearizeLandmark(geometry_, window.planes, landmark, noise, block_);
  return {block_.V, TangentBasis(landmark.bearing_H)};
}

void FrameUpdater::SetReference(const SlidingWindow& window,
                                const Matrix<15, 15>& covariance,
                                const FactorNoise& noise) {
  reference_ = window.frames.back().x;
  reference_information_ = Information(covariance);
  reference_motion_covariance_ = MotionCovariance(covariance, reference_.T_WB.R());

  geometry_.Update(window);
  landmarks_.clear();
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.has_depth) continue;
    HeldLandmark held;
    const FrameGeometry::Pose& host = geometry_.current(landmark.host);
    held.d_W = host.R_WC0 * landmark.bearing_H;
    const LandmarkInformation known = InformationOn(landmark, window, noise);
    held.B_W = host.R_WC0 * known.basis_H;
    held.rho = landmark.inverse_distance;
    held.p_WH = host.p_WC0;
    held.is_projection = landmark.is_projection;
    held.is_witness = landmark.IsWitness();
    held.is_seen = landmark.observations.back().frame == window.newest_frame();
    // The ridge stands for a distance known to 1/m at best.
    held.covariance = (known.V + Matrix3d(Vector3d(1e-6, 1e-6, 1.0).asDiagonal())).inverse();
    landmarks_.emplace(landmark.id, held);
  }
}

std::vector<FrameUpdater::Match> FrameUpdater::FindMatches(
    const std::vector<PreparedObservation>& observations) const {
  std::vector<Match> matches;
  matches.reserve(observations.size());
  for (const PreparedObservation& o : observations) {
    const auto it = landmarks_.find(o.landmark);
    if (it != landmarks_.end() && it->second.is_seen)
      matches.push_back({&it->second, &o.observation});
  }
  return matches;
}

double FrameUpdater::MedianError(const std::vector<Match>& matches, const View& view) {
  const Matrix3d R_CW = geometry_.R_CB[0] * view.T_HB.R().transpose();
  const Vector3d p_WC = view.T_HB * geometry_.p_BC[0];
  errors_.clear();
  for (const auto& [landmark, observation] : matches) {
    const Vector3d h = R_CW * (landmark->d_W + landmark->rho * (landmark->p_WH - p_WC));
    if (!observation->rays[0].IsNear(h) || landmark->is_projection) continue;
    errors_.push_back(ErrorOf(*observation, 0, h).norm());
  }
  return Median(errors_).value_or(0.0);
}

// The landmarks are held to the reference: they see the frame from where it was first estimated.
FrameUpdater::View FrameUpdater::ViewOf(const NavState& reference,
                                        const NavState& frame,
                                        const ImuLink& imu) const {
  const ImageMotion motion = MotionToImage(imu, frame, geometry_.time_offset());
  const SE3 T_WB = geometry_.AtImage(
      frame.T_WB, {motion.w_B, frame.T_WB.q.conjugate() * frame.v_WB + motion.dv_B});
  View view;
  view.T_HB = reference_.T_WB * (reference.T_WB.Inverse() * T_WB);
  view.R_BH = view.T_HB.R().transpose();
  view.R_BW = frame.T_WB.R().transpose();
  return view;
}

Vector2d FrameUpdater::ErrorOf(const WindowObservation& observation,
                               int camera,
                               const Vector3d& h) const {
  return observation.rays[camera].Error(h) +
         geometry_.LensShift_px(observation, camera) / observation.sigma_px[camera];
}

bool FrameUpdater::Linearize(
    const Match& match, int camera, const View& view, double scale, Rows& rows) const {
  const auto& [landmark, observation] = match;
  const Vector3d baseline_B = view.R_BH * (landmark->p_WH - view.T_HB.p);
  const Vector3d l_B = view.R_BH * landmark->d_W + landmark->rho * baseline_B;
  const Vector3d h = geometry_.R_CB[camera] * (l_B - landmark->rho * geometry_.p_BC[camera]);
  const MeasuredRay& ray = observation->rays[camera];
  if (!ray.IsNear(h)) return false;
  const Matrix<2, 3> A = scale * ray.ErrorByDirection(h) * geometry_.R_CB[camera];
  rows.r = scale * ErrorOf(*observation, camera, h);
  rows.J_landmark.leftCols<2>() = A * (view.R_BH * landmark->B_W);
  rows.J_landmark.col(2) = A * (baseline_B - geometry_.p_BC[camera]);
  rows.J_pose.leftCols<3>() = A * Hat(l_B);
  rows.J_pose.rightCols<3>() = -landmark->rho * (A * view.R_BW);
  return true;
}

void FrameUpdater::AddVision(const std::vector<Match>& matches,
                             const NavState& reference,
                             const NavState& frame,
                             const View& view,
                             const FactorNoise& noise,
                             System& system) const {
  PoseSystem pose;
  Rows rows;
  for (const Match& match : matches) {
    const auto& [landmark, observation] = match;
    for (int c = 0; c < (observation->has_right ? 2 : 1); ++c) {
      const double scale =
          landmark->is_projection ? observation->sigma_px[c] / noise.projection.sigma_px : 1.0;
      if (Linearize(match, c, view, scale, rows))
        AddRows(rows, landmark->covariance, noise.reprojection_width, pose);
    }
  }
  AddRelativePose(pose, RigidMotion(reference.T_WB, frame.T_WB), system);
}

InnovationTest FrameUpdater::TestInnovations(const std::vector<PreparedObservation>& observations,
                                             const ImuLink& imu) const {
  InnovationTest test;
  test.agrees.assign(observations.size(), 0);
  test.contradicts.assign(observations.size(), 0);
  test.is_witness.assign(observations.size(), 0);
  const Matrix<6, 6> P = Reckon({reference_, reference_motion_covariance_}, imu.measured, walk_)
                             .covariance.topLeftCorner<6, 6>();
  const NavState predicted = imu.measured.Predict(reference_);
  const View view = ViewOf(reference_, predicted, imu);
  Rows rows;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const auto it = landmarks_.find(observations[i].landmark);
    if (it == landmarks_.end()) continue;
    const HeldLandmark& landmark = it->second;
    if (!Linearize({&landmark, &observations[i].observation}, 0, view, 1.0, rows)) continue;
    const Matrix2d S = Matrix2d::Identity() +
                       rows.J_landmark * landmark.covariance * rows.J_landmark.transpose() +
                       rows.J_pose * P * rows.J_pose.transpose();
    const double d = std::sqrt(rows.r.dot(S.inverse() * rows.r));
    const bool contradicts = d > kMaxInnovation;
    (contradicts ? test.contradicts : test.agrees)[i] = 1;
    ++test.num_tested;
    test.num_contradicting += contradicts ? 1 : 0;
    if (!landmark.is_witness) continue;
    test.is_witness[i] = 1;
    ++test.num_witnesses;
    test.num_contradicting_witnesses += contradicts ? 1 : 0;
  }
  return test;
}

// The pixel noise grows by what the landmark's own uncertainty adds.
void FrameUpdater::AddRows(const Rows& rows,
                           const Matrix3d& landmark_covariance,
                           double width,
                           PoseSystem& pose) const {
  const Matrix2d S =
      Matrix2d::Identity() + rows.J_landmark * landmark_covariance * rows.J_landmark.transpose();
  const Matrix2d S_inv = S.inverse();
  const double s = std::sqrt(rows.r.dot(S_inv * rows.r));
  if (s > std::max(options_.outlier_sigma, width)) return;
  const double root_weight = GemanMcClureLoss(s, width).root_weight;
  const Matrix<6, 2> JtS = (root_weight * root_weight) * rows.J_pose.transpose() * S_inv;
  pose.H.noalias() += JtS * rows.J_pose;
  pose.b.noalias() += JtS * rows.r;
}

// Only the motion between the two counts: J_reference = -J_frame G.
void FrameUpdater::AddRelativePose(const PoseSystem& pose, const Matrix<6, 6>& G, System& system) {
  const Matrix<6, 6> HG = pose.H * G;
  system.H.block<6, 6>(kFrame, kFrame) += pose.H;
  system.H.block<6, 6>(kFrame, 0) -= HG;
  system.H.block<6, 6>(0, kFrame) -= HG.transpose();
  system.H.block<6, 6>(0, 0) += G.transpose() * HG;
  system.b.segment<6>(kFrame) += pose.b;
  system.b.head<6>() -= G.transpose() * pose.b;
}

void FrameUpdater::AddImu(const ImuLink& imu,
                          const NavState& reference,
                          const NavState& frame,
                          System& system) {
  const ImuResidual linear =
      LinearizeImu(imu.measured, reference, frame, imu.measured.gyro_scale());
  const ImuSquares squares = Square(imu.sqrt_info, linear, imu.sqrt_info * linear.r);
  system.H += squares.H;
  system.b += squares.b;
}

FrameUpdateResult FrameUpdater::Update(const std::vector<PreparedObservation>& observations,
                                       const ImuLink& imu,
                                       const FactorNoise& noise,
                                       NavState& x) {
  FrameUpdateResult result;
  const std::vector<Match> matches = FindMatches(observations);
  result.num_used = static_cast<int>(matches.size());

  NavState reference = reference_;
  Vector<15> reference_step = Vector<15>::Zero();
  System system;
  Eigen::LLT<Matrix<30, 30>> factor;
  for (int iteration = 0; iteration < options_.frame_iterations; ++iteration) {
    auto& [H, b] = system;
    H.setZero();
    b.setZero();
    H.topLeftCorner<15, 15>() = reference_information_;
    b.head<15>() = reference_information_ * reference_step;
    AddImu(imu, reference, x, system);
    // After a poor prediction everything would look like an outlier.
    FactorNoise now = noise;
    const View view = ViewOf(reference, x, imu);
    now.reprojection_width =
        std::max(noise.reprojection_width, options_.loss_width * MedianError(matches, view));
    AddVision(matches, reference, x, view, now, system);
    factor.compute(H);
    if (factor.info() != Eigen::Success) return result;
    const Vector<30> step = -factor.solve(b);
    if (!step.allFinite()) return result;
    reference_step += step.head<15>();
    reference = Moved(reference, step.head<15>());
    x = Moved(x, step.tail<15>());
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
