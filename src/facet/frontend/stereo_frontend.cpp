// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/stereo_frontend.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "facet/camera/image_extent.h"
#include "facet/frontend/feature_detector.h"
#include "facet/frontend/image_history.h"
#include "facet/frontend/keyframe_stereo.h"
#include "facet/frontend/repeated_image.h"
#include "facet/frontend/rig_difference.h"
#include "facet/frontend/support_places.h"
#include "facet/frontend/temporal_tracker.h"
#include "facet/frontend/track_outliers.h"
#include "facet/frontend/track_table.h"

namespace facet {

namespace {

bool IsUsable(const cv::Mat& image, const CameraModel& camera) {
  return !image.empty() && image.type() == CV_8UC1 && image.cols == camera.width() &&
         image.rows == camera.height();
}

// The bias of a gyroscope before the estimator knows it [rad/s].
constexpr double kLargestUnknownBias = 0.1;
// More tracks than this share are no mismatches, but a thing that moves, or what it moves past.
constexpr double kMaxOutvotedShare = 0.15;

std::uint8_t GreyValueAt(const cv::Mat& image, const Vector2d& px) {
  const int x = std::clamp(static_cast<int>(std::lround(px.x())), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(px.y())), 0, image.rows - 1);
  return image.at<std::uint8_t>(y, x);
}

// The options for images of another size or lens than EuRoC's: as many cells, as far apart as the
// image allows, and pyramids that follow the same motion.
FrontendOptions FitToImage(FrontendOptions options, const CameraModel& camera) {
  constexpr double kLeast = 0.5;  // patches do not shrink, and what overlaps says nothing new
  const double side = std::max(kLeast, RelativeImageSide(camera));
  const auto scaled = [side](int px) {
    return std::max(1, static_cast<int>(std::lround(side * px)));
  };
  options.detector.cell_px = scaled(options.detector.cell_px);
  options.detector.min_distance_px *= side;
  options.support.cell_px = scaled(options.support.cell_px);
  const int more_levels = std::max(0, static_cast<int>(std::lround(std::log2(side))));
  options.klt.num_levels = std::min(options.klt.num_levels + more_levels, kMaxPyramidLevels);
  return options;
}

}  // namespace

struct StereoFrontend::Impl {
  Impl(const StereoRig& stereo_rig, const FrontendOptions& frontend_options);

  FrontendResult Process(const StereoFrame& frame, const FrontendHint& hint, StageTimes& times);
  void TakeHint(const FrontendHint& hint);
  void Calibrate(const StereoRig& refined);
  bool IsRepeated(const StereoFrame& frame,
                  bool is_blank,
                  const FrontendHint& hint,
                  double interval_s);
  void FollowTracks(const cv::Mat& left, bool is_motion_known, FrontendResult& result);
  void DetectNew(const cv::Mat& left, FrontendResult& result);
  void MatchStereo(const cv::Mat& right, bool is_motion_known, FrontendResult& result);
  void StartKeyframe(const StereoFrame& frame,
                     bool is_motion_known,
                     FrontendResult& result,
                     StageTimes& times);
  void FillObservations(FrontendResult& result);
  void FillDepths(const cv::Mat& left, FrontendResult& result, StageTimes& times);

  /// Predicted from the gyroscope, and where known from the estimator.
  struct Motion {
    SE3 T_Bprev_Bnow;                                   ///< since images.previous
    Quaterniond R_C_kf_prev = Quaterniond::Identity();  ///< left camera, since the last keyframe
  };

  StereoRig rig;
  FrontendOptions options;
  TrackTable tracks;
  TemporalTracker temporal_tracker;
  TrackOutliers outliers;
  FeatureDetector detector;
  KeyframeStereo stereo;
  KeyframePolicy keyframe_policy;
  SupportPlaces support_places;
  PyramidPair images;
  Motion motion;
  std::int64_t next_frame = 0;
  std::optional<Timestamp> newest_t;
  struct Repetitions {
    RepeatedImage left;
    ImageHistory all_left;
    cv::Mat newest_right;
    bool is_right_repeated = false;
  } repetitions;
};

StereoFrontend::Impl::Impl(const StereoRig& stereo_rig, const FrontendOptions& frontend_options)
    : rig(stereo_rig),
      options(frontend_options),
      tracks(options.max_features),
      temporal_tracker(rig.cameras[0], options),
      outliers(options.outliers, rig.cameras[0].mean_focal_px()),
      detector(options.detector, options.klt),
      stereo(rig, options),
      keyframe_policy(options.keyframe),
      support_places(options.support),
      repetitions{RepeatedImage(rig.cameras[0].mean_focal_px()),
                  ImageHistory(rig.cameras[0].mean_focal_px()),
                  {},
                  false} {}

