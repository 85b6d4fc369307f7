// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/image_pairer.h"

#include <cstdlib>
#include <utility>

namespace facet {
namespace robot {

namespace {

// A partner that is later than that does not come: a left image that waited longer would be too old
// for the odometry. And of one camera at most so many wait.
constexpr std::int64_t kMaxWait_ns = 250'000'000;
constexpr std::size_t kMaxWaiting = 10;

}  // namespace

std::vector<ImagePair> ImagePairer::Add(int camera, ReceivedImage image) {
  std::vector<ImagePair> pairs;
  const auto side = static_cast<std::size_t>(camera);
  if (last_ns_[side] && image.t_ns <= *last_ns_[side]) {
    ++counts_.repeated;
    return pairs;
  }
  last_ns_[side] = image.t_ns;
  waiting_[side].push_back(std::move(image));
  while (!waiting_[0].empty() && IsSettled())
    Settle(pairs);
  while (waiting_[1].size() > kMaxWaiting) {
    waiting_[1].pop_front();
    ++counts_.lone_right;
  }
  return pairs;
}

/// Whether nothing that could still come would change the partner of the first left image.
bool ImagePairer::IsSettled() const {
  const auto& right = waiting_[1];
  return waiting_[0].size() > kMaxWaiting ||
         waiting_[0].back().t_ns - waiting_[0].front().t_ns > kMaxWait_ns ||
         (!right.empty() && right.back().t_ns >= waiting_[0].front().t_ns);
}

void ImagePairer::Settle(std::vector<ImagePair>& pairs) {
  auto& right = waiting_[1];
  ImagePair pair{std::move(waiting_[0].front()), std::nullopt};
  waiting_[0].pop_front();
  const std::int64_t t_ns = pair.left.t_ns;
  const auto distance = [&](const ReceivedImage& image) { return std::abs(image.t_ns - t_ns); };
  const auto skip = [&] {
    right.pop_front();
    ++counts_.lone_right;
  };
  while (!right.empty() && t_ns - right.front().t_ns > tolerance_ns_)
    skip();
  while (right.size() > 1 && distance(right[1]) < distance(right[0]))
    skip();
  if (!right.empty() && distance(right.front()) <= tolerance_ns_) {
    pair.right = std::move(right.front());
    right.pop_front();
    has_pair_ = true;
  } else {
    ++counts_.lone_left;
  }
  if (has_pair_) pairs.push_back(std::move(pair));
}

}  // namespace robot
}  // namespace facet
