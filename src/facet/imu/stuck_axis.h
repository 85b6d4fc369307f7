// SPDX-License-Identifier: BSD-2-Clause
// One axis of a sensor that repeats its value while the sensor's other two go on.
#pragma once

#include <array>
#include <limits>

namespace facet {

/// Coarse sensors repeat values by chance, those that are slower than their driver by rule: an axis
/// is stuck when, by how often it repeated itself before and the others do now, chance would make
/// so long a stay once in 10^15, and the others change by several digits, so that this is no rest.
/// Not thread-safe.
class StuckAxis {
 public:
  /// The next sample, `dt_s` after the one before: by how much its value, and those of the two
  /// others, differ from the sample before. Returns for how many samples the axis has been stuck;
  /// 0: it is not.
  int Add(double dt_s, double change, const std::array<double, 2>& changes_of_others);

 private:
  bool IsBeyondChance() const;

  // What is usual of this axis, in what is remembered.
  int num_samples_ = 0, num_repeats_ = 0;
  double digit_ = std::numeric_limits<double>::infinity();  // the smallest change of its value
  // The present stay.
  int stay_ = 0;
  double stay_s_ = 0;
  std::array<int, 2> num_others_repeat_{};
  double sum_of_others_ = 0;  // of their changes
};

}  // namespace facet
