// SPDX-License-Identifier: BSD-2-Clause
// Whether the world that the stereo pair measures is as large as the accelerometer says, and
// whether each axis of the accelerometer points where it should. A baseline or a focal length that
// is off makes the world too large or too small; to the images all sizes are the same, and an
// estimator that trusts its calibration gives way only slowly.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "facet/imu/imu_buffer.h"
#include "facet/plausibility/force_integral.h"
#include "facet/plausibility/robust_line.h"

namespace facet {

/// Not thread-safe.
class ScaleCheck {
 public:
  /// Size of the world by the stereo pair over its size by the accelerometer. Where motion is slow
  /// anywhere, the two bounds are far apart.
  using Scale = FactorBounds;

  enum class Finding {
    kNothing,
    kDoubt,           ///< off by more than a calibration is; once
    kRefusal,         ///< in the first minute: by so much that nothing good comes of it
    kAxesTheOtherWay  ///< in the first minute: axes of the accelerometer, see negated_axes()
  };

  /// `most_legs`: after so many nothing more is to be learnt.
  explicit ScaleCheck(int most_legs = 1000) : most_legs_(most_legs) {}

  /// By what share the gyroscope reads too much on each axis, from the next keyframe on.
  void SetGyroScale(const Vector3d& scale) { gyro_scale_ = scale; }

  /// The IMU from the end of the interval before.
  void AddImu(const ImuInterval& imu);

  /// The state of a keyframe at the end of the last interval, mostly as the images have it; only
  /// its stamp, its pose and the bias of the gyroscope are used.
  Finding AddKeyframe(const NavState& state);

  /// The accelerometer's bias changes faster than it can (estimator/bias_watch.h): what it says of
  /// the size meanwhile is no reason to refuse a calibration later, when the size is right.
  void DistrustAccelerometer() { is_accel_trusted_ = false; }

  /// The gyroscope turns as the images do, so that its axes need not be named before those of the
  /// accelerometer.
  void TrustGyroscope() { is_gyro_trusted_ = true; }

  /// Poses from before and after this are not to be compared.
  void Break();

  /// The same, and the size of the world is measured anew. What was said of the sensors stays.
  void BeginAnew();

  /// The same, and gravity may point elsewhere than before.
  void LoseOrientation();

  /// As BeginAnew, because the estimator has another calibration: the accelerometer is trusted
  /// again. States are left out for this long, in which the estimator's go to where they belong
  /// now.
  void WorldHasChanged(Duration settles = Duration{0});

  /// Nothing more is to be learnt.
  bool IsDone() const;

  /// Certainly off by more than any calibration that is worth a run.
  bool IsHopeless() const;

  /// As far as it is known; empty before there was enough motion to say anything.
  const std::optional<Scale>& scale() const { return scale_; }

  /// Axes of the accelerometer that certainly measure the opposite of what the images see: "x",
  /// "y", "z", several or none; reported somewhat later.
  const std::string& negated_axes() const { return negated_axes_; }

 private:
  /// One axis of what happens from one leg to the next: velocity = scale * force + gravity and bias
  /// of the accelerometer, times their factors.
  static constexpr int kNumConstants = 6;
  struct Row {
    double velocity = 0;
    Vector3d force_by_axis;  ///< by each axis of the accelerometer; the force is their sum
    Vector<kNumConstants> constants;
  };
  struct Leg {
    NavState begin;
    ForceIntegral imu;
  };

  void AddRows(const Leg& first, const Leg& second, const NavState& end);
  std::optional<Scale> Fit() const;
  std::string FindNegatedAxes() const;
  Finding Judge();

  int most_legs_;
  Vector3d gyro_scale_ = Vector3d::Zero();
  std::optional<Leg> first_, second_;  // between three keyframes; the second one is growing
  std::vector<Row> rows_;
  std::size_t num_rows_before_ = 0;     // from before the world changed, of another scale
  std::size_t num_rows_forgotten_ = 0;  // of another direction of gravity
  std::optional<Scale> scale_;
  std::string negated_axes_;
  int num_doubts_ = 0;  // in a row
  bool has_doubted_ = false, is_hopeless_ = false, was_right_ = false;
  bool is_accel_trusted_ = true, is_gyro_trusted_ = false;
  std::optional<Duration> settles_;  // from the next keyframe on
  Timestamp settled_at_{std::numeric_limits<std::int64_t>::min()};
};

/// What is wrong, in words that follow "warning: ".
std::string InWords(const ScaleCheck::Scale& scale);

/// What is wrong with these axes of the accelerometer (ScaleCheck::negated_axes) and what to do.
std::string NegatedAxesInWords(const std::string& axes);

}  // namespace facet
