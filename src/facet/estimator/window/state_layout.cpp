// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/state_layout.h"

namespace facet {

StateLayout MakeLayout(const SlidingWindow& window, CalibrationStep calibration_step) {
  const std::vector<WindowFrame>& frames = window.frames;
  StateLayout layout;
  const auto next = [&](Variable::Kind kind) {
    const int column = layout.dim;
    layout.dim += SizeOf(kind);
    return column;
  };
  for (std::size_t k = 0; k < window.planes.size(); ++k)
    layout.plane_column.push_back(next(Variable::Kind::kPlane));
  if (window.calibration && calibration_step == CalibrationStep::kFree)
    layout.calibration_column = next(Variable::Kind::kCalibration);
  for (std::size_t i = 0; i < frames.size(); ++i)
    layout.pose_column.push_back(next(Variable::Kind::kPose));
  layout.motion_column.assign(frames.size(), -1);
  if (!frames.empty() && frames.back().has_motion)
    layout.motion_column.back() = next(Variable::Kind::kMotion);
  layout.dense_dim = layout.dim;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    if (frames[i].has_motion) layout.motion_column[i] = next(Variable::Kind::kMotion);
  }
  return layout;
}

}  // namespace facet
