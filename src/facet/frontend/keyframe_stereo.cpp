// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/keyframe_stereo.h"

#include <algorithm>
#include <cmath>

#include "facet/base/median.h"
#include "facet/camera/stereo_triangulation.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

// A right camera that is turned about its axis of view keeps matches inside the gate: those of the
// middle of the image, and many of them near the gate's edges.
constexpr double kNearShareOfGate = 0.5;
// To learn how far the right camera is turned: 0.6 deg with EuRoC's lens.
constexpr double kWideGate_px = 5;

// Of the right camera: turned about it, points move along the baseline.
Vector3d AxisAcross(const StereoRig& rig) {
  return rig.T_C1C0().p.cross(Vector3d::UnitZ()).normalized();
}

}  // namespace

KeyframeStereo::KeyframeStereo(const StereoRig& rig, const FrontendOptions& options)
    : rig_(rig),
      options_(options),
      matcher_(rig, options),
      disparities_(rig.cameras[1].mean_focal_px()),
      matches_(static_cast<std::size_t>(options.max_features)) {}

void KeyframeStereo::Calibrate(Timestamp t, const StereoRig& rig) {
  rig_ = rig;
  rig_.T_BC[1].q = (rig.T_BC[1].q * turn_).normalized();
  matcher_.Calibrate(rig);
  watch_.Forget();
  disparities_.Forget(t);
}

void KeyframeStereo::Clear() {
  std::fill(matches_.begin(), matches_.end(), std::nullopt);
  has_right_ = false;
}

RightImageFindings KeyframeStereo::MatchTracks(Timestamp t,
                                               const ImagePyramid& left,
                                               const cv::Mat& right,
                                               bool are_depths_known,
                                               std::span<Track> tracks) {
  right_.Build(right, options_.klt.num_levels);
  has_right_ = true;
  KeepDepths(tracks);
  MatchAll(left, tracks);
  const bool is_suspicious = IsSuspicious(t, tracks);
  const bool in_doubt = !watch_.IsTrustedAt(t);
  DisparityShift shift;
  DisparityWatch::Verdict verdict = DisparityWatch::Verdict::kAgrees;
  if (are_depths_known) {
    shift = ShiftOf(tracks);
    verdict = disparities_.Add(t, shift, in_doubt);
  }
  RightImageFindings findings;
  // What is off along the lines is mended first: matches at other points look like other turns.
  const bool may_be_off_lines =
      verdict == DisparityWatch::Verdict::kAgrees || verdict == DisparityWatch::Verdict::kScatters;
  if (is_suspicious && may_be_off_lines)
    findings.turn = watch_.Add(t, rig_, MatchWidely(left, tracks));
  if (findings.turn) {
    Turn(findings.turn->omega, left, tracks);
    // The next keyframes show whether the camera is turned along the lines, too.
    if (are_depths_known) shift = ShiftOf(tracks);
    verdict = DisparityWatch::AreBelieved(shift) ? DisparityWatch::Verdict::kAgrees
                                                 : DisparityWatch::Verdict::kScatters;
  }
  const double focal_px = rig_.cameras[1].mean_focal_px();
  switch (verdict) {
    case DisparityWatch::Verdict::kAgrees:
      break;
    case DisparityWatch::Verdict::kScatters:
      Refuse(tracks);
      findings.contradiction_px = focal_px * std::max(std::abs(shift.angle), shift.spread);
      break;
    case DisparityWatch::Verdict::kContradicts:
      Refuse(tracks);
      findings.contradiction_px = focal_px * shift.angle;
      break;
    case DisparityWatch::Verdict::kTurned:
      findings.turn = StereoTurn();
      findings.turn->omega = disparities_.turn() * AxisAcross(rig_);
      findings.turn->along_px = focal_px * shift.angle;
      findings.turn->num_matches = shift.num;
      Turn(findings.turn->omega, left, tracks);
      break;
  }
  return findings;
}

void KeyframeStereo::Refuse(std::span<Track> tracks) {
  Clear();
  RestoreDepths(tracks);
}

void KeyframeStereo::KeepDepths(std::span<const Track> tracks) {
  depths_before_.clear();
  for (const Track& track : tracks)
    depths_before_.push_back(track.id.IsValid() ? track.inverse_distance : std::nullopt);
}

void KeyframeStereo::RestoreDepths(std::span<Track> tracks) const {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (tracks[i].id.IsValid()) tracks[i].inverse_distance = depths_before_[i];
  }
}

void KeyframeStereo::Turn(const Vector3d& omega,
                          const ImagePyramid& left,
                          std::span<Track> tracks) {
  rig_ = TurnedRig(rig_, omega);
  turn_ = (turn_ * ExpSO3(omega)).normalized();
  matcher_.TurnRight(omega);
  RestoreDepths(tracks);
  MatchAll(left, tracks);
}

