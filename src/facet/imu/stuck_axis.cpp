// SPDX-License-Identifier: BSD-2-Clause
#include "facet/imu/stuck_axis.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

constexpr double kChance = 1e-15;
// As for a whole sensor (ImuScreen).
constexpr double kShortestStay_s = 0.05;
// Changes of the others, on average.
constexpr double kLeastDigits = 3;
// Of longer stays the axis learns nothing that is usual.
constexpr int kLongestToLearn = 20;
constexpr int kNumRemembered = 4000;

// So many of `num` samples repeat themselves: the largest probability that this leaves room for.
double LargestShare(int num_of_them, int num) {
  const double share = (num_of_them + 1.0) / (num + 2.0);
  return std::min(1.0, share + 3 * std::sqrt(share * (1 - share) / (num + 2.0)));
}

}  // namespace

int StuckAxis::Add(double dt_s, double change, const std::array<double, 2>& changes_of_others) {
  const bool repeats = change == 0;
  if (!repeats) {
    stay_ = 0;
    stay_s_ = sum_of_others_ = 0;
    num_others_repeat_ = {};
    digit_ = std::min(digit_, std::abs(change));
  } else {
    ++stay_;
    stay_s_ += dt_s;
    for (std::size_t i = 0; i < changes_of_others.size(); ++i) {
      num_others_repeat_[i] += changes_of_others[i] == 0 ? 1 : 0;
      sum_of_others_ += std::abs(changes_of_others[i]);
    }
  }
  const int num_stuck = stay_s_ >= kShortestStay_s && IsBeyondChance() ? stay_ : 0;
  if (stay_ <= kLongestToLearn) {
    ++num_samples_;
    num_repeats_ += repeats ? 1 : 0;
    if (num_samples_ == kNumRemembered) {
      num_samples_ /= 2;
      num_repeats_ /= 2;
    }
  }
  return num_stuck;
}

bool StuckAxis::IsBeyondChance() const {
  if (!(sum_of_others_ > 2 * stay_ * kLeastDigits * digit_)) return false;
  double share = LargestShare(num_repeats_, num_samples_);
  for (const int num : num_others_repeat_)
    share = std::max(share, LargestShare(num, stay_));
  return stay_ * std::log(share) < std::log(kChance);
}

}  // namespace facet
