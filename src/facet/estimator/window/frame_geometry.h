// SPDX-License-Identifier: BSD-2-Clause
// Where the cameras of all frames are, as everything that looks at landmarks needs it.
#pragma once

#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/estimator/window/window_frame.h"

namespace facet {

/// Reuse one object: it keeps its storage. Not thread-safe.
class FrameGeometry {
 public:
  struct Pose {
    Matrix3d R_BW;
    Vector3d p_WB;
    Matrix3d R_WC0;
    Vector3d p_WC0;
    Matrix3d R_CW[2];  ///< of the left and the right camera
    Vector3d p_WC[2];
  };

  explicit FrameGeometry(const StereoRig& rig);

  /// Takes the current estimates (and the frozen ones, for the Jacobians) of all frames.
  void Update(const std::vector<WindowFrame>& frames);

  const Pose& current(int frame) const { return current_[frame]; }
  const Pose& frozen(int frame) const { return frozen_[frame]; }

  Matrix3d R_CB[2];
  Vector3d p_BC[2];

 private:
  std::vector<Pose> current_;
  std::vector<Pose> frozen_;
};

}  // namespace facet
