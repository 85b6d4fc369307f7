// SPDX-License-Identifier: BSD-2-Clause
#include "align_stereo.h"

#include <cstdio>
#include <vector>

#include "facet/geometry/angles.h"
#include "facet/io/errors.h"
#include "facet/plausibility/stereo_turn.h"

namespace facet {
namespace {

// What stands too near or has no texture in one pair may be gone in the next.
constexpr int kNumPairs = 4;
constexpr double kBetweenPairs_s = 0.5, kLongest_s = 5;

std::vector<StereoRays> MatchPairs(AslDataset& dataset, double start_s) {
  std::vector<StereoRays> matches;
  const std::vector<FrameEntry>& frames = dataset.frames();
  double next_s = start_s;
  int num_pairs = 0;
  for (std::size_t i = 0; i < frames.size() && num_pairs < kNumPairs; ++i) {
    const double t_s = ToSeconds(frames[i].t - frames.front().t);
    if (t_s < next_s || !frames[i].HasRight()) continue;
    if (t_s > start_s + kLongest_s) break;
    next_s = t_s + kBetweenPairs_s;
    try {
      cv::Mat left, right;
      dataset.ReadPair(i, left, right);
      if (right.empty()) continue;
      const std::vector<StereoRays> found = MatchWidely(dataset.rig(), left, right);
      matches.insert(matches.end(), found.begin(), found.end());
      ++num_pairs;
    } catch (const InputError&) {
      continue;  // the run itself will report it
    }
  }
  return matches;
}

}  // namespace

AlignedRig AlignStereo(AslDataset& dataset, double start_s) {
  AlignedRig aligned{dataset.rig(), {}};
  const StereoTurn turn = EstimateStereoTurn(dataset.rig(), MatchPairs(dataset, start_s));
  if (!turn.IsClear()) return aligned;
  aligned.rig = TurnedRig(dataset.rig(), turn.omega);
  const Vector3d degrees = turn.omega / kDegree;
  char text[320];
  std::snprintf(text,
                sizeof(text),
                "the right camera is turned by %.2f, %.2f, %.2f deg about its x, y, z axes against "
                "its calibration: matches were %.1f px beside their epipolar lines (median of %d) "
                "and are %.1f px with this correction, which the run begins with; calibrate again",
                degrees.x(),
                degrees.y(),
                degrees.z(),
                turn.before_px,
                turn.num_matches,
                turn.after_px);
  aligned.warning = text;
  return aligned;
}

}  // namespace facet
