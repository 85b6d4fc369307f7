// SPDX-License-Identifier: BSD-2-Clause
// The values of a window's variables, to come back to after a step that did not help.
#pragma once

#include <utility>
#include <vector>

#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Keeps its storage. Not thread-safe.
class WindowValues {
 public:
  void Save(const SlidingWindow& window);

  /// The window must have the frames, planes and landmarks that it had when its values were saved;
  /// observations and memberships stay as they are.
  void Restore(SlidingWindow& window) const;

 private:
  std::vector<NavState> x_, lin_;
  std::vector<Vector<15>> delta_;
  std::vector<WindowPlane> planes_;
  CalibrationVector calibration_ = CalibrationVector::Zero();
  std::vector<std::pair<Vector3d, double>> landmarks_;
};

}  // namespace facet
