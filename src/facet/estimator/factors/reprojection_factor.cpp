// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/reprojection_factor.h"

#include <algorithm>
#include <cmath>

#include "facet/estimator/factors/robust_loss.h"
#include "facet/estimator/factors/row_kernel.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// A point behind the camera counts as this far off, in sigmas and widths of the loss: as bad as
// any, but finite.
constexpr double kBehindSigma = 30.0;
constexpr double kBehindWidths = 10.0;

RobustLoss ReprojectionLoss(const WindowLandmark& landmark, double s, const FactorNoise& noise) {
  return landmark.is_projection ? TukeyLoss(s, noise.projection.tukey_sigma)
                                : GemanMcClureLoss(s, noise.reprojection_width);
}

double BehindSigma(const FactorNoise& noise) {
  return std::max(kBehindSigma, kBehindWidths * noise.reprojection_width);
}

// One observation of the landmark: by one camera of one frame.
struct CameraView {
  const FrameGeometry::Pose& pose;
  const WindowObservation& observation;
  int camera;

  Vector3d PointInCamera(const HostedPoint& point) const {
    return pose.R_CW[camera] * point.SeenFrom(pose.p_WC[camera]);
  }
};

// With a calibration that is estimated the error is taken in pixels, and all derivatives where the
// point is predicted: taken where it was measured they would depend on the noise of the pixel, and
// the lenses would learn its variance.
std::optional<Vector2d> WhitenedPixelError(const Vector3d& h,
                                           const FrameGeometry& geometry,
                                           const CameraView& view) {
  const auto seen = geometry.NominalProjection(view.camera, h);
  if (!seen) return std::nullopt;
  const Vector2d px = seen->px + geometry.LensShift(view.camera, seen->J_px_k);
  return Vector2d((px - view.observation.px[view.camera]) / view.observation.sigma_px[view.camera]);
}

// Equation (3.3).
std::optional<Vector2d> WhitenedError(const HostedPoint& point,
                                      const FrameGeometry& geometry,
                                      const CameraView& view) {
  const Vector3d h = view.PointInCamera(point);
  if (h.z() < kMinUnitDepth) return std::nullopt;
  if (geometry.has_calibration()) return WhitenedPixelError(h, geometry, view);
  return Vector2d(view.observation.sqrt_info[view.camera] *
                  (h.head<2>() / h.z() - geometry.MeasuredXy(view.observation, view.camera)));
}

// d whitened error / d h, without the loss.
Matrix<2, 3> ByPoint(const WindowObservation& observation, int camera, const Vector3d& h) {
  const Matrix2d S = 1 / h.z() * observation.sqrt_info[camera];
  Matrix<2, 3> J;
  J << S, -S * (h.head<2>() / h.z());
  return J;
}

// One camera's two rows, whitened and weighted: equation (3.4). `by_h`: d error / d point in the
// camera.
void MakeRows(const LinearizedPoint& point,
              const CameraView& view,
              const Matrix<2, 3>& by_h,
              const Vector2d& error,
              VisionRow* rows) {
  const HostedPoint& frozen = point.frozen;
  const Vector3d l_W = frozen.SeenFrom(view.pose.p_WB);
  const Vector3d baseline_W = frozen.p_WH - view.pose.p_WC[view.camera];
  const Matrix3d& R_CW = view.pose.R_CW[view.camera];
  for (int k = 0; k < 2; ++k) {
    // a = row of (d error / d h) R_CW.
    const Vector3d a = R_CW.transpose() * by_h.row(k).transpose();
    VisionRow& row = rows[k];
    Eigen::Map<Vector3d>(row.pose) = view.pose.R_BW * a.cross(l_W);  // a^T Hat(l) = (a x l)^T
    Eigen::Map<Vector3d>(row.pose + 3) = -frozen.rho * a;
    row.landmark[0] = a.dot(point.B_W.col(0));
    row.landmark[1] = a.dot(point.B_W.col(1));
    row.landmark[2] = a.dot(baseline_W);
    row.residual = error(k);
  }
}

