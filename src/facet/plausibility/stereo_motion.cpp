// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/stereo_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/camera/stereo_triangulation.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr std::size_t kLeastPairs = 15;
// Of less distances are hardly known, which makes motions too short, and those that look nearer
// than they are would be chosen.
constexpr double kLeastDisparity_px = 5;
// Of a place in the later image as the earlier pair predicts it; distances are a part of it.
constexpr double kSigma_px = 0.5;
// In sigmas: the loss begins wide, so that the beginning need not be near.
constexpr std::array<double, 6> kLossWidths = {60, 20, 8, 4, 3, 3};
// Less is no single motion.
constexpr double kLeastAgreement = 0.5, kAgreementSigmas = 4;

}  // namespace

void StereoMotion::SetRig(const StereoRig& rig) {
  if (rig.lens_modes != rig_.lens_modes) beside_model_ = FieldsOf(rig);
  rig_ = rig;
  T_C1C0_ = rig.T_C1C0();
  T_CB_ = rig.T_BC[0].Inverse();
  bearing_sigma_ = kSigma_px / rig.cameras[0].mean_focal_px();
}

void StereoMotion::AddImu(const ImuInterval& imu, const Vector3d& gyro_bias) {
  is_turn_known_ = is_turn_known_ && !imu.samples.empty() && !imu.has_hole;
  for (std::size_t i = 1; i < imu.samples.size(); ++i) {
    const double dt_s = ToSeconds(imu.samples[i].t - imu.samples[i - 1].t);
    const Vector3d reading = 0.5 * (imu.samples[i - 1].gyro + imu.samples[i].gyro);
    const Vector3d w_B = reading - rig_.gyro_scale.cwiseProduct(reading) - gyro_bias;
    turned_ = turned_ * ExpSO3(dt_s * w_B);
    dt_s_ += dt_s;
  }
}

SE3 StereoMotion::AddKeyframe(const FrameObservations& keyframe) {
  const Motion by_gyro{T_CB_.q * turned_.conjugate() * T_CB_.q.conjugate(), Vector3d::Zero()};
  const std::optional<Motion> motion = Fit(PairsWith(keyframe), by_gyro);
  turn_.reset();
  if (motion && is_turn_known_) {
    const Quaterniond by_images = T_CB_.q.conjugate() * motion->R.conjugate() * T_CB_.q;
    turn_ = DoubleTurn{LogSO3(by_images), LogSO3(turned_.normalized()), dt_s_};
  }
  has_lost_orientation_ = !motion && !is_turn_known_;
  const Motion moved = motion.value_or(by_gyro);
  T_WC_ = T_WC_ * SE3(moved.R.normalized(), moved.t).Inverse();
  before_ = PointsOf(keyframe);
  turned_ = Quaterniond::Identity();
  dt_s_ = 0;
  is_turn_known_ = true;
  return T_WC_ * T_CB_;
}

std::vector<StereoMotion::SeenPoint> StereoMotion::PointsOf(
    const FrameObservations& keyframe) const {
  std::vector<SeenPoint> points;
  for (const FeatureObservation& feature : keyframe.features) {
    if (!feature.px_right) continue;
    const auto left = rig_.cameras[0].Unproject(ByModel(beside_model_, 0, feature.px_left));
    const auto right = rig_.cameras[1].BearingOf(ByModel(beside_model_, 1, *feature.px_right));
    const auto stereo = left && right ? TriangulateOnRay(*left, *right, T_C1C0_) : std::nullopt;
    if (!stereo) continue;
    const double disparity_px = stereo->inverse_distance * stereo->px_per_inverse_distance;
    if (disparity_px >= kLeastDisparity_px)
      points.push_back({feature.landmark, *left / stereo->inverse_distance});
  }
  std::sort(points.begin(), points.end(), [](const SeenPoint& a, const SeenPoint& b) {
    return a.landmark < b.landmark;
  });
  return points;
}

std::vector<StereoMotion::Pair> StereoMotion::PairsWith(const FrameObservations& keyframe) const {
  std::vector<Pair> pairs;
  for (const FeatureObservation& feature : keyframe.features) {
    const auto point = std::lower_bound(
        before_.begin(), before_.end(), feature.landmark, [](const SeenPoint& p, LandmarkId id) {
          return p.landmark < id;
        });
    if (point == before_.end() || point->landmark != feature.landmark) continue;
    if (const auto bearing = rig_.cameras[0].Unproject(ByModel(beside_model_, 0, feature.px_left)))
      pairs.push_back({point->p_C, *bearing, TangentBasis(*bearing).transpose()});
  }
  return pairs;
}

// Gauss-Newton steps on the distances between bearings and the directions of the points, with
// Cauchy's loss.
std::optional<StereoMotion::Motion> StereoMotion::Fit(const std::vector<Pair>& pairs,
                                                      Motion motion) const {
  if (pairs.size() < kLeastPairs) return std::nullopt;
  std::size_t num_agreeing = 0;
  for (const double width : kLossWidths) {
    Matrix<6, 6> H = 1e-9 * Matrix<6, 6>::Identity();
    Vector<6> b = Vector<6>::Zero();
    num_agreeing = 0;
    for (const Pair& pair : pairs) {
      const Vector3d turned = motion.R * pair.p_C;
      const Vector3d p = turned + motion.t;
      if (pair.bearing.dot(p) < kMinDistance_m) continue;
      const double inverse_distance = 1 / p.norm();
      const Vector2d e = pair.across_bearing * p * inverse_distance / bearing_sigma_;
      const double squared = e.squaredNorm(), weight = 1 / (1 + squared / (width * width));
      if (squared < kAgreementSigmas * kAgreementSigmas) ++num_agreeing;
      Matrix<2, 6> J;  // by a turn on the left and t
      J.rightCols<3>() = inverse_distance / bearing_sigma_ * pair.across_bearing -
                         inverse_distance * inverse_distance * e * p.transpose();
      J.leftCols<3>() = -J.rightCols<3>() * Hat(turned);
      H += weight * J.transpose() * J;
      b -= weight * J.transpose() * e;
    }
    const Vector<6> step = H.ldlt().solve(b);
    motion.R = (ExpSO3(step.head<3>()) * motion.R).normalized();
    motion.t += step.tail<3>();
  }
  const double agreement = static_cast<double>(num_agreeing) / static_cast<double>(pairs.size());
  if (!motion.t.allFinite() || agreement < kLeastAgreement) return std::nullopt;
  return motion;
}

}  // namespace facet
