// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/vision_factor.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

// The homogeneous point has about unit length: smaller than this is beside or behind the camera.
constexpr double kMinDepth = 0.05;
// Cost of a row whose point is behind the camera, in sigmas: bad, but finite.
constexpr double kBehindSigma = 30.0;

// Less information than this on a direction of a landmark (1-sigma of 30 rad or 30/m) counts as
// none.
constexpr double kMinInformation = 1e-3;
constexpr double kNoInformationPivot = 1e100;

double HuberCost(double s, double k) {
  return s <= k ? 0.5 * s * s : k * (s - 0.5 * k);
}

// Homogeneous point in the body frame of the target: R_BW (d_W + rho (p_host - p_target)).
Vector3d PointInBody(const FrameGeometry::Pose& host,
                     const FrameGeometry::Pose& target,
                     const Vector3d& d_W,
                     double rho) {
  return target.R_BW * (d_W + rho * (host.p_WC0 - target.p_WB));
}

// Adds the two rows of one camera to the block and the view.
void AddRows(const Matrix<2, 6>& Jp,
             const Matrix<2, 3>& Jl,
             const Vector2d& r,
             LandmarkBlock& block,
             LandmarkBlock::View& view) {
  view.H.noalias() += Jp.transpose() * Jp;
  view.b.noalias() += Jp.transpose() * r;
  view.W.noalias() += Jp.transpose() * Jl;
  block.V.noalias() += Jl.transpose() * Jl;
  block.b.noalias() += Jl.transpose() * r;
}

FrameGeometry::Pose MakePose(const SE3& T_WB, const SE3& T_BC0) {
  FrameGeometry::Pose pose;
  const Matrix3d R_WB = T_WB.R();
  pose.R_BW = R_WB.transpose();
  pose.p_WB = T_WB.p;
  pose.R_WC0 = R_WB * T_BC0.R();
  pose.p_WC0 = T_WB.p + R_WB * T_BC0.p;
  return pose;
}

}  // namespace

FrameGeometry::FrameGeometry(const StereoRig& rig) {
  for (int c = 0; c < 2; ++c) {
    R_CB[c] = rig.T_BC[c].R().transpose();
    p_BC[c] = rig.T_BC[c].p;
  }
}

void FrameGeometry::Update(const std::vector<WindowFrame>& frames) {
  const SE3 T_BC0(Quaterniond(Matrix3d(R_CB[0].transpose())), p_BC[0]);
  current_.resize(frames.size());
  frozen_.resize(frames.size());
  is_frozen_.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    is_frozen_[i] = frames[i].pose_frozen;
    current_[i] = MakePose(frames[i].x.T_WB, T_BC0);
    frozen_[i] = frames[i].pose_frozen ? MakePose(frames[i].lin.T_WB, T_BC0) : current_[i];
  }
}

std::optional<Vector2d> WhitenedError(const FrameGeometry& geometry,
                                      const WindowLandmark& landmark,
                                      const WindowObservation& observation,
                                      int camera) {
  const FrameGeometry::Pose& host = geometry.current(landmark.host);
  const Vector3d l_B = PointInBody(host,
                                   geometry.current(observation.frame),
                                   host.R_WC0 * landmark.bearing_H,
                                   landmark.inverse_distance);
  const Vector3d h =
      geometry.R_CB[camera] * (l_B - landmark.inverse_distance * geometry.p_BC[camera]);
  if (h.z() < kMinDepth) return std::nullopt;
  return Vector2d(observation.sqrt_info[camera] * (h.head<2>() / h.z() - observation.xy[camera]));
}