void StereoFrontend::Impl::TakeHint(const FrontendHint& hint) {
  motion.T_Bprev_Bnow = motion.T_Bprev_Bnow * SE3(hint.R_prev_now, hint.p_prev_now);
  if (hint.rig && hint.rig != stereo.rig_of_depths()) {
    stereo.SetRigOfDepths(hint.rig);
    if (SeesDifferently(rig, *hint.rig)) Calibrate(*hint.rig);
  }
  if (hint.inverse_distance == nullptr) return;
  for (Track& track : tracks.slots()) {
    if (!track.id.IsValid()) continue;
    const auto known = hint.inverse_distance->find(track.id);
    if (known != hint.inverse_distance->end()) track.inverse_distance = known->second;
  }
}

// Without it, what the estimator has learnt of the calibration would look like a camera that was
// knocked, and be corrected twice.
void StereoFrontend::Impl::Calibrate(const StereoRig& refined) {
  rig = refined;
  for (Track& track : tracks.slots())
    track.inverse_distance.reset();
  temporal_tracker.Calibrate(rig.cameras[0], tracks.slots());
  stereo.Calibrate(*newest_t, rig);
}

bool StereoFrontend::Impl::IsRepeated(const StereoFrame& frame,
                                      bool is_blank,
                                      const FrontendHint& hint,
                                      double interval_s) {
  const SE3& T_BC = rig.T_BC[0];
  RepeatedImage::Motion moved;
  moved.T_prev_now = T_BC.Inverse() * SE3(hint.R_prev_now, hint.p_prev_now) * T_BC;
  const bool is_bias_known = hint.inverse_distance != nullptr;
  moved.rotation_slack = is_bias_known ? 0 : kLargestUnknownBias * interval_s;
  int num = 0;
  for (const Track& track : tracks.slots()) {
    if (!track.id.IsValid() || !track.inverse_distance) continue;
    moved.mean_inverse_distance += (*track.inverse_distance - moved.mean_inverse_distance) / ++num;
  }
  const bool repeats_last = repetitions.left.Add(frame.left, moved);
  // Black images are all the same.
  const bool came_before = repetitions.all_left.Add(is_blank ? cv::Mat() : frame.left, moved);
  // Where the left image changes, the right one has to.
  repetitions.is_right_repeated =
      !repetitions.left.is_same() && AreSameImage(repetitions.newest_right, frame.right);
  repetitions.newest_right = frame.right;
  return repeats_last || came_before;
}

void StereoFrontend::Impl::FollowTracks(const cv::Mat& left,
                                        bool is_motion_known,
                                        FrontendResult& result) {
  images.Build(left, options.klt.num_levels);
  const SE3& T_BC = rig.T_BC[0];
  const SE3 T_Cprev_Cnow = T_BC.Inverse() * motion.T_Bprev_Bnow * T_BC;
  if (!images.previous.empty()) {
    result.tracking = temporal_tracker.Advance(
        images.previous, images.now, T_Cprev_Cnow.Inverse(), tracks.slots());
  }
  motion.R_C_kf_prev = (motion.R_C_kf_prev * T_Cprev_Cnow.q).normalized();
  motion.T_Bprev_Bnow = SE3();
  tracks.RenameRenewed();
  // Landmarks and IMU together tell what moves on its own, even if that is most of the image, where
  // a vote of the tracks would throw out what stands still: then single tracks go, but no group.
  const double max_share = is_motion_known ? kMaxOutvotedShare : 1.0;
  result.num_outliers = outliers.Remove(motion.R_C_kf_prev, max_share, tracks.slots());
  result.tracking.num_tracked -= result.num_outliers;
}

void StereoFrontend::Impl::DetectNew(const cv::Mat& left, FrontendResult& result) {
  const std::span<const Vector2d> occupied = tracks.Places();
  const std::span<Track> slots = tracks.slots();
  const int wanted = static_cast<int>(slots.size() - occupied.size());
  auto slot = slots.begin();
  for (const Vector2d& px : detector.Detect(left, images.now.level(0), occupied, wanted)) {
    while (slot != slots.end() && slot->id.IsValid())
      ++slot;
    if (slot == slots.end()) break;
    if (!temporal_tracker.Begin(images.now, px, *slot)) continue;
    slot->id = tracks.NewLandmark();
    ++result.num_new;
  }
}

void StereoFrontend::Impl::MatchStereo(const cv::Mat& right,
                                       bool is_motion_known,
                                       FrontendResult& result) {
  if (!IsUsable(right, rig.cameras[1]) || repetitions.is_right_repeated) return;
  result.right = stereo.MatchTracks(*newest_t, images.now, right, is_motion_known, tracks.slots());
  result.right_ok = stereo.has_right();
}

