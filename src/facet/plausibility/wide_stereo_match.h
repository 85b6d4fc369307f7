// SPDX-License-Identifier: BSD-2-Clause
// Matches of a stereo pair whose calibration is not trusted: a bump of 0.2 deg moves the right
// image by more than the gate of the front end, and cameras may be exchanged.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/stereo_turn.h"

namespace facet {

/// Matches corners of the left image with the right one, as far from the epipolar lines as
/// `gate_px`.
std::vector<StereoRays> MatchWidely(const StereoRig& rig,
                                    const cv::Mat& left,
                                    const cv::Mat& right,
                                    double gate_px = 5);

/// A pair with fewer matches may have its images exchanged; a hundred and more are usual.
inline constexpr std::size_t kFewStereoMatches = 20;

/// Whether left and right are exchanged, from the matches of some pairs as they are and, of those
/// pairs that have few, of their images exchanged.
bool AreSwapped(std::size_t num_matches, std::size_t num_exchanged);

}  // namespace facet
