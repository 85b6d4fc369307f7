// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/frame_history.h"

#include <utility>

namespace facet {

void FrameHistory::Add(FrameRecord frame) {
  if (frames_.size() >= max_frames_) {
    const std::size_t half = frames_.size() / 2;
    std::size_t num_left = 0;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (i < half && i % 2 != 0) continue;
      if (num_left != i) frames_[num_left] = std::move(frames_[i]);
      ++num_left;
    }
    frames_.resize(num_left);
    ++num_thinned_;
  }
  frames_.push_back(std::move(frame));
}

}  // namespace facet
