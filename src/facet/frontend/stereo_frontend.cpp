// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/stereo_frontend.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "facet/base/check.h"
#include "facet/frontend/feature_detector.h"
#include "facet/frontend/outlier_rejection.h"
#include "facet/frontend/stereo_matcher.h"
#include "facet/frontend/temporal_tracker.h"

namespace facet {

struct StereoFrontend::Impl {
  Impl(const StereoRig& stereo_rig, const FrontendOptions& frontend_options);

  FrontendResult Process(const StereoFrame& frame, const FrontendHint& hint, StageTimes& times);
  bool IsUsable(const cv::Mat& image, const CameraModel& camera) const;
  void TakeDepths(const FrontendHint& hint);
  void FollowTracks(const cv::Mat& left, FrontendResult& result);
  void RenameRenewed();
  void RejectOutliers(FrontendResult& result);
  void DetectNew(const cv::Mat& left, FrontendResult& result);
  void MatchStereo(const cv::Mat& right);
  void StartKeyframe();
  void FillObservations(FrontendResult& result);
  void MatchDepths(std::span<const DepthQuery> queries, std::vector<DepthPoint>& found);
  SharedPoints CountShared() const;

  StereoRig rig;
  FrontendOptions options;
  PatchTracker detection_tracker;
  TemporalTracker temporal_tracker;
  FeatureDetector detector;
  StereoMatcher stereo_matcher;
  OutlierRejection outlier_rejection;
  KeyframePolicy keyframe_policy;

  std::vector<Track> tracks;                        // fixed number of slots
  std::vector<std::optional<StereoMatch>> matches;  // of the newest frame, by slot
  ImagePyramid previous, now, right_pyramid;
  SE3 T_Bprev_Bnow;         // predicted motion since the image in `previous`
  Quaterniond R_C_kf_prev;  // rotation of the left camera, last keyframe from previous frame
  bool has_right = false;   // right_pyramid belongs to `now`
  Track depth_place;        // of MatchDepths
  std::int64_t next_landmark = 0;
  LandmarkId first_after_keyframe;  // landmarks from this one on are newer than the last keyframe
  std::int64_t next_frame = 0;
  // Buffers
  std::vector<std::size_t> order;
  std::vector<Vector2d> occupied;
  std::vector<BearingPair> pairs;
  std::vector<std::size_t> pair_slots;
  std::vector<unsigned char> is_outlier;
};

StereoFrontend::Impl::Impl(const StereoRig& stereo_rig, const FrontendOptions& frontend_options)
    : rig(stereo_rig),
      options(frontend_options),
      detection_tracker(options.klt, options.detector.num_parameters),
      temporal_tracker(rig.cameras[0], options),
      detector(options.detector),
      stereo_matcher(rig, options),
      outlier_rejection(options.outliers, rig.cameras[0].mean_focal_px()),
      keyframe_policy(options.keyframe),
      R_C_kf_prev(Quaterniond::Identity()) {
  FACET_CHECK(options.max_features > 0) << options.max_features;
  const auto slots = static_cast<std::size_t>(options.max_features);
  tracks.resize(slots);
  matches.resize(slots);
}

bool StereoFrontend::Impl::IsUsable(const cv::Mat& image, const CameraModel& camera) const {
  return !image.empty() && image.type() == CV_8UC1 && image.cols == camera.width() &&
         image.rows == camera.height();
}

void StereoFrontend::Impl::TakeDepths(const FrontendHint& hint) {
  if (hint.inverse_depth == nullptr) return;
  for (Track& track : tracks) {
    if (!track.id.IsValid()) continue;
    const auto known = hint.inverse_depth->find(track.id);
    if (known != hint.inverse_depth->end()) track.inverse_depth = known->second;
  }
}

void StereoFrontend::Impl::FollowTracks(const cv::Mat& left, FrontendResult& result) {
  std::swap(previous, now);
  now.Build(left, options.klt.num_levels);
  const SE3& T_BC = rig.T_BC[0];
  const SE3 T_Cprev_Cnow = T_BC.Inverse() * T_Bprev_Bnow * T_BC;
  if (!previous.empty()) {
    result.tracking = temporal_tracker.Advance(previous, now, T_Cprev_Cnow.Inverse(), tracks);
  }
  R_C_kf_prev = (R_C_kf_prev * T_Cprev_Cnow.q).normalized();
  T_Bprev_Bnow = SE3();
}

// What a track has slid until its reference is taken anew stays in it for good. As another landmark
// it contradicts nothing that was seen before.
void StereoFrontend::Impl::RenameRenewed() {
  for (Track& track : tracks) {
    if (track.id.IsValid() && track.is_renewed) track.id = LandmarkId{next_landmark++};
  }
}

void StereoFrontend::Impl::RejectOutliers(FrontendResult& result) {
  if (!options.outliers.enabled) return;
  pairs.clear();
  pair_slots.clear();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Track& track = tracks[i];
    if (!track.id.IsValid() || !track.keyframe_bearing) continue;
    const Vector3d bearing = Vector3d(track.ray.xy.x(), track.ray.xy.y(), 1).normalized();
    pairs.push_back({*track.keyframe_bearing, R_C_kf_prev * bearing});
    pair_slots.push_back(i);
  }
  if (outlier_rejection.Find(pairs, is_outlier) != OutlierVerdict::kTrusted) return;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (is_outlier[k] == 0) continue;
    tracks[pair_slots[k]].id = LandmarkId{};
    ++result.num_outliers;
    --result.tracking.num_tracked;
  }
}

