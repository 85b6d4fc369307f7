// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/vision_factor.h"

#include <algorithm>
#include <cmath>

#include "facet/estimator/factors/robust_loss.h"
#include "facet/estimator/factors/row_kernel.h"

namespace facet {

namespace {

// The homogeneous point has about unit length: smaller than this is beside or behind the camera.
constexpr double kMinDepth = 0.05;
// A point behind the camera counts as this far off, in sigmas and widths of the loss: as bad as
// any, but finite.
constexpr double kBehindSigma = 30.0;
constexpr double kBehindWidths = 10.0;

// Less information than this on a direction of a landmark (1-sigma of 30 rad or 30/m) counts as
// none.
constexpr double kMinInformation = 1e-3;
constexpr double kNoInformationPivot = 1e100;

RobustLoss ReprojectionLoss(const WindowLandmark& landmark, double s, const RobustOptions& robust) {
  return landmark.is_projection ? TukeyLoss(s, robust.projection.tukey_sigma)
                                : GemanMcClureLoss(s, robust.reprojection_width);
}

double BehindSigma(const RobustOptions& robust) {
  return std::max(kBehindSigma, kBehindWidths * robust.reprojection_width);
}

// A landmark as a homogeneous point of the world: direction from its host, inverse distance.
struct HostedPoint {
  Vector3d d_W;
  Vector3d p_WH;
  double rho;
};

HostedPoint Hosted(const WindowLandmark& landmark, const FrameGeometry::Pose& host) {
  return {host.R_WC0 * landmark.bearing_H, host.p_WC0, landmark.inverse_distance};
}

// The point as seen from p_W, in the axes of the world: d + rho (p_host - p).
Vector3d SeenFrom(const HostedPoint& point, const Vector3d& p_W) {
  return point.d_W + point.rho * (point.p_WH - p_W);
}

std::optional<Vector2d> WhitenedErrorAt(const HostedPoint& point,
                                        const FrameGeometry::Pose& target,
                                        const WindowObservation& obs,
                                        int camera) {
  const Vector3d h = target.R_CW[camera] * SeenFrom(point, target.p_WC[camera]);
  if (h.z() < kMinDepth) return std::nullopt;
  return Vector2d(obs.sqrt_info[camera] * (h.head<2>() / h.z() - obs.xy[camera]));
}

FrameGeometry::Pose MakePose(const FrameGeometry& geometry, const SE3& T_WB) {
  FrameGeometry::Pose pose;
  const Matrix3d R_WB = T_WB.R();
  pose.R_BW = R_WB.transpose();
  pose.p_WB = T_WB.p;
  for (int c = 0; c < 2; ++c) {
    pose.R_CW[c] = geometry.R_CB[c] * pose.R_BW;
    pose.p_WC[c] = T_WB.p + R_WB * geometry.p_BC[c];
  }
  pose.R_WC0 = pose.R_CW[0].transpose();
  pose.p_WC0 = pose.p_WC[0];
  return pose;
}

// One camera's two rows, whitened and weighted. The landmark's columns: B_W spans the tangent of
// the bearing in the world.
void MakeRows(const HostedPoint& point,
              const Matrix<3, 2>& B_W,
              const FrameGeometry::Pose& target,
              const WindowObservation& obs,
              int camera,
              const Vector3d& h,
              double root_weight,
              const Vector2d& error,
              VisionRow* rows) {
  const double scale = root_weight / h.z();
  const Matrix2d S = scale * obs.sqrt_info[camera];
  const Vector2d S_xy = S * (h.head<2>() / h.z());
  const Vector3d l_W = SeenFrom(point, target.p_WB);
  const Vector3d baseline_W = point.p_WH - target.p_WC[camera];
  const Matrix3d& R_CW = target.R_CW[camera];
  for (int k = 0; k < 2; ++k) {
    // a = row of (d error / d h) R_CW.
    const Vector3d a = R_CW.transpose() * Vector3d(S(k, 0), S(k, 1), -S_xy(k));
    VisionRow& row = rows[k];
    Eigen::Map<Vector3d>(row.pose) = target.R_BW * a.cross(l_W);  // a^T Hat(l) = (a x l)^T
    Eigen::Map<Vector3d>(row.pose + 3) = -point.rho * a;
    row.landmark[0] = a.dot(B_W.col(0));
    row.landmark[1] = a.dot(B_W.col(1));
    row.landmark[2] = a.dot(baseline_W);
    row.residual = root_weight * error(k);
  }
}

double PlaneError(const HostedPoint& point, const WindowPlane& plane) {
  return plane.SignedDistance(point.p_WH + point.d_W / point.rho) / plane.row_sigma_m;
}

// The rows n . (l - anchor) - offset of all planes of a landmark; l = p_host + d / rho.
void AddPlaneRows(const HostedPoint& current,
                  const HostedPoint& frozen,
                  const Matrix<3, 2>& B_W,
                  const std::vector<WindowPlane>& planes,
                  const WindowLandmark& landmark,
                  const RobustOptions& robust,
                  LandmarkBlock& block) {
  block.num_plane_views = landmark.IsOnPlanes() ? landmark.planes.count : 0;
  if (block.num_plane_views == 0) return;
  const double distance = 1.0 / frozen.rho;
  const Vector3d l_W = frozen.p_WH + frozen.d_W * distance;
  for (int k = 0; k < block.num_plane_views; ++k) {
    LandmarkBlock::PlaneView& view = block.plane_views[static_cast<std::size_t>(k)];
    view.plane = landmark.planes.index[static_cast<std::size_t>(k)];
    const WindowPlane& plane = planes[view.plane];
    const double error = PlaneError(current, plane);
    const RobustLoss loss = HuberLoss(std::abs(error), robust.plane_huber_sigma);
    block.cost += loss.cost;
    const double scale = loss.root_weight / plane.row_sigma_m;
    view.J_plane << scale * (TangentBasis(plane.n_lin).transpose() * (l_W - plane.anchor_W)),
        -scale;
    view.J_landmark << scale * distance * (B_W.transpose() * plane.n_lin),
        -scale * distance * distance * plane.n_lin.dot(frozen.d_W);
    view.residual = loss.root_weight * error;
    block.V += view.J_landmark * view.J_landmark.transpose();
    block.b += view.J_landmark * view.residual;
  }
}

}  // namespace

FrameGeometry::FrameGeometry(const StereoRig& rig) {
  for (int c = 0; c < 2; ++c) {
    R_CB[c] = rig.T_BC[c].R().transpose();
    p_BC[c] = rig.T_BC[c].p;
  }
}

void FrameGeometry::Update(const std::vector<WindowFrame>& frames) {
  current_.resize(frames.size());
  frozen_.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    current_[i] = MakePose(*this, frames[i].x.T_WB);
    frozen_[i] = frames[i].pose_frozen ? MakePose(*this, frames[i].lin.T_WB) : current_[i];
  }
}

