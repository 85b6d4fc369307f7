// SPDX-License-Identifier: BSD-2-Clause
// Left and right images of one moment, from two live streams.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "facet/facet.h"

namespace facet {
namespace robot {

/// An image as it came, and what keeps its bytes alive.
struct ReceivedImage {
  std::int64_t t_ns = 0;
  api::EncodedImage image;
  std::shared_ptr<const void> owner;
};

struct ImagePair {
  ReceivedImage left;
  std::optional<ReceivedImage> right;  ///< empty: it has not come
};

/// Pairs each left image with the nearest right one within the tolerance, as `facet run` does. A
/// left image without one comes out alone as soon as no partner can come any more, but for those
/// before the first pair. Stamps of one camera that do not rise are left out. Not thread-safe.
class ImagePairer {
 public:
  struct Counts {
    std::int64_t lone_left = 0, lone_right = 0;  ///< without a partner
    std::int64_t repeated = 0;                   ///< whose stamps did not rise
  };

  explicit ImagePairer(std::int64_t tolerance_ns) : tolerance_ns_(tolerance_ns) {}

  /// The pairs that are known with this image, oldest first. `camera`: 0 left, 1 right.
  std::vector<ImagePair> Add(int camera, ReceivedImage image);

  const Counts& counts() const { return counts_; }

 private:
  bool IsSettled() const;
  void Settle(std::vector<ImagePair>& pairs);

  std::int64_t tolerance_ns_;
  std::array<std::deque<ReceivedImage>, 2> waiting_;
  std::array<std::optional<std::int64_t>, 2> last_ns_;
  bool has_pair_ = false;
  Counts counts_;
};

}  // namespace robot
}  // namespace facet
