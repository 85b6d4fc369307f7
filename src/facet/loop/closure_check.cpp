// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/closure_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <Eigen/Cholesky>

#include "facet/frontend/warp_prediction.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr int kMostBits = 64;           // of 256; unrelated descriptors differ in about half
constexpr double kMaxBitsRatio = 0.85;  // best over second best, elsewhere in the image
constexpr double kElsewhere_px = 12;
constexpr double kConsensus_px = 6;
constexpr int kConsensusTrials = 300;
constexpr int kMinConsensus = 10;
constexpr double kLeastSimilarity = 0.8;
constexpr double kPatchSigma_px = 0.25;  // besides what the residuals say: views from elsewhere
constexpr double kMaxPatchScale = 1.7;   // between the views
constexpr int kBorder_px = 16;

constexpr double kCornerSigma_px = 0.7;  // on its level: FAST finds whole pixels
constexpr double kMinSeenShare = 0.25;   // of the place's points that should be seen
constexpr double kMaxSigma_m = 0.05, kMaxSigmaYaw_rad = 0.01;

double LevelSigma_px(int level) {
  return kCornerSigma_px * std::pow(kCornerLevelScale, level);
}

int BestBits(const RecordPoint& point, const BinaryDescriptor& descriptor) {
  int best = 256;
  for (const BinaryDescriptor& own : point.descriptors)
    best = std::min(best, HammingDistance(own, descriptor));
  return best;
}

/// From the query's world to the place's, given where the fit has the body in the place's world.
/// That world leans where the odometry's tilt was wrong, and what lies between the two bodies leans
/// along; it is set upright by its share of the difference.
UprightPose UprightDrift(const PlaceRecord& place, const PlaceQuery& query, const SE3& T_WB) {
  const Quaterniond turn = T_WB.q * query.T_WB.q.conjugate();
  UprightPose drift;
  drift.yaw_rad = std::remainder(2 * std::atan2(turn.z(), turn.w()), 2 * std::numbers::pi);
  const Vector3d lean = LogSO3(turn * ExpSO3(Vector3d(0, 0, -drift.yaw_rad)));
  const double variance = std::pow(place.sigma_tilt_rad, 2);
  const double share = variance / (variance + std::pow(query.sigma_tilt_rad, 2));
  const Vector3d between = ExpSO3(-share * lean) * (T_WB.p - place.T_WB.p);
  drift.p = place.T_WB.p + between - drift * query.T_WB.p;
  return drift;
}

}  // namespace

ClosureCheck ClosureChecker::Check(const PlaceQuery& query,
                                   std::span<const PlaceRecord* const> places,
                                   const ClosurePrediction& prediction) {
  ClosureCheck check;
  ListPoints(places);
  bearings_.clear();
  for (const UprightCorner& corner : query.corners)
    bearings_.push_back(query.camera.Unproject(corner.px).value_or(Vector3d::UnitZ()));
  MatchDescriptors(query, prediction);
  check.num_matches = static_cast<int>(matches_.size());

  // Heading and position by consensus, in the place's world; the tilt is that of the odometry.
  const SE3 T_WC = query.T_WC();
  std::vector<SeenPoint> seen;
  for (const Match& match : matches_)
    seen.push_back({points_[match.point].p_W,
                    T_WC.q * query.camera.Unproject(match.px).value_or(Vector3d::UnitZ())});
  const double angle_rad = kConsensus_px / query.camera.mean_focal_px();
  const auto consensus = FindUprightPose(seen, angle_rad, kConsensusTrials);
  if (!consensus || static_cast<int>(consensus->inliers.size()) < kMinConsensus) {
    check.refusal = "no consensus";
    return check;
  }
  const UprightPose T_placeUpright = consensus->T_BA.Inverse();
  SE3 T_WB = T_placeUpright.ToSE3() * SE3(query.T_WB.q, -(query.T_WB.q * query.T_BC.p));
  std::vector<Match> agreeing;
  for (const int i : consensus->inliers)
    agreeing.push_back(matches_[i]);
  matches_ = std::move(agreeing);

  const double sigma_tilt = std::hypot(query.sigma_tilt_rad, places[0]->sigma_tilt_rad);
  Matrix<6, 6> covariance;
  bool is_determined = Fit(query, sigma_tilt, T_WB, covariance);
  for (int round = 0; round < 2 && is_determined; ++round) {
    const SE3 T_WC_fit = T_WB * query.T_BC;
    check.num_visible =
        query.image != nullptr ? AlignPatches(query, T_WC_fit) : MatchNear(query, T_WC_fit);
    is_determined = Fit(query, sigma_tilt, T_WB, covariance);
  }
  check.num_inliers = static_cast<int>(matches_.size());
  if (!is_determined) {
    check.refusal = "pose not determined";
    return check;
  }
  const auto num_own = std::count_if(matches_.begin(), matches_.end(), [&](const Match& m) {
    return static_cast<std::size_t>(m.point) < num_own_;
  });
  check.T_WplaceWquery = UprightDrift(*places[0], query, T_WB);
  check.covariance = covariance.bottomRightCorner<4, 4>();
  const double sigma_m = std::sqrt(check.covariance.diagonal().tail<3>().maxCoeff());
  if (check.num_inliers < min_inliers_) {
    check.refusal = "too few corners";
  } else if (query.image != nullptr &&  // otherwise it is what both flights chose to look at
             static_cast<double>(num_own) < kMinSeenShare * check.num_visible) {
    check.refusal = "most of the place is not seen";
  } else if (!IsSpread(query)) {
    check.refusal = "corners in one spot";
  } else if (sigma_m > kMaxSigma_m || std::sqrt(check.covariance(0, 0)) > kMaxSigmaYaw_rad) {
    check.refusal = "pose too uncertain";
  }
  return check;
}