// Squares the rows of one observation; those of a camera that did not see the point are zero.
void AddView(const WindowObservation& obs, const VisionRow* rows, LandmarkBlock& block) {
  SquaredRows G;
  if (obs.has_right) {
    SquareRows<4>(rows, G);
  } else {
    SquareRows<2>(rows, G);
  }
  LandmarkBlock::View& view = block.views[block.num_views++];
  view.frame = obs.frame;
  view.H = Eigen::Map<const Matrix<6, 6>>(G.H);
  view.b = Eigen::Map<const Vector<6>>(G.b);
  view.W = Eigen::Map<const Matrix<6, 3>>(G.W);
  const Eigen::Map<const Matrix<4, 3>> V(G.V);
  block.V += V.topRows<3>();
  block.b += V.row(3).transpose();
}

// The columns of lenses and stereo pair of four rows, two of each camera.
using LensRows = Matrix<4, kNumRigParameters>;

// Equations (10.2) and (10.3): those of one camera. `by_h`, `by_lens`: the whitened and weighted
// error's.
void MakeLensRows(const LinearizedPoint& point,
                  const CameraView& view,
                  const Matrix<2, 3>& by_h,
                  const Matrix<2, kNumIntrinsics>& by_lens,
                  LensRows& K) {
  const int c = view.camera;
  K.block<2, kNumIntrinsics>(2 * c, c * kNumIntrinsics) = by_lens;
  if (c == 0) return;
  const Vector3d y_C0 = view.pose.R_CW[0] * point.frozen.SeenFrom(view.pose.p_WC[0]);
  const Matrix3d R_C0C1 = view.pose.R_CW[0] * view.pose.R_CW[1].transpose();
  for (int k = 0; k < 2; ++k) {
    const Vector3d s = by_h.row(k).transpose();
    K.block<1, 3>(2 + k, kStereoRotation) = y_C0.cross(R_C0C1 * s).transpose();
    K.block<1, 3>(2 + k, kStereoTranslation) = point.frozen.rho * s.transpose();
  }
}

// A left row has columns of the left lens only.
void AddLens(
    const VisionRow* rows, const LensRows& K, int frame, LandmarkBlock& block, LensSums& sums) {
  constexpr int kLeft = kNumIntrinsics;
  Matrix<4, 6> J_pose;
  Matrix<4, 3> J_landmark;
  Vector<4> r;
  for (int k = 0; k < 4; ++k) {
    J_pose.row(k) = Eigen::Map<const Eigen::RowVector<double, 6>>(rows[k].pose);
    J_landmark.row(k) = Eigen::Map<const Eigen::RowVector3d>(rows[k].landmark);
    r(k) = rows[k].residual;
  }
  const Matrix<2, kLeft> left = K.topLeftCorner<2, kLeft>();
  const Matrix<2, kNumRigParameters> right = K.bottomRows<2>();
  sums.H.topLeftCorner<kLeft, kLeft>().noalias() += left.transpose() * left;
  sums.H.noalias() += right.transpose() * right;
  sums.b.head<kLeft>().noalias() += left.transpose() * r.head<2>();
  sums.b.noalias() += right.transpose() * r.tail<2>();
  Matrix<6, kNumRigParameters>& pose = sums.poses[static_cast<std::size_t>(frame)];
  pose.leftCols<kLeft>().noalias() += J_pose.topRows<2>().transpose() * left;
  pose.noalias() += J_pose.bottomRows<2>().transpose() * right;
  Matrix<kNumRigParameters, 3>& W = block.lens.front().W;
  W.topRows<kLeft>().noalias() += left.transpose() * J_landmark.topRows<2>();
  W.noalias() += right.transpose() * J_landmark.bottomRows<2>();
}

using RowValues = Eigen::Map<Vector<10>>;

RowValues ValuesOf(VisionRow& row) {
  static_assert(sizeof(VisionRow) == 10 * sizeof(double));
  return RowValues(row.pose);
}

// From the rows of both pixels to those of the left pixel and of the match.
void SubtractLeft(const WindowObservation& o, VisionRow* rows, LensRows* K) {
  const double of_right = o.sigma_px[1] / o.sigma_match_px;
  const double of_left = o.sigma_px[0] / o.sigma_match_px;
  for (int k = 0; k < 2; ++k) {
    ValuesOf(rows[2 + k]) = of_right * ValuesOf(rows[2 + k]) - of_left * ValuesOf(rows[k]);
    if (K != nullptr) K->row(2 + k) = of_right * K->row(2 + k) - of_left * K->row(k);
  }
}

