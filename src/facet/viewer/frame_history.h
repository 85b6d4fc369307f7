// SPDX-License-Identifier: BSD-2-Clause
// The frames of a live run, for clients that come late.
#pragma once

#include <cstddef>
#include <vector>

#include "facet/io/result_writer.h"

namespace facet {

/// Holds a bounded number of frames: when it is full, every second one of the older half goes, so
/// that a run of any length is there from its beginning, the past more coarsely. Not thread-safe.
class FrameHistory {
 public:
  explicit FrameHistory(std::size_t max_frames = 24576) : max_frames_(max_frames) {}

  void Add(FrameRecord frame);

  const std::vector<FrameRecord>& frames() const { return frames_; }
  int num_thinned() const { return num_thinned_; }  ///< how often frames have moved

 private:
  std::size_t max_frames_;
  std::vector<FrameRecord> frames_;
  int num_thinned_ = 0;
};

}  // namespace facet
