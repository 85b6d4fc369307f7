// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/image_rotation.h"

#include <utility>

namespace facet {
namespace {

// Enough for a rotation to a milliradian, few enough to cost little.
constexpr int kNumTracks = 60;
constexpr double kSigma_px = 0.7;

}  // namespace

ImageRotation::ImageRotation(const CameraModel& left)
    : camera_(left),
      tracker_(left, options_),
      detector_(options_.detector, options_.klt),
      tracks_(kNumTracks),
      first_(kNumTracks) {}

void ImageRotation::Begin(const cv::Mat& left) {
  now_.Build(left, options_.klt.num_levels);
  num_begun_ = 0;
  for (Track& track : tracks_)
    track.id = LandmarkId{};
  for (const Vector2d& px : detector_.Detect(left, now_.level(0), {}, kNumTracks)) {
    const auto slot = static_cast<std::size_t>(num_begun_);
    if (!tracker_.Begin(now_, px, tracks_[slot])) continue;
    tracks_[slot].id = LandmarkId{num_begun_++};
    first_[slot] = tracks_[slot].Bearing();
  }
}

double ImageRotation::Follow(const cv::Mat& left) {
  std::swap(previous_, now_);
  now_.Build(left, options_.klt.num_levels);
  const TrackingSummary summary = tracker_.Advance(previous_, now_, SE3(), tracks_);
  return num_begun_ == 0 ? 0 : static_cast<double>(summary.num_tracked) / num_begun_;
}

std::optional<TwoViewRotation> ImageRotation::Estimate() const {
  std::vector<BearingPair> pairs;
  for (std::size_t slot = 0; slot < tracks_.size(); ++slot) {
    if (tracks_[slot].id.IsValid()) pairs.push_back({first_[slot], tracks_[slot].Bearing()});
  }
  return EstimateTwoViewRotation(pairs, kSigma_px / camera_.mean_focal_px());
}

}  // namespace facet