// By how much a turn about AxisAcross moves a point: to first order. What is seen along the
// baseline or the axis hardly moves.
DisparityShift KeyframeStereo::ShiftOf(std::span<const Track> tracks) {
  constexpr double kLeastCosine = 0.2;
  // Depths that were known before are known to so much, of things that are near to a share.
  constexpr double kAgreeing_px = 2, kAgreeingShare = 0.05;
  const double agreeing = kAgreeing_px / rig_.cameras[1].mean_focal_px();
  int num_agreeing = 0;
  const Vector3d along = rig_.T_C1C0().p.normalized();
  const Vector3d ahead = (Vector3d::UnitZ() - along.z() * along).normalized();
  angles_.clear();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!matches_[i] || !depths_before_[i]) continue;
    const auto inverse_distance = InverseDistanceOf(tracks[i], *matches_[i]);
    const auto bearing = rig_.cameras[1].Unproject(matches_[i]->px);
    const double cosine = inverse_distance && bearing ? bearing->dot(ahead) : 0;
    if (cosine < kLeastCosine) continue;
    const double factor = rig_.baseline_m() * along.cross(*bearing).squaredNorm() / cosine;
    const double change = factor * (*inverse_distance - *depths_before_[i]);
    angles_.push_back(change);
    const double tolerance = std::max(agreeing, kAgreeingShare * factor * *depths_before_[i]);
    num_agreeing += std::abs(change) < tolerance ? 1 : 0;
  }
  DisparityShift shift;
  shift.num = static_cast<int>(angles_.size());
  shift.num_agreeing = num_agreeing;
  shift.angle = Median(angles_).value_or(0);
  for (double& angle : angles_)
    angle = std::abs(angle - shift.angle);
  shift.spread = Median(angles_).value_or(0);
  return shift;
}

std::optional<double> KeyframeStereo::InverseDistanceOf(const Track& track,
                                                        const StereoMatch& match) const {
  if (!rig_of_depths_) return match.inverse_distance;
  const auto left = rig_of_depths_->cameras[0].Unproject(track.px);
  const auto right = rig_of_depths_->cameras[1].BearingOf(match.px);
  if (!left || !right) return std::nullopt;
  const auto stereo = TriangulateOnRay(*left, *right, rig_of_depths_->T_C1C0());
  return stereo ? std::optional(stereo->inverse_distance) : std::nullopt;
}

void KeyframeStereo::MatchAll(const ImagePyramid& left, std::span<Track> tracks) {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track& track = tracks[i];
    if (!track.id.IsValid()) continue;
    matches_[i] = matcher_.Match(track, left, right_);
    if (matches_[i]) track.inverse_distance = matches_[i]->inverse_distance;
  }
}

bool KeyframeStereo::IsSuspicious(Timestamp t, std::span<const Track> tracks) {
  const double near_px = kNearShareOfGate * options_.stereo.max_epipolar_px;
  int num_tracks = 0, num_near = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    num_tracks += tracks[i].id.IsValid() ? 1 : 0;
    num_near += matches_[i] && matches_[i]->off_line_px < near_px ? 1 : 0;
  }
  return watch_.IsSuspicious(t, num_tracks, num_near);
}

std::vector<StereoRays> KeyframeStereo::MatchWidely(const ImagePyramid& left,
                                                    std::span<const Track> tracks) {
  FrontendOptions options = options_;
  options.stereo.max_epipolar_px = kWideGate_px;
  StereoMatcher matcher(rig_, options);
  std::vector<StereoRays> rays;
  for (const Track& track : tracks) {
    if (!track.id.IsValid()) continue;
    const auto match = matcher.Match(track, left, right_);
    const auto bearing = match ? rig_.cameras[1].Unproject(match->px) : std::nullopt;
    if (bearing) rays.push_back({track.ray.bearing, *bearing});
  }
  return rays;
}

void KeyframeStereo::MatchPlaces(std::span<const DepthQuery> queries,
                                 const ImagePyramid& left,
                                 std::vector<SupportPoint>& found) {
  if (!has_right_) return;
  for (const DepthQuery& query : queries) {
    const auto ray = rig_.cameras[0].BearingOf(query.px);
    if (!ray) continue;
    place_.px = query.px;
    place_.ray = *ray;
    const std::span depths(query.inverse_distances.data(),
                           static_cast<std::size_t>(query.num_depths));
    const auto match = matcher_.MatchNear(place_, depths, left, right_);
    if (!match || match->level != 0 || !(match->inverse_distance > 0)) continue;
    const double sigma_px =
        std::hypot(options_.noise.right_base_px, options_.noise.residual_factor * match->sigma_px);
    found.push_back({query.px,
                     match->px,
                     ray->bearing,
                     match->inverse_distance,
                     sigma_px / match->px_per_inverse_distance});
  }
}

}  // namespace facet
