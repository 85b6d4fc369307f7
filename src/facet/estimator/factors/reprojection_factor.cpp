// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/reprojection_factor.h"

#include <algorithm>
#include <cmath>

#include "facet/estimator/factors/robust_loss.h"
#include "facet/estimator/factors/vision_kernels.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// A point that is not near the measured ray counts as this far off, in sigmas and widths of the
// loss: as bad as any, but finite.
constexpr double kBehindSigma = 30.0;
constexpr double kBehindWidths = 10.0;
// Translations between two frames that are shorter than this share of the stereo baseline count as
// noise, those of twice the length do not.
constexpr double kNoiseShare = 0.02;

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
  const std::optional<Vector2d> px = geometry.present_lens(view.camera).Project(h);
  if (!px) return std::nullopt;
  return Vector2d((*px - view.observation.px[view.camera]) /
                  view.observation.sigma_px[view.camera]);
}

// Equation (3.3).
std::optional<Vector2d> WhitenedError(const HostedPoint& point,
                                      const FrameGeometry& geometry,
                                      const CameraView& view) {
  const Vector3d h = view.PointInCamera(point);
  const MeasuredRay& ray = view.observation.rays[view.camera];
  if (!ray.IsNear(h)) return std::nullopt;
  if (geometry.has_calibration()) return WhitenedPixelError(h, geometry, view);
  return ray.Error(h);
}

// The share of the translation from the view to the host that counts in the derivative by the
// inverse distance, where the calibration is a variable (docs/math.md, section 10.3). A camera at
// rest has a translation only because it fits the noise of the pixels; with it, distances and what
// the calibration says of them would learn that noise's variance. Next to the stereo baseline such
// a translation says nothing of a distance.
double KnownShare(const Vector3d& translation_W, const FrameGeometry::Pose& pose) {
  const double ratio_square =
      translation_W.squaredNorm() / (pose.p_WC[1] - pose.p_WC[0]).squaredNorm();
  if (ratio_square >= 4 * kNoiseShare * kNoiseShare) return 1;
  return std::max(std::sqrt(ratio_square) / kNoiseShare - 1, 0.0);
}

// One camera's two rows, whitened and weighted: equation (3.4). `by_h`: d error / d point in the
// camera.
void MakeRows(const LinearizedPoint& point,
              const FrameGeometry& geometry,
              const CameraView& view,
              const Matrix<2, 3>& by_h,
              const Vector2d& error,
              VisionRow* rows) {
  const HostedPoint& frozen = point.frozen;
  const Vector3d l_W = frozen.SeenFrom(view.pose.p_WB);
  Vector3d baseline_W = frozen.p_WH - view.pose.p_WC[view.camera];
  if (geometry.has_calibration()) {
    const Vector3d between_frames_W = frozen.p_WH - view.pose.p_WC[0];
    baseline_W -= (1 - KnownShare(between_frames_W, view.pose)) * between_frames_W;
  }
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
    BestKernels().square_four_rows(rows, G);
  } else {
    BestKernels().square_two_rows(rows, G);
  }
  LandmarkBlock::PoseSquare& square = block.pose_squares[block.num_views];
  square.H = Eigen::Map<const Matrix<6, 6>>(G.H);
  square.b = Eigen::Map<const Vector<6>>(G.b);
  LandmarkBlock::View& view = block.views[block.num_views++];
  view.frame = obs.frame;
  view.W = Eigen::Map<const Matrix<6, 3>>(G.W);
  const Eigen::Map<const Matrix<4, 3>> V(G.V);
  block.V += V.topRows<3>();
  block.b += V.row(3).transpose();
}

using LensValues = Eigen::Map<Vector<kNumIntrinsics>>;
using ModeValues = Eigen::Map<LensModeVector>;
using AllLensValues = Eigen::Map<Vector<kNumLensColumns>>;

LensValues LensOf(LensRow& row, int camera) {
  return LensValues(row.k + camera * kNumIntrinsics);
}

ModeValues ModesOf(LensRow& row, int camera) {
  return ModeValues(row.k + kLensModes + camera * kNumLensModes);
}