void ClosureChecker::ListPoints(std::span<const PlaceRecord* const> places) {
  points_.clear();
  for (const PlaceRecord* place : places) {
    const SE3 T_WC = place->T_WC();
    for (const RecordPoint& point : place->points) {
      const Vector3d p_C = point.p_C.cast<double>();
      points_.push_back({T_WC * p_C, T_WC.q * p_C.normalized(), &point, place});
    }
    if (place == places[0]) num_own_ = points_.size();
  }
}

void ClosureChecker::MatchDescriptors(const PlaceQuery& query,
                                      const ClosurePrediction& prediction) {
  matches_.clear();
  const SE3 T_CW = query.T_WC().Inverse() * prediction.T_WplaceWquery.Inverse().ToSE3();
  const double min_cosine = std::cos(std::min(prediction.max_angle_rad, std::numbers::pi));
  for (std::size_t i = 0; i < num_own_; ++i) {
    const Vector3d expected = (T_CW * points_[i].p_W).normalized();
    int best = -1, best_bits = kMostBits + 1, second_bits = 256;
    for (std::size_t c = 0; c < query.corners.size(); ++c) {
      if (bearings_[c].dot(expected) < min_cosine) continue;
      const int bits = BestBits(*points_[i].record, query.corners[c].descriptor);
      if (bits >= second_bits) continue;
      const bool is_same_place =
          best >= 0 && (query.corners[c].px - query.corners[best].px).norm() < kElsewhere_px;
      if (bits < best_bits) {
        if (best >= 0 && !is_same_place) second_bits = best_bits;
        best_bits = bits;
        best = static_cast<int>(c);
      } else if (!is_same_place) {
        second_bits = bits;
      }
    }
    if (best >= 0 && best_bits <= kMaxBitsRatio * second_bits)
      matches_.push_back(
          {static_cast<int>(i), query.corners[best].px, LevelSigma_px(query.corners[best].level)});
  }
}

int ClosureChecker::AlignPatches(const PlaceQuery& query, const SE3& T_WC) {
  matches_.clear();
  const SE3 T_CW = T_WC.Inverse();
  int num_visible = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    const Vector3d p_C = T_CW * point.p_W;
    if (p_C.norm() < kMinDistance_m) continue;
    const auto px = query.camera.Project(p_C);
    if (!px || !query.camera.IsInside(*px, kBorder_px)) continue;
    if (i < num_own_) ++num_visible;
    const CameraModel& lens = point.place->lens ? *point.place->lens : query.camera;
    const auto ray = lens.BearingOf(point.record->px.cast<double>());
    if (!ray) continue;
    const auto predicted = PredictWarp(*ray,
                                       1 / static_cast<double>(point.record->p_C.norm()),
                                       T_CW * point.place->T_WC(),
                                       query.camera);
    if (!predicted) continue;
    PatchWarp warp = *predicted;
    warp.x = static_cast<float>(px->x());
    warp.y = static_cast<float>(px->y());
    const double scale = Scale(warp);
    if (scale > kMaxPatchScale || scale < 1 / kMaxPatchScale) continue;
    for (std::size_t level = 0; level < 2; ++level) {
      const RecordPatch& kept = point.record->patches[level];
      const ImageLevel image{
          kept.grey.data(), RecordPatch::kSide, RecordPatch::kSide, RecordPatch::kSide};
      tracker_.ExtractLevel(image, kept.x, kept.y, patch_.levels[level]);
    }
    const Alignment alignment = tracker_.Align(patch_, *query.image, {1, 0}, warp);
    if (!alignment.ok || alignment.level != 0 || alignment.zncc < kLeastSimilarity) continue;
    matches_.push_back({static_cast<int>(i),
                        Vector2d(warp.x, warp.y),
                        std::hypot(kPatchSigma_px, static_cast<double>(alignment.sigma_px))});
  }
  return num_visible;
}

