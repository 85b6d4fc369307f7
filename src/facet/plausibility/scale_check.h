// SPDX-License-Identifier: BSD-2-Clause
// Whether the world that the stereo pair measures is as large as the accelerometer says. A baseline
// or a focal length that is off makes the world too large or too small; to the images all sizes are
// the same, and an estimator that trusts its calibration gives way only slowly.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/imu/imu_buffer.h"
#include "facet/imu/preintegration.h"

namespace facet {

/// Not thread-safe.
class ScaleCheck {
 public:
  /// Size of the world by the stereo pair over its size by the accelerometer. Noise of the
  /// accelerometer draws the one estimate towards zero, noise of the poses the other one towards
  /// infinity: the truth is between them, where motion is slow anywhere.
  struct Scale {
    double low = 1, high = 1;
    double sigma = 0;  ///< of the one that is nearer to 1

    double value() const { return 0.5 * (low + high); }
    /// By at least so much, and for sure.
    bool IsOff(double least, double sigmas) const;
  };

  enum class Finding {
    kNothing,
    kDoubt,   ///< off by more than a calibration is; once
    kRefusal  ///< in the first minute: by so much that nothing good comes of it
  };

  /// The IMU from the end of the interval before.
  void AddImu(const ImuInterval& imu);

  /// The state of a keyframe at the end of the last interval, mostly as the images have it; only
  /// its pose and the bias of the gyroscope are used.
  Finding AddKeyframe(const NavState& state);

  /// Poses from before and after this are not to be compared.
  void Break();

  /// As far as it is known; empty before there was enough motion to say anything.
  const std::optional<Scale>& scale() const { return scale_; }

 private:
  /// One axis of what happens from one leg to the next: velocity = scale * force + gravity and bias
  /// of the accelerometer, times their factors.
  static constexpr int kNumConstants = 6;
  struct Row {
    double velocity = 0, force = 0;
    Vector<kNumConstants> constants;
  };
  struct Leg {
    NavState begin;
    ImuPreintegration imu;
  };

  void AddRows(const Leg& first, const Leg& second, const NavState& end);
  std::optional<Scale> Fit() const;
  struct Line {
    double slope = 0, sigma = 0;
  };
  std::optional<Line> FitLine(double Row::*x, double Row::*y) const;
  Finding Judge();

  std::optional<Leg> first_, second_;  // between three keyframes; the second one is growing
  std::vector<Row> rows_;
  std::optional<Scale> scale_;
  int num_doubts_ = 0;  // in a row
  bool has_doubted_ = false, is_hopeless_ = false;
};

/// What is wrong, in words that follow "warning: ".
std::string InWords(const ScaleCheck::Scale& scale);

}  // namespace facet
