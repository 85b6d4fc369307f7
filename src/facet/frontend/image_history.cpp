// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/image_history.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace facet {

namespace {

constexpr std::uint64_t kFactor = 0x9E3779B97F4A7C15;  // odd, its bits without a pattern
constexpr std::size_t kWord = sizeof(std::uint64_t);

std::uint64_t WordAt(const std::uint8_t* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, kWord);
  return word;
}

// A word moves all bits above its lowest one; the turn brings these down for the next.
std::uint64_t Mix(std::uint64_t sum, std::uint64_t word) {
  return std::rotl((sum ^ word) * kFactor, 31);
}

}  // namespace

std::uint64_t Fingerprint(const cv::Mat& image) {
  const std::size_t row_bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
  // Four sums do not wait for each other.
  std::array<std::uint64_t, 4> sums{1, 2, 3, 4};
  for (int row = 0; row < image.rows; ++row) {
    const std::uint8_t* bytes = image.ptr(row);
    std::size_t i = 0, lane = 0;
    for (; i + sums.size() * kWord <= row_bytes; i += sums.size() * kWord) {
      for (std::size_t k = 0; k < sums.size(); ++k)
        sums[k] = Mix(sums[k], WordAt(bytes + i + k * kWord));
    }
    for (; i + kWord <= row_bytes; i += kWord, ++lane)
      sums[lane] = Mix(sums[lane], WordAt(bytes + i));
    std::uint64_t rest = 0;
    std::memcpy(&rest, bytes + i, row_bytes - i);
    sums[lane] = Mix(sums[lane], rest);
  }
  std::uint64_t all = Mix(static_cast<std::uint64_t>(image.rows), row_bytes);
  for (const std::uint64_t sum : sums)
    all = Mix(all, sum);
  return all;
}

bool ImageHistory::Add(const cv::Mat& image, const RepeatedImage::Motion& motion) {
  moved_.T_prev_now = moved_.T_prev_now * motion.T_prev_now;
  moved_.mean_inverse_distance = motion.mean_inverse_distance;
  moved_.rotation_slack += motion.rotation_slack;
  if (image.empty()) return false;
  const std::uint64_t fingerprint = Fingerprint(image);
  const auto before = std::ranges::find(seen_, fingerprint, &Seen::fingerprint);
  if (before == seen_.end()) {
    seen_.push_back({fingerprint, moved_});
    if (seen_.size() > kNumKept) seen_.pop_front();
    return false;
  }
  RepeatedImage::Motion since = moved_;
  since.T_prev_now = before->moved.T_prev_now.Inverse() * moved_.T_prev_now;
  since.rotation_slack -= before->moved.rotation_slack;
  return MustHaveChanged(since, focal_px_);
}

}  // namespace facet