SharedPoints StereoFrontend::Impl::CountShared() const {
  SharedPoints shared;
  for (const Track& track : tracks) {
    if (!track.id.IsValid() || !track.keyframe_bearing) continue;
    ++shared.num_tracked;
    shared.num_landmarks += track.id < first_after_keyframe ? 1 : 0;
  }
  return shared;
}

void StereoFrontend::Impl::DetectNew(const cv::Mat& left, FrontendResult& result) {
  occupied.clear();
  for (const Track& track : tracks) {
    if (track.id.IsValid()) occupied.push_back(track.px);
  }
  const int wanted = static_cast<int>(tracks.size() - occupied.size());
  const auto found = detector.Detect(left, now.level(0), detection_tracker, occupied, wanted);
  auto slot = tracks.begin();
  for (const Vector2d& px : found) {
    while (slot != tracks.end() && slot->id.IsValid())
      ++slot;
    if (slot == tracks.end()) break;
    if (!temporal_tracker.Begin(now, px, *slot)) continue;
    slot->id = LandmarkId{next_landmark++};
    ++result.num_new;
  }
}

void StereoFrontend::Impl::MatchStereo(const cv::Mat& right) {
  if (!IsUsable(right, rig.cameras[1])) return;
  right_pyramid.Build(right, options.klt.num_levels);
  has_right = true;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track& track = tracks[i];
    if (!track.id.IsValid()) continue;
    matches[i] = stereo_matcher.Match(track, now, right_pyramid);
    if (matches[i]) track.inverse_depth = matches[i]->inverse_depth;
  }
}

void StereoFrontend::Impl::StartKeyframe() {
  int size = 0;
  for (Track& track : tracks) {
    track.keyframe_bearing.reset();
    if (!track.id.IsValid()) continue;
    track.keyframe_bearing = Vector3d(track.ray.xy.x(), track.ray.xy.y(), 1).normalized();
    ++size;
  }
  first_after_keyframe = LandmarkId{next_landmark};
  R_C_kf_prev = Quaterniond::Identity();
  keyframe_policy.SetKeyframeSize(size);
}