void LinearizeLandmark(const FrameGeometry& geometry,
                       const WindowLandmark& landmark,
                       const RobustOptions& robust,
                       LandmarkBlock& block) {
  const double rho = landmark.inverse_distance;
  const FrameGeometry::Pose& host = geometry.frozen(landmark.host);
  const Vector3d d_W = host.R_WC0 * landmark.bearing_H;
  const Matrix<3, 2> B_W = host.R_WC0 * TangentBasis(landmark.bearing_H);

  block.cost = 0;
  block.V.setZero();
  block.b.setZero();
  block.num_views = static_cast<int>(landmark.observations.size());
  if (block.views.size() < landmark.observations.size())
    block.views.resize(landmark.observations.size());
  for (int v = 0; v < block.num_views; ++v) {
    const WindowObservation& obs = landmark.observations[v];
    const FrameGeometry::Pose& target = geometry.frozen(obs.frame);
    LandmarkBlock::View& view = block.views[v];
    view.frame = obs.frame;
    view.H.setZero();
    view.b.setZero();
    view.W.setZero();
    const Vector3d l_B = PointInBody(host, target, d_W, rho);
    const Vector3d baseline_B = target.R_BW * (host.p_WC0 - target.p_WB);
    const Matrix<3, 2> B_B = target.R_BW * B_W;
    for (int c = 0; c < (obs.has_right ? 2 : 1); ++c) {
      const std::optional<Vector2d> error = WhitenedError(geometry, landmark, obs, c);
      const Vector3d h = geometry.R_CB[c] * (l_B - rho * geometry.p_BC[c]);
      if (!error || h.z() < kMinDepth) {
        block.cost += HuberCost(kBehindSigma, robust.huber_sigma);
        continue;
      }
      const double s = error->norm();
      block.cost += HuberCost(s, robust.huber_sigma);
      const double root_weight = s <= robust.huber_sigma ? 1.0 : std::sqrt(robust.huber_sigma / s);
      Matrix<2, 3> J_h;
      J_h << 1, 0, -h.x() / h.z(), 0, 1, -h.y() / h.z();
      const Matrix<2, 3> A = (root_weight / h.z()) * (obs.sqrt_info[c] * J_h) * geometry.R_CB[c];
      Matrix<2, 6> Jp;
      Jp.leftCols<3>() = A * Hat(l_B);
      Jp.rightCols<3>() = -rho * (A * target.R_BW);
      Matrix<2, 3> Jl;
      Jl.leftCols<2>() = A * B_B;
      Jl.col(2) = A * (baseline_B - geometry.p_BC[c]);
      AddRows(Jp, Jl, root_weight * *error, block, view);
    }
  }
}

double LandmarkCost(const FrameGeometry& geometry,
                    const WindowLandmark& landmark,
                    const RobustOptions& robust) {
  double cost = 0;
  for (const WindowObservation& obs : landmark.observations) {
    for (int c = 0; c < (obs.has_right ? 2 : 1); ++c) {
      const std::optional<Vector2d> error = WhitenedError(geometry, landmark, obs, c);
      cost += HuberCost(error ? error->norm() : kBehindSigma, robust.huber_sigma);
    }
  }
  return cost;
}

void Eliminate(double lambda, LandmarkBlock& block) {
  Matrix3d V = block.V;
  V.diagonal() += lambda * V.diagonal();
  // Cholesky by hand: a direction without information (no parallax, no view at all) gets an
  // infinite pivot, which leaves it where it is. A ridge instead would pretend to know it and leak
  // into the prior.
  Matrix3d& L = block.L;
  L.setZero();
  for (int c = 0; c < 3; ++c) {
    const double pivot = V(c, c) - L.row(c).head(c).squaredNorm();
    L(c, c) = pivot > kMinInformation ? std::sqrt(pivot) : kNoInformationPivot;
    for (int r = c + 1; r < 3; ++r) {
      L(r, c) = (V(r, c) - L.row(r).head(c).dot(L.row(c).head(c))) / L(c, c);
    }
  }
  block.y = L.triangularView<Eigen::Lower>().solve(block.b);
  for (int v = 0; v < block.num_views; ++v) {
    LandmarkBlock::View& view = block.views[v];
    view.Y.transpose() = L.triangularView<Eigen::Lower>().solve(view.W.transpose());
  }
}

}  // namespace facet