int ClosureChecker::MatchNear(const PlaceQuery& query, const SE3& T_WC) {
  constexpr double kNear_px = 4;
  matches_.clear();
  const SE3 T_CW = T_WC.Inverse();
  int num_visible = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto px = query.camera.Project(T_CW * points_[i].p_W);
    if (!px || !query.camera.IsInside(*px, kBorder_px)) continue;
    if (i < num_own_) ++num_visible;
    const UprightCorner* best = nullptr;
    int best_bits = kMostBits + 1;
    for (const UprightCorner& corner : query.corners) {
      if ((corner.px - *px).squaredNorm() > kNear_px * kNear_px) continue;
      const int bits = BestBits(*points_[i].record, corner.descriptor);
      if (bits >= best_bits) continue;
      best_bits = bits;
      best = &corner;
    }
    if (best != nullptr)
      matches_.push_back({static_cast<int>(i), best->px, LevelSigma_px(best->level)});
  }
  return num_visible;
}

// Gauss-Newton over the rotation about the world's axes and the body's position, with the tilt of
// the odometry as a measurement; matches beyond three sigmas are left out before each step and,
// for good, at the end. Covariance in the order tilt x y, heading, position.
bool ClosureChecker::Fit(const PlaceQuery& query,
                         double sigma_tilt_rad,
                         SE3& T_WB,
                         Matrix<6, 6>& covariance) {
  constexpr int kSteps = 6;
  constexpr double kMaxChi2 = 9.2;  // 99 % of two degrees of freedom
  const Quaterniond tilt_before = T_WB.q;
  std::vector<Match> fitting;
  for (int step = 0; step < kSteps; ++step) {
    Matrix<6, 6> H = Matrix<6, 6>::Zero();
    Vector<6> g = Vector<6>::Zero();
    const Vector3d turned = LogSO3(T_WB.q * tilt_before.conjugate());
    for (int axis = 0; axis < 2; ++axis) {
      const double information = 1 / (sigma_tilt_rad * sigma_tilt_rad);
      H(axis, axis) += information;
      g(axis) += information * turned(axis);
    }
    const SE3 T_WC = T_WB * query.T_BC, T_CW = T_WC.Inverse();
    const Matrix3d R_CW = T_CW.R();
    fitting.clear();
    double chi2_sum = 0;
    // Coarse at first: the start is one of two points.
    const double widening = step < 2 ? 4 : 1;
    for (const Match& match : matches_) {
      const Point& point = points_[match.point];
      Matrix<2, 3> J_px_C;
      const auto px = query.camera.Project(T_CW * point.p_W, &J_px_C);
      if (!px) continue;
      const Vector2d error = *px - match.px;
      const Matrix<2, 3> J_px_W = J_px_C * R_CW;
      const Vector2d along =
          J_px_W * point.ray_W * static_cast<double>(point.record->sigma_depth_m);
      Matrix2d noise = along * along.transpose();
      noise.diagonal().array() += match.sigma_px * match.sigma_px;
      const Matrix2d information = noise.inverse();
      const double chi2 = error.dot(information * error);
      if (chi2 > kMaxChi2 * widening * widening) continue;
      fitting.push_back(match);
      chi2_sum += chi2;
      Matrix<2, 6> J;
      J.leftCols<3>() = J_px_W * Hat(point.p_W - T_WB.p);
      J.rightCols<3>() = -J_px_W;
      H += J.transpose() * information * J;
      g += J.transpose() * information * error;
    }
    if (static_cast<int>(fitting.size()) < kMinConsensus) return false;
    const Eigen::LDLT<Matrix<6, 6>> ldlt(H);
    if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return false;
    const Vector<6> x = -ldlt.solve(g);
    if (!x.allFinite()) return false;
    T_WB.q = (ExpSO3(x.head<3>()) * T_WB.q).normalized();
    T_WB.p += x.tail<3>();
    const double freedom = std::max(1.0, 2.0 * static_cast<double>(fitting.size()) - 6);
    covariance = ldlt.solve(Matrix<6, 6>::Identity()) * std::max(1.0, chi2_sum / freedom);
  }
  matches_ = fitting;
  return true;
}

// Corners in at least four of twelve parts of the image.
bool ClosureChecker::IsSpread(const PlaceQuery& query) const {
  std::set<int> parts;
  for (const Match& match : matches_) {
    const Vector2d& px = match.px;
    parts.insert(static_cast<int>(px.y() * 3 / query.camera.height()) * 4 +
                 static_cast<int>(px.x() * 4 / query.camera.width()));
  }
  return parts.size() >= 4;
}

}  // namespace facet