void StereoFrontend::Impl::FillObservations(FrontendResult& result) {
  const auto sigma = [this](double base_px, int level, double residual_px) {
    return std::hypot(base_px * (1 << level), options.noise.residual_factor * residual_px);
  };
  order.clear();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (tracks[i].id.IsValid()) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [this](std::size_t i, std::size_t j) {
    return tracks[i].id < tracks[j].id;
  });
  result.observations.features.reserve(order.size());
  for (std::size_t i : order) {
    const Track& track = tracks[i];
    FeatureObservation observation;
    observation.landmark = track.id;
    observation.px_left = track.px;
    observation.sigma_left_px = sigma(options.noise.left_base_px, track.level, track.sigma_px);
    if (matches[i]) {
      observation.px_right = matches[i]->px;
      observation.sigma_right_px =
          sigma(options.noise.right_base_px, matches[i]->level, matches[i]->sigma_px);
      ++result.num_stereo;
    }
    result.observations.features.push_back(observation);
    if (result.observations.is_keyframe)
      result.inverse_depths.push_back(track.inverse_depth.value_or(0));
  }
}

void StereoFrontend::Impl::MatchDepths(std::span<const DepthQuery> queries,
                                       std::vector<DepthPoint>& found) {
  if (!has_right) return;
  const double baseline_focal_px = rig.baseline_m() * rig.cameras[1].mean_focal_px();
  for (const DepthQuery& query : queries) {
    const auto ray = rig.cameras[0].Undistort(query.px);
    if (!ray) continue;
    depth_place.px = query.px;
    depth_place.ray = *ray;
    const std::span depths(query.inverse_depths.data(), static_cast<std::size_t>(query.num_depths));
    const auto match = stereo_matcher.MatchNear(depth_place, depths, now, right_pyramid);
    if (!match || match->level != 0 || !(match->inverse_depth > 0)) continue;
    const double sigma_px =
        std::hypot(options.noise.right_base_px, options.noise.residual_factor * match->sigma_px);
    found.push_back({query.px, ray->xy, match->inverse_depth, sigma_px / baseline_focal_px});
  }
}

FrontendResult StereoFrontend::Impl::Process(const StereoFrame& frame,
                                             const FrontendHint& hint,
                                             StageTimes& times) {
  FrontendResult result;
  result.observations.frame = FrameId{next_frame++};
  result.observations.t = frame.t;
  T_Bprev_Bnow = T_Bprev_Bnow * SE3(hint.R_prev_now, hint.p_prev_now);
  TakeDepths(hint);
  result.image_ok = IsUsable(frame.left, rig.cameras[0]);
  if (!result.image_ok) return result;
  std::fill(matches.begin(), matches.end(), std::nullopt);
  has_right = false;
  {
    const ScopedStage stage(times, Stage::kTrack);
    FollowTracks(frame.left, result);
    RenameRenewed();
    RejectOutliers(result);
    result.keyframe_reason = keyframe_policy.Decide(frame.t, CountShared());
  }
  result.observations.is_keyframe = result.keyframe_reason != KeyframeReason::kNone;
  if (result.observations.is_keyframe) {
    {
      const ScopedStage stage(times, Stage::kDetect);
      DetectNew(frame.left, result);
    }
    const ScopedStage stage(times, Stage::kStereo);
    MatchStereo(frame.right);
    result.right_ok = has_right;
    StartKeyframe();
  }
  FillObservations(result);
  return result;
}

StereoFrontend::StereoFrontend(const StereoRig& rig, const FrontendOptions& options)
    : impl_(std::make_unique<Impl>(rig, options)) {}

StereoFrontend::~StereoFrontend() = default;

void StereoFrontend::MatchDepths(std::span<const DepthQuery> queries,
                                 std::vector<DepthPoint>& found) {
  impl_->MatchDepths(queries, found);
}

FrontendResult StereoFrontend::Process(const StereoFrame& frame,
                                       const FrontendHint& hint,
                                       StageTimes& times) {
  return impl_->Process(frame, hint, times);
}

}  // namespace facet
