// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/stereo_pairer.h"

#include <algorithm>
#include <utility>

namespace facet {
namespace {

// How long an image waits for its partner; in a bag messages come late, but not that late.
constexpr Duration kLongestWait{2000000000};
constexpr std::size_t kMostBytes = 256 << 20;
constexpr std::size_t kBytesBeside = 1024;  // of an image besides its data

}  // namespace

void StereoPairer::Add(int camera,
                       Timestamp t,
                       std::shared_ptr<const EncodedImage> image,
                       Timestamp received,
                       std::size_t num_bytes) {
  num_bytes += kBytesBeside;
  newest_received_ = std::max(newest_received_, received);
  if (last_[camera] && t <= *last_[camera]) {
    ++(t == *last_[camera] ? left_out_.num_repeated : left_out_.num_backward);
    return;
  }
  last_[camera] = t;
  waiting_[camera].push_back({t, received, std::move(image), num_bytes});
  num_bytes_ += num_bytes;
  // Right images without end and without a left one.
  while (waiting_[0].empty() && IsFull()) {
    Drop(1);
    ++num_lone_right_;
  }
}

bool StereoPairer::IsFull() const {
  return num_bytes_ > kMostBytes;
}

void StereoPairer::End() {
  is_ended_ = true;
}

void StereoPairer::Drop(int camera) {
  num_bytes_ -= waiting_[camera].front().num_bytes;
  waiting_[camera].pop_front();
}

/// Whether nothing that could still come would change the partner of the first left image.
bool StereoPairer::MustSettle() const {
  const Waiting& left = waiting_[0].front();
  const auto& right = waiting_[1];
  return is_ended_ || (!right.empty() && right.back().t >= left.t) ||
         newest_received_ - left.received > kLongestWait || IsFull();
}

void StereoPairer::Settle() {
  auto& right = waiting_[1];
  const Waiting left = std::move(waiting_[0].front());
  num_bytes_ -= left.num_bytes;
  waiting_[0].pop_front();
  const auto skip = [&] {
    Drop(1);
    ++num_lone_right_;
  };
  while (!right.empty() && left.t - right.front().t > tolerance_)
    skip();
  const auto distance = [&](const Waiting& image) {
    return std::max(image.t - left.t, left.t - image.t);
  };
  while (right.size() > 1 && distance(right[1]) < distance(right[0]))
    skip();
  RecordedFrame frame{left.t, left.t, left.image, nullptr};
  if (!right.empty() && distance(right.front()) <= tolerance_) {
    frame.right = right.front().image;
    frame.t_right = right.front().t;
    Drop(1);
    ++num_pairs_;
  } else if (num_pairs_ == 0) {
    ++num_before_;
    return;
  } else {
    ++num_mono_;
  }
  front_ = std::move(frame);
}

const std::optional<RecordedFrame>& StereoPairer::Front() {
  while (!front_ && !waiting_[0].empty() && MustSettle())
    Settle();
  return front_;
}

std::vector<std::string> StereoPairer::Warnings() const {
  std::vector<std::string> warnings;
  const auto warn = [&](int num, const char* text) {
    if (num > 0) warnings.push_back(std::to_string(num) + text);
  };
  warn(num_before_, " left images before the first stereo pair are not used");
  warn(num_mono_, " left images have no right image");
  warn(num_lone_right_, " right images have no left image");
  warn(left_out_.num_repeated + left_out_.num_backward,
       " images repeat a stamp or come too late and were left out");
  return warnings;
}

}  // namespace facet
