// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/stereo_matcher.h"

#include <algorithm>
#include <cmath>

#include "facet/camera/stereo_triangulation.h"
#include "facet/frontend/warp_prediction.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr std::size_t kMaxCandidates = 2;
// Coarsest level of a match whose distance is known.
constexpr int kSeededLevel = 1;

// Free parameters of the warp from left to right: shift, rotation and scale. Places whose depth is
// predicted (support points) need the shift only.
constexpr int kParameters = 4, kNearParameters = 2;
// Support points are not tracked on: the last hundredths of a pixel, far below the noise, are not
// worth an iteration.
constexpr double kNearMinUpdate_px = 0.05;
// The search along the epipolar line looks at every pixel of this pyramid level, four of the image.
constexpr int kSearchLevel = 2;
// Similarity (ZNCC) that the best place of the search must have to be refined.
constexpr float kMinSearchZncc = 0.6F;

// What a shape whose entries are within 2.5 % of the upright one changes is at most a quarter of a
// pixel in the corners of the patch and nothing in the middle, and upright patches are sampled row
// by row.
void NeglectSlightShape(PatchWarp& warp) {
  constexpr float kSlight = 0.025F;
  const float largest = std::max(
      {std::abs(warp.a00 - 1), std::abs(warp.a01), std::abs(warp.a10), std::abs(warp.a11 - 1)});
  if (!(largest <= kSlight)) return;
  warp.a00 = warp.a11 = 1;
  warp.a01 = warp.a10 = 0;
}

}  // namespace

StereoMatcher::StereoMatcher(const StereoRig& rig, const FrontendOptions& options)
    : right_camera_(rig.cameras[1]),
      T_C1C0_(rig.T_C1C0()),
      options_(options.stereo),
      tracker_(options.klt, kParameters),
      near_tracker_(options.klt, kNearParameters, kNearMinUpdate_px),
      patch_(options.klt.num_levels, kParameters),
      back_(options.klt.num_levels, kParameters) {}

void StereoMatcher::Calibrate(const StereoRig& rig) {
  right_camera_ = rig.cameras[1];
  T_C1C0_ = rig.T_C1C0();
  if (turn_) T_C1C0_ = SE3(turn_->conjugate(), Vector3d::Zero()) * T_C1C0_;
}

void StereoMatcher::TurnRight(const Vector3d& omega) {
  const Quaterniond turn = ExpSO3(omega);
  turn_ = (turn_.value_or(Quaterniond::Identity()) * turn).normalized();
  T_C1C0_ = SE3(turn.conjugate(), Vector3d::Zero()) * T_C1C0_;
}

std::optional<Vector2d> StereoMatcher::AsCalibrated(const Vector2d& px_right) const {
  if (!turn_) return px_right;
  const std::optional<Vector3d> bearing = right_camera_.Unproject(px_right);
  if (!bearing) return std::nullopt;
  return right_camera_.Project(*turn_ * *bearing);
}

bool StereoMatcher::Triangulate(const PixelBearing& ray,
                                const Vector2d& px_right,
                                StereoMatch& match) const {
  const std::optional<PixelBearing> right = right_camera_.BearingOf(px_right);
  if (!right) return false;
  const auto found = TriangulateOnRay(ray.bearing, *right, T_C1C0_);
  if (!found) return false;
  const double rho = found->inverse_distance;
  if (found->off_line_px > options_.max_epipolar_px) return false;
  if (rho * found->px_per_inverse_distance < -options_.max_epipolar_px) return false;
  match.inverse_distance = std::max(0.0, rho);
  match.px_per_inverse_distance = found->px_per_inverse_distance;
  match.off_line_px = found->off_line_px;
  return true;
}

std::optional<StereoMatch> StereoMatcher::Refine(const Track& track,
                                                 const Start& start,
                                                 const ImagePyramid& left,
                                                 const ImagePyramid& right,
                                                 float* zncc) {
  std::optional<PatchWarp> warp =
      PredictWarp(track.ray, start.inverse_distance, T_C1C0_, right_camera_);
  if (!warp) return std::nullopt;
  const PatchTracker& tracker = start.tracker;
  if (&tracker == &near_tracker_) NeglectSlightShape(*warp);
  const Alignment found = tracker.Align(patch_, right, {start.coarsest_level, track.level}, *warp);
  *zncc = found.zncc;
  if (!found.ok || found.zncc < static_cast<float>(options_.min_zncc)) return std::nullopt;
  StereoMatch match;
  match.px = Vector2d(warp->x, warp->y);
  match.sigma_px = found.sigma_px;
  match.level = found.level;
  if (!right_camera_.IsInside(match.px, 1.0)) return std::nullopt;
  if (!Triangulate(track.ray, match.px, match)) return std::nullopt;

  const auto x = static_cast<float>(track.px.x()), y = static_cast<float>(track.px.y());
  PatchWarp back = InverseAt(*warp, x, y);
  const LevelRange finest = {found.level, found.level};
  tracker.Extract(right, warp->x, warp->y, finest, back_);
  if (!tracker.Align(back_, left, finest, back).ok) return std::nullopt;
  const float distance = std::hypot(back.x - x, back.y - y);
  if (distance > static_cast<float>(options_.max_left_right_px)) return std::nullopt;
  const std::optional<Vector2d> as_calibrated = AsCalibrated(match.px);
  if (!as_calibrated) return std::nullopt;
  match.px = *as_calibrated;
  return match;
}

