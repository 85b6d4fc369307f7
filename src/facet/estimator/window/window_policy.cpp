// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_policy.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "facet/base/median.h"

namespace facet {

namespace {

bool Sees(const WindowLandmark& landmark, int frame) {
  return std::any_of(landmark.observations.begin(),
                     landmark.observations.end(),
                     [&](const WindowObservation& o) { return o.frame == frame; });
}

// Share of the landmarks seen in `frame` that the newest frame sees as well.
std::vector<double> CovisibleShares(const SlidingWindow& window) {
  const int newest = static_cast<int>(window.frames.size()) - 1;
  std::vector<double> seen(window.frames.size(), 0), shared(window.frames.size(), 0);
  for (const WindowLandmark& landmark : window.landmarks()) {
    const bool in_newest = Sees(landmark, newest);
    for (const WindowObservation& o : landmark.observations) {
      seen[o.frame] += 1;
      if (in_newest) shared[o.frame] += 1;
    }
  }
  for (std::size_t i = 0; i < seen.size(); ++i)
    shared[i] /= std::max(seen[i], 1.0);
  return shared;
}

// Landmarks that leave with the dropped frames: hosted there, or no longer tracked.
void DropLandmarks(const SlidingWindow& window, MarginalizationPlan& plan) {
  const int newest = static_cast<int>(window.frames.size()) - 1;
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    const WindowLandmark& landmark = window.landmarks()[l];
    const bool touched =
        std::any_of(landmark.observations.begin(),
                    landmark.observations.end(),
                    [&](const WindowObservation& o) { return plan.drop_frame[o.frame]; });
    if (!touched || !landmark.has_depth) continue;
    const bool lost = landmark.observations.back().frame != newest;
    if (lost || plan.drop_frame[landmark.host]) plan.drop_landmark[l] = 1;
  }
}

}  // namespace

int MostRedundantFrame(const SlidingWindow& window, int first, int last, double covisible_share) {
  const std::vector<double> shares = CovisibleShares(window);
  for (int i = first; i <= last; ++i) {
    if (shares[i] < covisible_share) return i;
  }
  // Far from the newest frame and close to the others: keeps a few wide baselines and many short
  // ones (Engel et al., DSO, section 3.1).
  const auto distance = [&](int a, int b) {
    return (window.frames[a].x.T_WB.p - window.frames[b].x.T_WB.p).norm();
  };
  const int newest = static_cast<int>(window.frames.size()) - 1;
  int best = first;
  double best_score = -1;
  for (int i = first; i <= last; ++i) {
    double crowd = 0;
    for (int k = first; k <= last; ++k) {
      if (k != i) crowd += 1.0 / (distance(i, k) + 1e-5);
    }
    const double score = std::sqrt(distance(i, newest)) * crowd;
    if (score > best_score) {
      best_score = score;
      best = i;
    }
  }
  return best;
}

bool IsDuplicate(const SlidingWindow& window, int frame) {
  constexpr double kMaxParallax = 5e-3;  // rad; about two pixels
  constexpr double kMinShared = 0.8;
  const int num_frames = static_cast<int>(window.frames.size());
  std::vector<double> inverse_distances;
  std::vector<int> shared(window.frames.size(), 0);
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.has_depth || !Sees(landmark, frame)) continue;
    inverse_distances.push_back(landmark.inverse_distance);
    for (const WindowObservation& o : landmark.observations)
      ++shared[o.frame];
  }
  const std::optional<double> median = Median(inverse_distances);
  if (!median) return true;
  for (int i = 0; i < num_frames; ++i) {
    const double distance = (window.frames[i].x.T_WB.p - window.frames[frame].x.T_WB.p).norm();
    if (i != frame && distance * *median < kMaxParallax &&
        shared[i] > kMinShared * static_cast<double>(inverse_distances.size())) {
      return true;
    }
  }
  return false;
}

MarginalizationPlan PlanMarginalization(const SlidingWindow& window, const WindowOptions& options) {
  MarginalizationPlan plan(window);
  const int num_frames = static_cast<int>(window.frames.size());

  int num_full = 0;
  for (const WindowFrame& frame : window.frames)
    num_full += frame.has_motion;
  int last_pose_frame = -1;
  int num_pose = 0;
  for (int i = 0; i < num_frames; ++i) {
    if (window.frames[i].has_motion) {
      if (num_full <= options.max_full_keyframes) break;
      --num_full;
      if (window.frames[i].is_keyframe) {
        plan.drop_motion[i] = 1;
      } else {
        plan.drop_frame[i] = 1;
      }
    }
    num_pose += !plan.drop_frame[i];
    last_pose_frame = i;
  }
  // One at a time, so that the choice sees the others that already go.
  if (num_pose > options.max_pose_keyframes) {
    const int victim = MostRedundantFrame(window, 0, last_pose_frame, options.covisible_share);
    plan.drop_frame[victim] = 1;
  }
  DropLandmarks(window, plan);
  return plan;
}

}  // namespace facet
