// SPDX-License-Identifier: BSD-2-Clause
// Finds the samples of an IMU that cannot be what the body did: glitches of the bus, values at the
// end of the sensor's range, a sensor that repeats itself.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <limits>
#include <optional>
#include <vector>

#include "facet/imu/imu_types.h"
#include "facet/imu/stuck_axis.h"

namespace facet {

/// What was found since the beginning.
struct ImuScreenCounts {
  int num_cut = 0;        ///< samples that contradict the ones before and after them
  int num_saturated = 0;  ///< samples at the end of the sensor's range
  int num_repeated = 0;   ///< samples of which both sensors, or one or an axis for long, repeat
};

/// Median size of the last two hundred changes from sample to sample. Not thread-safe.
class UsualChange {
 public:
  void Add(double change);
  /// Zero while it is not known.
  double value() const { return value_; }

 private:
  static constexpr std::size_t kNumKept = 200;
  static constexpr std::size_t kNumBetweenUpdates = 20;

  std::array<double, kNumKept> changes_{};
  std::size_t num_ = 0;
  double value_ = 0;
};

/// One axis of a sensor. Clipped values stand still where the axis has never been further out: four
/// equal values in a row that are reached at speed, not by slowing down, nor by a jump, which is a
/// glitch. Not thread-safe.
class SaturationWatch {
 public:
  /// No sensor ends below `least`; `jump`: from one sample to the next, beyond all motion.
  SaturationWatch(double least, double jump) : least_(least), jump_(jump) {}

  /// For how many samples the axis has now stood at the end of its range; 0: it does not.
  int Add(double x, double usual_change);

  /// The end of the range, as far as it is known; infinite while it is not.
  double limit() const { return limit_; }

 private:
  double least_, jump_;
  double largest_ = 0;
  double limit_ = std::numeric_limits<double>::infinity();
  double previous_ = 0;
  double change_into_run_ = 0;  // from the sample before the newest run of equal values
  int run_ = 0;                 // length of that run
  int num_at_limit_ = 0;
};

/// Not thread-safe. Judges by the samples alone, so that a sample is judged when the next one has
/// come, and a jump that lasts when five samples agree on it that are not the same one digit by
/// digit. Clean recordings pass unchanged.
class ImuScreen {
 public:
  /// Takes the next sample, in order of time. Appends to `samples` what is believed, which may be
  /// nothing yet, and takes from its end what the new sample shows to have been a glitch.
  void Add(const ImuSample& sample, std::deque<ImuSample>& samples);

  const ImuScreenCounts& counts() const { return counts_; }

 private:
  void DoubtSaturated(ImuSample& sample);
  void DoubtRepeated(ImuSample& sample);
  void DoubtFrozenSensor(ImuSample& sample);
  void DoubtStuckAxes(ImuSample& sample);
  void Accept(const ImuSample& sample, std::deque<ImuSample>& samples);
  double TimeToNext(const ImuSample& accepted, const ImuSample& sample) const;
  bool IsGyroJump(const ImuSample& from, const ImuSample& to, double dt_s) const;
  bool IsJump(const ImuSample& from, const ImuSample& to, double dt_s) const;
  /// The last of `samples`, of which there are three or more.
  bool IsSpike(const std::deque<ImuSample>& samples, const ImuSample& after) const;
  /// Where it has jumped away from what was believed, it repeats the sample held back before it.
  bool StandsStill(const ImuSample& believed, const ImuSample& sample) const;

  /// Distance between two samples of either sensor.
  UsualChange gyro_change_, accel_change_;
  static SaturationWatch GyroWatch() { return {kLeastGyroRange, kGyroJump * kShortestStep_s}; }
  static SaturationWatch AccelWatch() { return {kLeastAccelRange, kAccelJump * kShortestStep_s}; }
  std::array<SaturationWatch, 6> watches_{
      GyroWatch(), GyroWatch(), GyroWatch(), AccelWatch(), AccelWatch(), AccelWatch()};
  std::array<int, 6> num_doubted_{};  // samples of the present stay at the end of the range
  std::optional<ImuSample> newest_;   // whether it was believed or not
  int num_repeats_ = 0;               // of the newest sample
  /// A sensor that has stood still, the other one not.
  struct Stay {
    int num_repeats = 0, num_doubted = 0;
    double duration_s = 0;
  };
  Stay gyro_stay_, accel_stay_;
  std::array<StuckAxis, 6> stuck_;
  std::array<int, 6> num_doubted_stuck_{};  // samples of the present stay of an axis
  std::vector<ImuSample> held_back_;
  std::size_t num_accepted_ = 0;
  ImuScreenCounts counts_;

  static constexpr double kLeastGyroRange = 0.3;    // rad/s
  static constexpr double kLeastAccelRange = 12.0;  // m/s^2
  // Faster changes are glitches until samples confirm them: 2.5 rad/s and 40 m/s^2 from one sample
  // to the next at 200 Hz. Flights that are called aggressive reach a tenth of it.
  static constexpr double kGyroJump = 500;    // rad/s^2
  static constexpr double kAccelJump = 8000;  // m/s^3
  static constexpr double kShortestStep_s = 0.005;
};

}  // namespace facet
