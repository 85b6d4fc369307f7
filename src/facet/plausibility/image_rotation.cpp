// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/image_rotation.h"

#include <algorithm>

namespace facet {
namespace {

// Enough for a rotation to a milliradian, few enough to cost little.
constexpr int kNumTracks = 60;
constexpr double kSigma_px = 0.7;
// To go on with: detecting corners costs as much as following them for some images.
constexpr int kEnoughLeft = 45;

/// Where corners are detected: in a quarter of the pixels, if these have cells enough.
int DetectionLevel(const CameraModel& camera, const DetectorOptions& half_size) {
  const cv::Size half(camera.width() / 2, camera.height() / 2);
  return NumCells(half, half_size) > kNumTracks ? 1 : 0;
}

// Cells of half an image are not half as large: that would leave no choice of corners in them.
DetectorOptions HalfSize(DetectorOptions options) {
  options.cell_px = options.cell_px * 3 / 4;
  options.min_distance_px /= 2;
  return options;
}

}  // namespace

ImageRotation::ImageRotation(const CameraModel& left)
    : camera_(left),
      tracker_(left, options_),
      detection_level_(DetectionLevel(left, HalfSize(options_.detector))),
      detector_(detection_level_ == 0 ? options_.detector : HalfSize(options_.detector),
                options_.klt),
      tracks_(kNumTracks),
      first_(kNumTracks) {}

void ImageRotation::Begin(const ImagePyramid& left) {
  num_begun_ = num_followed_ = 0;
  for (Track& track : tracks_)
    track.id = LandmarkId{};
  const int level = std::min(detection_level_, left.num_levels() - 1);
  for (const Vector2d& px :
       detector_.Detect(left.image(level), left.level(level), {}, kNumTracks)) {
    const auto slot = static_cast<std::size_t>(num_begun_);
    if (!tracker_.Begin(left, (1 << level) * px, tracks_[slot])) continue;
    tracks_[slot].id = LandmarkId{num_begun_++};
    first_[slot] = tracks_[slot].Bearing();
  }
}

bool ImageRotation::BeginAgain() {
  if (num_followed_ < kEnoughLeft) return false;
  for (std::size_t slot = 0; slot < tracks_.size(); ++slot) {
    if (tracks_[slot].id.IsValid()) first_[slot] = tracks_[slot].Bearing();
  }
  num_begun_ = num_followed_;
  return true;
}

double ImageRotation::Follow(const PyramidPair& left) {
  const TrackingSummary summary = tracker_.Advance(left.previous, left.now, SE3(), tracks_);
  num_followed_ = summary.num_tracked;
  return num_begun_ == 0 ? 0 : static_cast<double>(num_followed_) / num_begun_;
}

std::optional<TwoViewRotation> ImageRotation::Estimate() const {
  std::vector<BearingPair> pairs;
  for (std::size_t slot = 0; slot < tracks_.size(); ++slot) {
    if (tracks_[slot].id.IsValid()) pairs.push_back({first_[slot], tracks_[slot].Bearing()});
  }
  return EstimateTwoViewRotation(pairs, kSigma_px / camera_.mean_focal_px());
}

}  // namespace facet
