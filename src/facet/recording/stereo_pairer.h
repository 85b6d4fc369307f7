// SPDX-License-Identifier: BSD-2-Clause
// Left and right images of one moment, from two streams of images.
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "facet/recording/recording.h"

namespace facet {

/// Pairs each left image with the nearest right one within the tolerance, as StereoDataset does. A
/// left image without one becomes a mono frame, once it is known that none comes; frames begin with
/// the first pair. Stamps of one camera that do not rise are left out and counted. Not thread-safe.
class StereoPairer {
 public:
  explicit StereoPairer(Duration tolerance = {}) : tolerance_(tolerance) {}

  /// `camera` is 0 or 1; `received` and `num_bytes` are what the limits of waiting are about.
  void Add(int camera,
           Timestamp t,
           std::shared_ptr<const EncodedImage> image,
           Timestamp received,
           std::size_t num_bytes);

  /// No more images come.
  void End();

  /// The next frame that is settled, if there is one.
  const std::optional<RecordedFrame>& Front();
  void Pop() { front_.reset(); }

  /// Whether more images wait than memory should hold.
  bool IsFull() const;

  std::vector<std::string> Warnings() const;
  const StampCounts& left_out() const { return left_out_; }

 private:
  struct Waiting {
    Timestamp t, received;
    std::shared_ptr<const EncodedImage> image;
    std::size_t num_bytes = 0;
  };

  bool MustSettle() const;
  void Settle();
  void Drop(int camera);

  Duration tolerance_;
  std::array<std::deque<Waiting>, 2> waiting_;
  std::array<std::optional<Timestamp>, 2> last_;
  Timestamp newest_received_;
  std::size_t num_bytes_ = 0;
  bool is_ended_ = false;
  std::optional<RecordedFrame> front_;
  int num_pairs_ = 0, num_before_ = 0, num_mono_ = 0, num_lone_right_ = 0;
  StampCounts left_out_;
};

}  // namespace facet
