// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/wide_stereo_match.h"

#include <algorithm>

#include "facet/frontend/feature_detector.h"
#include "facet/frontend/frontend_options.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/stereo_matcher.h"
#include "facet/frontend/temporal_tracker.h"

namespace facet {
namespace {

// Cameras are swapped: so many matches of all pairs the other way round, and so much more often.
constexpr std::size_t kManySwapped = 80, kTimesMore = 5;

}  // namespace

bool AreSwapped(std::size_t num_matches, std::size_t num_exchanged) {
  return num_exchanged >= std::max(kManySwapped, kTimesMore * num_matches);
}

std::vector<StereoRays> MatchWidely(const StereoRig& rig,
                                    const cv::Mat& left,
                                    const cv::Mat& right,
                                    double gate_px) {
  FrontendOptions options;
  options.stereo.max_epipolar_px = gate_px;
  ImagePyramid left_pyramid, right_pyramid;
  left_pyramid.Build(left, options.klt.num_levels);
  right_pyramid.Build(right, options.klt.num_levels);
  const TemporalTracker tracker(rig.cameras[0], options);
  StereoMatcher matcher(rig, options);
  FeatureDetector detector(options.detector, options.klt);
  std::vector<StereoRays> matches;
  for (const Vector2d& px :
       detector.Detect(left, left_pyramid.level(0), {}, options.max_features)) {
    Track track;
    if (!tracker.Begin(left_pyramid, px, track)) continue;
    const auto match = matcher.Match(track, left_pyramid, right_pyramid);
    if (!match) continue;
    const auto bearing = rig.cameras[1].Unproject(match->px);
    if (bearing) matches.push_back({track.ray.bearing, *bearing});
  }
  return matches;
}

}  // namespace facet
