// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/disparity_watch.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facet {
namespace {

// Medians of fewer tracks are those of one thing.
constexpr int kLeastTracks = 25;
// A knock of a degree leaves so few, of things that are near.
constexpr int kLeastTracksInDoubt = 10;
// One wrong match among new tracks is no reason to leave them out.
constexpr int kLeastToScatter = 5;
// Beyond what keyframes of recordings, fast flights and drawn calibrations have; a knock of a tenth
// of a degree is more (docs/notebook/faults.md).
constexpr double kLargestChange_px = 0.7;
constexpr double kLargestSpread_px = 0.6;
constexpr double kAdaptation = 0.1;  // of the usual shift, per keyframe
// Right images of another moment have shifts that change as the body's rotation does.
constexpr std::size_t kNumInRow = 3;
constexpr Duration kStretch{1'000'000'000}, kLongestBreak{2'000'000'000};
constexpr double kLargestDisagreement_px = 0.4;  // of those in a row
constexpr double kLargestDisagreement = 0.05;    // of their shift
// Landmarks of the window, after the calibration has changed.
constexpr Duration kSettles{3'000'000'000};
// If they do not agree, the depths may be what is wrong, and only right images mend them.
constexpr int kPassAfterDisagreement = 12;

}  // namespace

void DisparityWatch::Forget(Timestamp t) {
  changed_ = t;
  usual_angle_ = 0;
  contradicting_.clear();
  num_to_pass_ = 0;
}

bool DisparityWatch::AreBelieved(const DisparityShift& shift) {
  return shift.num < kLeastToScatter || 2 * shift.num_agreeing >= shift.num;
}

DisparityWatch::Verdict DisparityWatch::Add(Timestamp t,
                                            const DisparityShift& shift,
                                            bool in_doubt) {
  if (changed_ && t - *changed_ < kSettles) return Verdict::kAgrees;
  if (shift.num < (in_doubt ? kLeastTracksInDoubt : kLeastTracks) ||
      focal_px_ * shift.spread > kLargestSpread_px)
    return in_doubt && !AreBelieved(shift) ? Verdict::kScatters : Verdict::kAgrees;
  const double change = shift.angle - usual_angle_;
  if (focal_px_ * std::abs(change) < kLargestChange_px) {
    usual_angle_ += kAdaptation * change;
    contradicting_.clear();
    num_to_pass_ = 0;
    return Verdict::kAgrees;
  }
  if (num_to_pass_ > 0 && !in_doubt) {
    --num_to_pass_;
    return Verdict::kAgrees;
  }
  if (!contradicting_.empty() && t - last_ > kLongestBreak) contradicting_.clear();
  if (contradicting_.empty()) begin_ = t;
  last_ = t;
  contradicting_.push_back(change);
  const auto [least, largest] = std::ranges::minmax(contradicting_);
  if (focal_px_ * (largest - least) >
      std::max(kLargestDisagreement_px, kLargestDisagreement * focal_px_ * std::abs(change))) {
    contradicting_.clear();
    if (in_doubt) return Verdict::kContradicts;
    num_to_pass_ = kPassAfterDisagreement;
    return Verdict::kAgrees;
  }
  if (contradicting_.size() < kNumInRow || t - begin_ < kStretch) return Verdict::kContradicts;
  const double sum = std::accumulate(contradicting_.begin(), contradicting_.end(), 0.0);
  turn_ = sum / static_cast<double>(contradicting_.size());
  contradicting_.clear();
  return Verdict::kTurned;
}

}  // namespace facet
