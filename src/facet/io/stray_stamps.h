// SPDX-License-Identifier: BSD-2-Clause
// Holds back what is stamped far ahead of its stream until the stream goes on from there: one
// damaged stamp would otherwise make everything behind it too late.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// Of images: two damaged ones in a row are chance enough, and few are held back.
inline constexpr std::size_t kImagesToConfirm = 3;
/// Of IMU samples: a tenth of a second of a usual sensor, as ImuBuffer has it.
inline constexpr std::size_t kSamplesToConfirm = 20;

/// For one stream of items that have a stamp `t`. Order within the stream is somebody else's
/// business: what comes late or twice is passed on. Not thread-safe.
template <class Item>
class StrayStamps {
 public:
  /// So many items after a step of more than a second show that the step is one of time.
  explicit StrayStamps(std::size_t num_to_confirm) : num_to_confirm_(num_to_confirm) {}

  /// Calls take(item) for what is part of the stream, in the order in which it came, and
  /// leave_out(item) for what is not.
  template <class Take, class LeaveOut>
  void Add(Item item, const Take& take, const LeaveOut& leave_out) {
    if (has_begun_ && item.t - newest_ <= kFar) {
      if (item.t > newest_) Discard(leave_out);
      Pass(std::move(item), take);
      return;
    }
    if (!waiting_.empty() && !IsNear(item.t)) {
      // At the beginning two agree on where the stream is.
      if (!has_begun_ && waiting_.size() > 1) {
        Release(take);
        return Add(std::move(item), take, leave_out);
      }
      Discard(leave_out);
    }
    waiting_.push_back(std::move(item));
    if (waiting_.size() >= num_to_confirm_) Release(take);
  }

  /// Nothing more comes. What still waits is the whole stream, or was never confirmed.
  template <class Take, class LeaveOut>
  void End(const Take& take, const LeaveOut& leave_out) {
    if (has_begun_) return Discard(leave_out);
    Release(take);
  }

 private:
  static constexpr Duration kFar{1'000'000'000};

  bool IsNear(Timestamp t) const {
    return t - waiting_.back().t <= kFar && waiting_.front().t - t <= kFar;
  }

  template <class Take>
  void Pass(Item item, const Take& take) {
    if (!has_begun_ || item.t > newest_) newest_ = item.t;
    has_begun_ = true;
    take(std::move(item));
  }

  template <class Take>
  void Release(const Take& take) {
    for (Item& item : std::exchange(waiting_, {}))
      Pass(std::move(item), take);
  }

  template <class LeaveOut>
  void Discard(const LeaveOut& leave_out) {
    for (Item& item : std::exchange(waiting_, {}))
      leave_out(std::move(item));
  }

  std::size_t num_to_confirm_;
  bool has_begun_ = false;
  Timestamp newest_;  // of what was passed on
  std::vector<Item> waiting_;
};

}  // namespace facet