std::optional<Vector2d> WhitenedError(const FrameGeometry& geometry,
                                      const WindowLandmark& landmark,
                                      const WindowObservation& observation,
                                      int camera) {
  const HostedPoint point = Hosted(landmark, geometry.current(landmark.host));
  return WhitenedErrorAt(point, geometry.current(observation.frame), observation, camera);
}

double NoiseScale(const WindowLandmark& landmark,
                  const WindowObservation& observation,
                  int camera,
                  const RobustOptions& robust) {
  return landmark.is_projection ? observation.sigma_px[camera] / robust.projection.sigma_px : 1.0;
}

void LinearizeLandmark(const FrameGeometry& geometry,
                       const std::vector<WindowPlane>& planes,
                       const WindowLandmark& landmark,
                       const RobustOptions& robust,
                       LandmarkBlock& block) {
  const HostedPoint current = Hosted(landmark, geometry.current(landmark.host));
  const FrameGeometry::Pose& host = geometry.frozen(landmark.host);
  const HostedPoint frozen = Hosted(landmark, host);
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
    VisionRow rows[4] = {};  // two of each camera
    for (int c = 0; c < (obs.has_right ? 2 : 1); ++c) {
      const std::optional<Vector2d> error =
          WhitenedErrorAt(current, geometry.current(obs.frame), obs, c);
      const double scale = NoiseScale(landmark, obs, c, robust);
      const RobustLoss loss =
          ReprojectionLoss(landmark, error ? scale * error->norm() : BehindSigma(robust), robust);
      block.cost += loss.cost;
      const Vector3d h = target.R_CW[c] * SeenFrom(frozen, target.p_WC[c]);
      if (!error || h.z() < kMinDepth) continue;
      MakeRows(frozen, B_W, target, obs, c, h, scale * loss.root_weight, *error, rows + 2 * c);
    }
    SquaredRows G;
    if (obs.has_right) {
      SquareRows<4>(rows, G);
    } else {
      SquareRows<2>(rows, G);
    }
    LandmarkBlock::View& view = block.views[v];
    view.frame = obs.frame;
    view.H = Eigen::Map<const Matrix<6, 6>>(G.H);
    view.b = Eigen::Map<const Vector<6>>(G.b);
    view.W = Eigen::Map<const Matrix<6, 3>>(G.W);
    const Eigen::Map<const Matrix<4, 3>> V(G.V);
    block.V += V.topRows<3>();
    block.b += V.row(3).transpose();
  }
  AddPlaneRows(current, frozen, B_W, planes, landmark, robust, block);
}