// Equations (10.2) and (10.3): the columns of lenses and stereo pair of one camera's two rows.
// `by_h`, `by_lens`, `by_modes`: the whitened and weighted error's. A left row has those of the
// left lens only.
void MakeLensRows(const LinearizedPoint& point,
                  const CameraView& view,
                  const Matrix<2, 3>& by_h,
                  const Matrix<2, kNumIntrinsics>& by_lens,
                  const Matrix<2, kNumLensModes>& by_modes,
                  LensRow* rows) {
  for (int k = 0; k < 2; ++k) {
    LensOf(rows[k], view.camera) = by_lens.row(k);
    ModesOf(rows[k], view.camera) = by_modes.row(k);
  }
  if (view.camera == 0) return;
  const Vector3d y_C0 = view.pose.R_CW[0] * point.frozen.SeenFrom(view.pose.p_WC[0]);
  const Matrix3d R_C0C1 = view.pose.R_CW[0] * view.pose.R_CW[1].transpose();
  for (int k = 0; k < 2; ++k) {
    const Vector3d s = by_h.row(k).transpose();
    Eigen::Map<Vector3d>(rows[k].k + kStereoRotation) = y_C0.cross(R_C0C1 * s);
    Eigen::Map<Vector3d>(rows[k].k + kStereoTranslation) = point.frozen.rho * s;
    LensOf(rows[k], 0).setZero();
    ModesOf(rows[k], 0).setZero();
  }
}

// The left rows come first.
void AddLens(const VisionRow* rows,
             const LensRow* lens,
             const WindowObservation& obs,
             LandmarkBlock& block,
             LensSums& sums) {
  const LensProducts to{sums.H.data(),
                        sums.poses[static_cast<std::size_t>(obs.frame)].data(),
                        block.lens.front().W.data(),
                        sums.b.data()};
  const LensKernels& kernels = BestKernels().lens(block.lens.front().has_modes);
  kernels.add_left(lens, rows, to);
  if (obs.has_right) kernels.add_right(lens + 2, rows + 2, to);
}

using RowValues = Eigen::Map<Vector<10>>;

RowValues ValuesOf(VisionRow& row) {
  static_assert(sizeof(VisionRow) == 10 * sizeof(double));
  return RowValues(row.pose);
}

// From the rows of both pixels to those of the left pixel and of the match.
void SubtractLeft(const WindowObservation& o, VisionRow* rows, LensRow* lens) {
  const double of_right = o.sigma_px[1] / o.sigma_match_px;
  const double of_left = o.sigma_px[0] / o.sigma_match_px;
  for (int k = 0; k < 2; ++k) {
    ValuesOf(rows[2 + k]) = of_right * ValuesOf(rows[2 + k]) - of_left * ValuesOf(rows[k]);
    if (lens == nullptr) continue;
    AllLensValues(lens[2 + k].k) *= of_right;
    LensOf(lens[2 + k], 0) = -of_left * LensOf(lens[k], 0);
    ModesOf(lens[2 + k], 0) = -of_left * ModesOf(lens[k], 0);
  }
}

void Weigh(double root_weight, int camera, VisionRow* rows, LensRow* lens) {
  for (int k = 2 * camera; k < 2 * camera + 2; ++k) {
    ValuesOf(rows[k]) *= root_weight;
    if (lens == nullptr) continue;
    if (camera == 0) {
      LensOf(lens[k], 0) *= root_weight;
      ModesOf(lens[k], 0) *= root_weight;
    } else {
      AllLensValues(lens[k].k) *= root_weight;
    }
  }
}

}  // namespace

ReprojectionFactor::Errors ReprojectionFactor::PixelErrors(const HostedPoint& point) const {
  Errors errors;
  for (int c = 0; c < num_cameras(); ++c) {
    errors[static_cast<std::size_t>(c)] =
        WhitenedError(point, geometry_, {geometry_.current(observation_.frame), observation_, c});
  }
  return errors;
}

ReprojectionFactor::Errors ReprojectionFactor::FromPixelErrors(const Errors& pixels) const {
  if (!HasMatchNoise() || !pixels[1]) return pixels;
  if (!pixels[0]) return {};
  return {pixels[0],
          Vector2d((observation_.sigma_px[1] * *pixels[1] - observation_.sigma_px[0] * *pixels[0]) /
                   observation_.sigma_match_px)};
}

