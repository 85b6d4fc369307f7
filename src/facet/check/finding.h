// SPDX-License-Identifier: BSD-2-Clause
// What a check of a recording says. docs/check.md lists the names.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/base/types.h"
#include "facet/io/calibration_file.h"

namespace facet {

enum class Sureness { kLikely, kCertain };

struct Span {
  Timestamp from, to;  ///< camera clock
};

struct Finding {
  std::string name;
  Sureness sureness = Sureness::kCertain;
  std::string what;                         ///< a sentence with figures, without a full stop
  std::string advice;                       ///< what to do, the same
  std::optional<Span> when = std::nullopt;  ///< empty: the whole recording
};

/// What the recording does not tell.
struct Unchecked {
  std::string name;  ///< of the finding that there may be
  std::string why;
};

struct CheckReport {
  std::vector<Finding> findings;
  std::vector<Unchecked> unchecked;
  std::vector<std::string> measured;  ///< figures, whether they are good or not
  std::vector<std::string> notes;     ///< what the reader found odd
  /// What was looked at.
  Timestamp first_frame;
  int num_frames = 0, num_imu = 0, num_looked_at = 0;
  double duration_s = 0;
  /// Of the gyroscope, where the images tell it [rad/s].
  std::optional<Vector3d> gyro_bias;
  /// Units, axes and mount of the gyroscope do not fit the images: others need not use it.
  bool is_gyroscope_wrong = false;

  bool Has(const std::string& name) const;
  void Add(Finding finding) { findings.push_back(std::move(finding)); }
};

/// As printf.
[[gnu::format(printf, 1, 2)]] std::string Text(const char* format, ...);

/// The middle one, of the upper two if there are two; zero for none. Changes the order.
double MedianOf(std::vector<double>& values);
/// The one below which this share of them is.
double QuantileOf(std::vector<double>& values, double share);

}  // namespace facet