double LandmarkCost(const FrameGeometry& geometry,
                    const std::vector<WindowPlane>& planes,
                    const WindowLandmark& landmark,
                    const RobustOptions& robust) {
  double cost = 0;
  const HostedPoint point = Hosted(landmark, geometry.current(landmark.host));
  for (const WindowObservation& obs : landmark.observations) {
    for (int c = 0; c < (obs.has_right ? 2 : 1); ++c) {
      const auto error = WhitenedErrorAt(point, geometry.current(obs.frame), obs, c);
      const double s =
          error ? NoiseScale(landmark, obs, c, robust) * error->norm() : BehindSigma(robust);
      cost += ReprojectionLoss(landmark, s, robust).cost;
    }
  }
  for (int k = 0; landmark.IsOnPlanes() && k < landmark.planes.count; ++k) {
    const WindowPlane& plane = planes[landmark.planes.index[static_cast<std::size_t>(k)]];
    cost += HuberLoss(std::abs(PlaneError(point, plane)), robust.plane_huber_sigma).cost;
  }
  return cost;
}

namespace {

// Y L^T = W, column by column.
template <class M>
void SolveFromRight(const Matrix3d& L, const Vector3d& inverse_diagonal, const M& W, M& Y) {
  Y.col(0) = inverse_diagonal(0) * W.col(0);
  Y.col(1) = inverse_diagonal(1) * (W.col(1) - L(1, 0) * Y.col(0));
  Y.col(2) = inverse_diagonal(2) * (W.col(2) - L(2, 0) * Y.col(0) - L(2, 1) * Y.col(1));
}

}  // namespace

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
  const Vector3d inv = L.diagonal().cwiseInverse();
  for (int v = 0; v < block.num_views; ++v)
    SolveFromRight(L, inv, block.views[v].W, block.views[v].Y);
  for (int k = 0; k < block.num_plane_views; ++k) {
    LandmarkBlock::PlaneView& view = block.plane_views[static_cast<std::size_t>(k)];
    view.z = L.triangularView<Eigen::Lower>().solve(view.J_landmark);
  }
}

}  // namespace facet
