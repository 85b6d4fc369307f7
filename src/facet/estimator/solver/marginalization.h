// SPDX-License-Identifier: BSD-2-Clause
// Turns what leaves the window into a quadratic prior on what stays (docs/math.md, section 5).
#pragma once

#include <vector>

#include "facet/estimator/factors/vision_factor.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// What leaves. Sizes: one flag per frame, landmark and plane.
struct MarginalizationPlan {
  std::vector<char> drop_frame;     ///< pose (and motion, if any) leave
  std::vector<char> drop_motion;    ///< velocity and biases leave, the pose stays
  std::vector<char> drop_landmark;  ///< leaves with all its observations and plane rows
  std::vector<char> drop_plane;     ///< leaves; rows and sightings of what stays go with it

  explicit MarginalizationPlan(const SlidingWindow& window)
      : drop_frame(window.frames.size(), 0),
        drop_motion(window.frames.size(), 0),
        drop_landmark(window.landmarks().size(), 0),
        drop_plane(window.planes.size(), 0) {}

  bool IsEmpty() const;
};

/// Carries out the plan. Every factor that touches a leaving variable is used once, here, and
/// removed: the IMU links of leaving motions, all observations of leaving landmarks, the relations
/// of leaving planes, what leaving frames have sighted, the old prior. A landmark that stays but
/// was seen in a leaving frame loses that one observation. Variables that the new prior touches are
/// frozen at the present estimate, unless they already are.
void Marginalize(const MarginalizationPlan& plan,
                 const StereoRig& rig,
                 const RobustOptions& robust,
                 SlidingWindow& window);

}  // namespace facet
