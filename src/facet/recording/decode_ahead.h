// SPDX-License-Identifier: BSD-2-Clause
// Decodes the images of the next frames on threads of its own while the newest one is worked on.
// Decoding depends on nothing but the frame, so that results do not depend on the threads.
#pragma once

#include <memory>

#include "facet/camera/stereo_rig.h"
#include "facet/recording/frame_decoder.h"

namespace facet {

/// Call from one thread.
class DecodeAhead {
 public:
  /// `num_threads`: at least one.
  DecodeAhead(const StereoRig& rig, int num_threads);
  /// Does not wait for frames that no thread has begun with.
  ~DecodeAhead();
  DecodeAhead(const DecodeAhead&) = delete;
  DecodeAhead& operator=(const DecodeAhead&) = delete;

  /// So many frames may be under way: their images are what the memory is bounded by.
  int capacity() const { return capacity_; }
  int num_under_way() const { return num_under_way_; }

  /// CHECKs that fewer than capacity() frames are under way.
  void Add(const RecordedFrame& frame);

  /// The oldest frame under way, of which there must be one. The caller decodes instead of waiting,
  /// as long as there is something that no thread has begun with. The images that `frame` had serve
  /// again, unless they are shared.
  void Take(DecodedFrame& frame);

 private:
  class Pool;

  int capacity_;
  int num_under_way_ = 0;
  std::unique_ptr<Pool> pool_;
};

}  // namespace facet