void StereoMatcher::Search(const Track& track,
                           const ImagePyramid& left,
                           const ImagePyramid& right) {
  samples_.clear();
  candidates_.clear();
  const int num_levels = std::min(right.num_levels(), static_cast<int>(patch_.levels.size()));
  int level = std::min(kSearchLevel, num_levels - 1);
  const auto x = static_cast<float>(track.px.x()), y = static_cast<float>(track.px.y());
  tracker_.Extract(left, x, y, {level, kSeededLevel + 1}, patch_);
  while (level > 0 && !patch_.IsValid(level))
    --level;
  const PatchTemplate& patch = patch_.levels[static_cast<std::size_t>(level)];
  if (!patch.is_valid) return;
  const double max_inverse_distance = 1 / options_.min_depth_m;
  const std::optional<PatchWarp> far = PredictWarp(track.ray, 0, T_C1C0_, right_camera_);
  if (!far) return;
  const double step_px = 1 << level;
  const Vector3d bearing_C1 = T_C1C0_.q * track.ray.bearing;
  const std::optional<Vector2d> nearest =
      right_camera_.Project(bearing_C1 + max_inverse_distance * T_C1C0_.p);
  const double length_px =
      nearest ? (*nearest - Vector2d(far->x, far->y)).norm()
              : right_camera_.mean_focal_px() * T_C1C0_.p.norm() * max_inverse_distance;
  const int steps = std::max(1, static_cast<int>(std::ceil(length_px / step_px)));
  for (int i = 0; i <= steps; ++i) {
    const double rho = max_inverse_distance * i / steps;
    const std::optional<Vector2d> px = right_camera_.Project(bearing_C1 + rho * T_C1C0_.p);
    Candidate sample{rho, -1};
    if (px && right_camera_.IsInside(*px, 0)) {
      PatchWarp warp = *far;  // the shape hardly depends on the distance
      warp.x = static_cast<float>(px->x());
      warp.y = static_cast<float>(px->y());
      sample.zncc = tracker_.Similarity(patch, right.level(level), ToLevel(warp, level));
    }
    samples_.push_back(sample);
  }
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const float here = samples_[i].zncc;
    const float before = i > 0 ? samples_[i - 1].zncc : -2;
    const float after = i + 1 < samples_.size() ? samples_[i + 1].zncc : -2;
    if (here < kMinSearchZncc) continue;
    if (here >= before && here > after) candidates_.push_back(samples_[i]);
  }
  std::stable_sort(candidates_.begin(),
                   candidates_.end(),
                   [](const Candidate& a, const Candidate& b) { return a.zncc > b.zncc; });
  if (candidates_.size() > kMaxCandidates) candidates_.resize(kMaxCandidates);
}

std::optional<StereoMatch> StereoMatcher::Match(const Track& track,
                                                const ImagePyramid& left,
                                                const ImagePyramid& right) {
  float zncc = -1;
  patch_.Invalidate();
  const auto x = static_cast<float>(track.px.x()), y = static_cast<float>(track.px.y());
  tracker_.Extract(left, x, y, {kSeededLevel, 0}, patch_);
  if (track.inverse_distance) {
    std::optional<StereoMatch> match =
        Refine(track, {*track.inverse_distance, kSeededLevel, tracker_}, left, right, &zncc);
    if (match) return match;
  }
  Search(track, left, right);
  std::optional<StereoMatch> best;
  float best_zncc = -1;
  for (const Candidate& candidate : candidates_) {
    const int level = std::max(kSearchLevel, track.level);
    std::optional<StereoMatch> match =
        Refine(track, {candidate.inverse_distance, level, tracker_}, left, right, &zncc);
    if (!match || zncc <= best_zncc) continue;
    best = match;
    best_zncc = zncc;
  }
  return best;
}

std::optional<StereoMatch> StereoMatcher::MatchNear(const Track& track,
                                                    std::span<const double> inverse_distances,
                                                    const ImagePyramid& left,
                                                    const ImagePyramid& right) {
  patch_.Invalidate();
  const auto x = static_cast<float>(track.px.x()), y = static_cast<float>(track.px.y());
  near_tracker_.Extract(left, x, y, {kSeededLevel, track.level}, patch_);
  float zncc = -1;
  for (double inverse_distance : inverse_distances) {
    const Start start = {inverse_distance, kSeededLevel, near_tracker_};
    auto match = Refine(track, start, left, right, &zncc);
    if (match) return match;
  }
  return std::nullopt;
}

}  // namespace facet