double ReprojectionFactor::NoiseScale(int camera) const {
  return landmark_.is_projection ? observation_.sigma_px[camera] / noise_.projection.sigma_px : 1.0;
}

RobustLoss ReprojectionFactor::Loss(const std::optional<Vector2d>& error, int camera) const {
  return ReprojectionLoss(
      landmark_, error ? NoiseScale(camera) * error->norm() : BehindSigma(noise_), noise_);
}

double ReprojectionFactor::Cost(const HostedPoint& point) const {
  const Errors errors = ErrorsOf(point);
  double cost = 0;
  for (int c = 0; c < num_cameras(); ++c)
    cost += Loss(errors[static_cast<std::size_t>(c)], c).cost;
  return cost;
}

// One camera's rows, with all of its columns; false where it does not see the point: then they stay
// zero. With a calibration that is estimated derivatives are those of the image, also where it is
// held.
bool ReprojectionFactor::MakeCameraRows(const LinearizedPoint& point,
                                        int camera,
                                        double weight,
                                        const std::optional<Vector2d>& error,
                                        VisionRow* rows,
                                        LensRow* lens) const {
  const CameraView view{geometry_.frozen(observation_.frame), observation_, camera};
  const Vector3d h = view.PointInCamera(point.frozen);
  const MeasuredRay& ray = observation_.rays[camera];
  const bool is_near = error && ray.IsNear(h);
  if (is_near && !geometry_.has_calibration()) {
    MakeRows(point, geometry_, view, weight * ray.ErrorByDirection(h), weight * *error, rows);
    return true;
  }
  const CameraModel& nominal = geometry_.nominal_camera(camera);
  Matrix<2, 3> J_px_h;
  const auto px = is_near ? nominal.Project(h, &J_px_h) : std::nullopt;
  if (!px) {
    if (lens != nullptr) std::fill_n(lens, 2, LensRow{});
    return false;
  }
  const double scale = weight / observation_.sigma_px[camera];
  const Matrix<2, 3> by_h = scale * J_px_h;
  MakeRows(point, geometry_, view, by_h, weight * *error, rows);
  if (lens != nullptr) {
    const Matrix<2, kNumIntrinsics> by_lens =
        scale * IntrinsicsJacobian(nominal.intrinsics(), h, *px);
    Matrix<2, kNumLensModes> by_modes = Matrix<2, kNumLensModes>::Zero();
    if (geometry_.estimates_modes()) by_modes = scale * geometry_.ModesAt(camera, *px);
    MakeLensRows(point, view, by_h, by_lens, by_modes, lens);
  }
  return true;
}

// With a noise of the match the rows of both pixels are made first, without the weights that belong
// to what they become.
void ReprojectionFactor::AddTo(const LinearizedPoint& point,
                               LandmarkBlock& block,
                               LensSums* lens) const {
  VisionRow rows[4] = {};  // two of each camera
  LensRow all_lens_rows[4];
  LensRow* const lens_rows = lens != nullptr ? all_lens_rows : nullptr;
  const bool has_match_noise = HasMatchNoise();
  const Errors pixels = PixelErrors(point.current);
  const Errors errors = FromPixelErrors(pixels);
  double root_weights[2] = {1, 1};
  bool is_complete = true;
  for (int c = 0; c < num_cameras(); ++c) {
    const std::size_t i = static_cast<std::size_t>(c);
    const RobustLoss loss = Loss(errors[i], c);
    block.cost += loss.cost;
    root_weights[c] = loss.root_weight;
    const double weight = has_match_noise ? 1.0 : NoiseScale(c) * loss.root_weight;
    is_complete &= MakeCameraRows(point,
                                  c,
                                  weight,
                                  errors[i] ? pixels[i] : std::nullopt,
                                  rows + 2 * c,
                                  lens_rows == nullptr ? nullptr : lens_rows + 2 * c);
  }
  if (has_match_noise) {
    if (!is_complete) return;
    SubtractLeft(observation_, rows, lens_rows);
    for (int c = 0; c < 2; ++c)
      Weigh(root_weights[c], c, rows, lens_rows);
  }
  AddView(observation_, rows, block);
  if (lens != nullptr) AddLens(rows, lens_rows, observation_, block, *lens);
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