void Weigh(double root_weight, int camera, VisionRow* rows, LensRows* K) {
  for (int k = 2 * camera; k < 2 * camera + 2; ++k)
    ValuesOf(rows[k]) *= root_weight;
  if (K != nullptr) K->middleRows<2>(2 * camera) *= root_weight;
}

}  // namespace

std::optional<Vector2d> ReprojectionFactor::Error(const HostedPoint& point, int camera) const {
  const auto of_camera = [&](int c) {
    return WhitenedError(
        point, geometry_, {geometry_.current(observation_.frame), observation_, c});
  };
  const std::optional<Vector2d> error = of_camera(camera);
  if (camera == 0 || !error || !HasMatchNoise()) return error;
  const std::optional<Vector2d> left = of_camera(0);
  if (!left) return std::nullopt;
  return Vector2d((observation_.sigma_px[1] * *error - observation_.sigma_px[0] * *left) /
                  observation_.sigma_match_px);
}

double ReprojectionFactor::NoiseScale(int camera) const {
  return landmark_.is_projection ? observation_.sigma_px[camera] / noise_.projection.sigma_px : 1.0;
}

RobustLoss ReprojectionFactor::Loss(const std::optional<Vector2d>& error, int camera) const {
  return ReprojectionLoss(
      landmark_, error ? NoiseScale(camera) * error->norm() : BehindSigma(noise_), noise_);
}

double ReprojectionFactor::Cost(const HostedPoint& point, int camera) const {
  return Loss(Error(point, camera), camera).cost;
}

// With a noise of the match the rows of both pixels are made first, without the weights that belong
// to what they become.
void ReprojectionFactor::AddTo(const LinearizedPoint& point,
                               LandmarkBlock& block,
                               LensSums* lens) const {
  VisionRow rows[4] = {};  // two of each camera
  LensRows all_lens_rows;
  LensRows* const K = lens != nullptr ? &all_lens_rows : nullptr;
  if (K != nullptr) K->setZero();
  const bool has_match_noise = HasMatchNoise();
  double root_weights[2] = {1, 1};
  bool is_complete = true;
  for (int c = 0; c < (observation_.has_right ? 2 : 1); ++c) {
    const std::optional<Vector2d> error = Error(point.current, c);
    const RobustLoss loss = Loss(error, c);
    block.cost += loss.cost;
    root_weights[c] = loss.root_weight;
    const CameraView view{geometry_.frozen(observation_.frame), observation_, c};
    const Vector3d h = view.PointInCamera(point.frozen);
    if (!error || h.z() < kMinUnitDepth) {
      is_complete = false;
      continue;
    }
    const double weight = has_match_noise ? 1.0 : NoiseScale(c) * loss.root_weight;
    const Vector2d& r =
        has_match_noise && c == 1
            ? *WhitenedError(point.current,
                             geometry_,
                             {geometry_.current(observation_.frame), observation_, 1})
            : *error;
    if (K == nullptr) {
      MakeRows(point, view, weight * ByPoint(observation_, c, h), weight * r, rows + 2 * c);
      continue;
    }
    const auto seen = geometry_.NominalProjection(c, h);
    if (!seen) {
      is_complete = false;
      continue;
    }
    const double scale = weight / observation_.sigma_px[c];
    const Matrix<2, 3> by_h = scale * seen->J_px_p;
    MakeRows(point, view, by_h, weight * r, rows + 2 * c);
    MakeLensRows(point, view, by_h, scale * seen->J_px_k, *K);
  }
  if (has_match_noise) {
    if (!is_complete) return;
    SubtractLeft(observation_, rows, K);
    for (int c = 0; c < 2; ++c)
      Weigh(root_weights[c], c, rows, K);
  }
  AddView(observation_, rows, block);
  if (K != nullptr) AddLens(rows, *K, observation_.frame, block, *lens);
}

std::optional<Vector2d> ReprojectionError(const FrameGeometry& geometry,
                                          const WindowLandmark& landmark,
                                          const WindowObservation& observation,
                                          int camera) {
  return WhitenedError(HostedPoint(landmark, geometry.current(landmark.host)),
                       geometry,
                       {geometry.current(observation.frame), observation, camera});
}

}  // namespace facet
