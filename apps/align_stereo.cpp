// SPDX-License-Identifier: BSD-2-Clause
#include "align_stereo.h"

#include <optional>
#include <variant>
#include <vector>

#include "facet/io/errors.h"
#include "facet/plausibility/wide_stereo_match.h"
#include "facet/recording/frame_decoder.h"

namespace facet {
namespace {

// What stands too near or has no texture in one pair may be gone in the next.
constexpr int kNumPairs = 4;
constexpr double kBetweenPairs_s = 0.5, kLongest_s = 5;

struct PairMatches {
  std::vector<StereoRays> rays;
  std::size_t num_swapped = 0;  ///< matches with the images exchanged, of pairs with few otherwise
};

/// Empty at the end, or where the recording is damaged.
std::optional<RecordedFrame> NextFrame(Recording& recording) {
  try {
    while (auto event = recording.Next()) {
      if (const auto* frame = std::get_if<RecordedFrame>(&*event)) return *frame;
    }
  } catch (const InputError&) {
    return std::nullopt;  // the run itself will report it
  }
  return std::nullopt;
}

PairMatches MatchPairs(Recording& recording, double start_s) {
  const StereoRig& rig = recording.calibration()->rig;
  PairMatches matches;
  FrameDecoder decoder(rig);
  std::optional<Timestamp> first;
  double next_s = start_s;
  int num_pairs = 0;
  while (num_pairs < kNumPairs) {
    const std::optional<RecordedFrame> frame = NextFrame(recording);
    if (!frame) break;
    if (!first) first = frame->t;
    const double t_s = ToSeconds(frame->t - *first);
    if (t_s < next_s || !frame->HasRight()) continue;
    if (t_s > start_s + kLongest_s) break;
    next_s = t_s + kBetweenPairs_s;
    try {
      cv::Mat left, right;
      decoder.Decode(*frame, left, right);
      if (right.empty()) continue;
      const std::vector<StereoRays> found = MatchWidely(rig, left, right);
      matches.rays.insert(matches.rays.end(), found.begin(), found.end());
      if (found.size() < kFewStereoMatches)
        matches.num_swapped += MatchWidely(rig, right, left).size();
      ++num_pairs;
    } catch (const InputError&) {
      continue;  // the run itself will report it
    }
  }
  return matches;
}

std::string RefusalOf(const PairMatches& matches) {
  if (!AreSwapped(matches.rays.size(), matches.num_swapped)) return {};
  return "the cameras are swapped: of the first pairs " + std::to_string(matches.num_swapped) +
         " corners match when left and right images are exchanged, otherwise " +
         std::to_string(matches.rays.size()) +
         "; exchange cam0 and cam1, or the topics, or the calibrations";
}

}  // namespace

AlignedRig AlignStereo(Recording& recording, double start_s) {
  const StereoRig& rig = recording.calibration()->rig;
  AlignedRig aligned{rig, {}, {}};
  const PairMatches matches = MatchPairs(recording, start_s);
  recording.Rewind();
  aligned.refusal = RefusalOf(matches);
  const StereoTurn turn = EstimateStereoTurn(rig, matches.rays);
  if (!turn.IsClear()) return aligned;
  aligned.rig = TurnedRig(rig, turn.omega);
  aligned.warning =
      "the right camera is " + InWords(turn) + ", which the run begins with; calibrate again";
  return aligned;
}

}  // namespace facet
