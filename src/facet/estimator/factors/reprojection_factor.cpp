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

// Equation (3.3).
std::optional<Vector2d> WhitenedError(const HostedPoint& point,
                                      const FrameGeometry& geometry,
                                      const CameraView& view) {
  const Vector3d h = view.PointInCamera(point);
  if (h.z() < kMinUnitDepth) return std::nullopt;
  return Vector2d(view.observation.sqrt_info[view.camera] *
                  (h.head<2>() / h.z() - geometry.MeasuredXy(view.observation, view.camera)));
}

// One camera's two rows, whitened and weighted: equation (3.4). `h`: the point in the camera.
void MakeRows(const LinearizedPoint& point,
              const CameraView& view,
              const Vector3d& h,
              double root_weight,
              const Vector2d& error,
              VisionRow* rows) {
  const HostedPoint& frozen = point.frozen;
  const double scale = root_weight / h.z();
  const Matrix2d S = scale * view.observation.sqrt_info[view.camera];
  const Vector2d S_xy = S * (h.head<2>() / h.z());
  const Vector3d l_W = frozen.SeenFrom(view.pose.p_WB);
  const Vector3d baseline_W = frozen.p_WH - view.pose.p_WC[view.camera];
  const Matrix3d& R_CW = view.pose.R_CW[view.camera];
  for (int k = 0; k < 2; ++k) {
    // a = row of (d error / d h) R_CW.
    const Vector3d a = R_CW.transpose() * Vector3d(S(k, 0), S(k, 1), -S_xy(k));
    VisionRow& row = rows[k];
    Eigen::Map<Vector3d>(row.pose) = view.pose.R_BW * a.cross(l_W);  // a^T Hat(l) = (a x l)^T
    Eigen::Map<Vector3d>(row.pose + 3) = -frozen.rho * a;
    row.landmark[0] = a.dot(point.B_W.col(0));
    row.landmark[1] = a.dot(point.B_W.col(1));
    row.landmark[2] = a.dot(baseline_W);
    row.residual = root_weight * error(k);
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

// Equations (10.2) and (10.3): those of one camera. `weight`: what its rows were multiplied with
// besides 1 / sigma.
void MakeLensRows(const LinearizedPoint& point,
                  const FrameGeometry& geometry,
                  const CameraView& view,
                  const Vector3d& h,
                  double weight,
                  LensRows& K) {
  const int c = view.camera;
  K.block<2, kNumIntrinsics>(2 * c, c * kNumIntrinsics) =
      weight / view.observation.sigma_px[c] * geometry.IntrinsicsJacobianAt(view.observation, c);
  if (c == 0) return;
  const Matrix2d S = weight / h.z() * view.observation.sqrt_info[c];
  const Vector2d S_xy = S * (h.head<2>() / h.z());
  const Vector3d y_C0 = view.pose.R_CW[0] * point.frozen.SeenFrom(view.pose.p_WC[0]);
  const Matrix3d R_C0C1 = view.pose.R_CW[0] * view.pose.R_CW[1].transpose();
  for (int k = 0; k < 2; ++k) {
    const Vector3d s(S(k, 0), S(k, 1), -S_xy(k));  // d error / d h
    K.block<1, 3>(2 + k, kStereoRotation) = y_C0.cross(R_C0C1 * s).transpose();
    K.block<1, 3>(2 + k, kStereoTranslation) = point.frozen.rho * s.transpose();
  }
}

// A left row has columns of the left lens, a right row those of the right lens and the stereo pair.
void AddLens(
    const VisionRow* rows, const LensRows& K, int frame, LandmarkBlock& block, LensSums& sums) {
  constexpr int kLeft = kNumIntrinsics, kRight = kNumRigParameters - kLeft;
  Matrix<4, 6> J_pose;
  Matrix<4, 3> J_landmark;
  Vector<4> r;
  for (int k = 0; k < 4; ++k) {
    J_pose.row(k) = Eigen::Map<const Eigen::RowVector<double, 6>>(rows[k].pose);
    J_landmark.row(k) = Eigen::Map<const Eigen::RowVector3d>(rows[k].landmark);
    r(k) = rows[k].residual;
  }
  const Matrix<2, kLeft> left = K.topLeftCorner<2, kLeft>();
  const Matrix<2, kRight> right = K.bottomRightCorner<2, kRight>();
  sums.H.topLeftCorner<kLeft, kLeft>().noalias() += left.transpose() * left;
  sums.H.bottomRightCorner<kRight, kRight>().noalias() += right.transpose() * right;
  sums.b.head<kLeft>().noalias() += left.transpose() * r.head<2>();
  sums.b.tail<kRight>().noalias() += right.transpose() * r.tail<2>();
  Matrix<6, kNumRigParameters>& pose = sums.poses[static_cast<std::size_t>(frame)];
  pose.leftCols<kLeft>().noalias() += J_pose.topRows<2>().transpose() * left;
  pose.rightCols<kRight>().noalias() += J_pose.bottomRows<2>().transpose() * right;
  Matrix<kNumRigParameters, 3>& W = block.lens.front().W;
  W.topRows<kLeft>().noalias() += left.transpose() * J_landmark.topRows<2>();
  W.bottomRows<kRight>().noalias() += right.transpose() * J_landmark.bottomRows<2>();
}

}  // namespace

std::optional<Vector2d> ReprojectionFactor::Error(const HostedPoint& point, int camera) const {
  return WhitenedError(
      point, geometry_, {geometry_.current(observation_.frame), observation_, camera});
}

double ReprojectionFactor::NoiseScale(int camera) const {
  return landmark_.is_projection ? observation_.sigma_px[camera] / noise_.projection.sigma_px : 1.0;
}

double ReprojectionFactor::Cost(const HostedPoint& point, int camera) const {
  const auto error = Error(point, camera);
  const double s = error ? NoiseScale(camera) * error->norm() : BehindSigma(noise_);
  return ReprojectionLoss(landmark_, s, noise_).cost;
}

void ReprojectionFactor::AddTo(const LinearizedPoint& point,
                               LandmarkBlock& block,
                               LensSums* lens) const {
  VisionRow rows[4] = {};  // two of each camera
  LensRows K = LensRows::Zero();
  for (int c = 0; c < (observation_.has_right ? 2 : 1); ++c) {
    const std::optional<Vector2d> error = Error(point.current, c);
    const double scale = NoiseScale(c);
    const RobustLoss loss =
        ReprojectionLoss(landmark_, error ? scale * error->norm() : BehindSigma(noise_), noise_);
    block.cost += loss.cost;
    const CameraView view{geometry_.frozen(observation_.frame), observation_, c};
    const Vector3d h = view.PointInCamera(point.frozen);
    if (!error || h.z() < kMinUnitDepth) continue;
    MakeRows(point, view, h, scale * loss.root_weight, *error, rows + 2 * c);
    if (lens != nullptr) MakeLensRows(point, geometry_, view, h, scale * loss.root_weight, K);
  }
  AddView(observation_, rows, block);
  if (lens != nullptr) AddLens(rows, K, observation_.frame, block, *lens);
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