void StereoFrontend::Impl::StartKeyframe(const StereoFrame& frame,
                                         bool is_motion_known,
                                         FrontendResult& result,
                                         StageTimes& times) {
  {
    const ScopedStage stage(times, Stage::kDetect);
    DetectNew(frame.left, result);
  }
  const ScopedStage stage(times, Stage::kStereo);
  MatchStereo(frame.right, is_motion_known, result);
  keyframe_policy.SetKeyframeSize(tracks.StartKeyframe());
  motion.R_C_kf_prev = Quaterniond::Identity();
}

void StereoFrontend::Impl::FillObservations(FrontendResult& result) {
  const auto sigma = [this](double base_px, int level, double residual_px) {
    return std::hypot(base_px * (1 << level), options.noise.residual_factor * residual_px);
  };
  const std::span<const std::size_t> order = tracks.ByLandmark();
  result.observations.features.reserve(order.size());
  for (const std::size_t slot : order) {
    const Track& track = tracks[slot];
    FeatureObservation observation;
    observation.landmark = track.id;
    observation.px_left = track.px;
    observation.sigma_left_px = sigma(options.noise.left_base_px, track.level, track.sigma_px);
    if (const std::optional<StereoMatch>& match = stereo.match(slot)) {
      observation.px_right = match->px;
      observation.sigma_right_px =
          sigma(options.noise.right_base_px, match->level, match->sigma_px);
      if (options.noise.match_base_px > 0) {
        observation.sigma_match_px =
            sigma(options.noise.match_base_px, match->level, match->sigma_px);
      }
      ++result.num_stereo;
    }
    result.observations.features.push_back(observation);
  }
}

void StereoFrontend::Impl::FillDepths(const cv::Mat& left,
                                      FrontendResult& result,
                                      StageTimes& times) {
  const ScopedStage stage(times, Stage::kStereo);
  const std::vector<FeatureObservation>& features = result.observations.features;
  KeyframeDepths& depths = result.depths;
  depths.inverse_distances.reserve(features.size());
  for (const std::size_t slot : tracks.ByLandmark())
    depths.inverse_distances.push_back(tracks[slot].inverse_distance.value_or(0));
  depths.intensities.reserve(features.size());
  for (const FeatureObservation& feature : features)
    depths.intensities.push_back(GreyValueAt(left, feature.px_left));
  if (!options.support.enabled) return;
  const std::vector<DepthQuery>& places =
      support_places.Choose(left, features, depths.inverse_distances);
  depths.support.reserve(places.size());
  stereo.MatchPlaces(places, images.now, depths.support);
  for (SupportPoint& point : depths.support)
    point.intensity = GreyValueAt(left, point.px);
}

FrontendResult StereoFrontend::Impl::Process(const StereoFrame& frame,
                                             const FrontendHint& hint,
                                             StageTimes& times) {
  FrontendResult result;
  result.observations.frame = FrameId{next_frame++};
  result.observations.t = frame.t;
  result.in_order = !newest_t || frame.t > *newest_t;
  if (!result.in_order) return result;
  const double interval_s = newest_t ? ToSeconds(frame.t - *newest_t) : 0;
  newest_t = frame.t;
  TakeHint(hint);
  result.image_ok = IsUsable(frame.left, rig.cameras[0]);
  if (!result.image_ok) return result;
  result.is_blank = IsBlank(frame.left);
  const bool is_repeated = IsRepeated(frame, result.is_blank, hint, interval_s);
  result.is_repeated = is_repeated && !result.is_blank;
  if (is_repeated) return result;
  stereo.Clear();
  {
    const ScopedStage stage(times, Stage::kTrack);
    FollowTracks(frame.left, hint.is_motion_known, result);
    result.keyframe_reason = keyframe_policy.Decide(frame.t, tracks.CountShared());
  }
  result.observations.is_keyframe = result.keyframe_reason != KeyframeReason::kNone;
  if (result.observations.is_keyframe) StartKeyframe(frame, hint.is_motion_known, result, times);
  FillObservations(result);
  if (result.observations.is_keyframe) FillDepths(frame.left, result, times);
  return result;
}

StereoFrontend::StereoFrontend(const StereoRig& rig, const FrontendOptions& options)
    : impl_(std::make_unique<Impl>(rig, FitToImage(options, rig.cameras[0]))) {}

StereoFrontend::~StereoFrontend() = default;

const PyramidPair& StereoFrontend::left_images() const {
  return impl_->images;
}

const StereoRig& StereoFrontend::rig() const {
  return impl_->rig;
}

FrontendResult StereoFrontend::Process(const StereoFrame& frame,
                                       const FrontendHint& hint,
                                       StageTimes& times) {
  return impl_->Process(frame, hint, times);
}

}  // namespace facet
