// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_values.h"

namespace facet {

void WindowValues::Save(const SlidingWindow& window) {
  x_.clear();
  lin_.clear();
  delta_.clear();
  for (const WindowFrame& frame : window.frames) {
    x_.push_back(frame.x);
    lin_.push_back(frame.lin);
    delta_.push_back(frame.delta);
  }
  planes_ = window.planes;
  if (window.calibration) calibration_ = window.calibration->delta();
  landmarks_.clear();
  for (const WindowLandmark& landmark : window.landmarks()) {
    landmarks_.emplace_back(landmark.bearing_H, landmark.inverse_distance);
  }
}

void WindowValues::Restore(SlidingWindow& window) const {
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    window.frames[i].x = x_[i];
    window.frames[i].lin = lin_[i];
    window.frames[i].delta = delta_[i];
  }
  window.planes = planes_;
  if (window.calibration) window.calibration->SetDelta(calibration_);
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    window.landmarks()[l].bearing_H = landmarks_[l].first;
    window.landmarks()[l].inverse_distance = landmarks_[l].second;
  }
}

}  // namespace facet
