// SPDX-License-Identifier: BSD-2-Clause
// Notices a calibration that cannot be right. The estimator goes on with one: swapped cameras leave
// it with one eye, a wrong time offset with an IMU that never fits. No single keyframe tells that
// from a hard scene, some seconds do.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "facet/base/types.h"
#include "facet/calibration/calibration_deviation.h"
#include "facet/pipeline/episodes.h"

namespace facet {

/// What one keyframe says about the calibration.
struct CalibrationEvidence {
  Timestamp t;
  int num_features = 0;           ///< in the left image
  std::optional<int> num_stereo;  ///< of them found in the right image; empty without that image
  std::optional<double> imu_error_sigma;               ///< see EstimatorResult
  std::vector<CalibrationDeviation> gross_deviations;  ///< that the estimator has found
};

/// Not thread-safe.
class CalibrationWatch {
 public:
  /// What is probably wrong and what to do: with the keyframe that completes a stretch in which
  /// three quarters agree on it, and again if it comes again after half a minute; and all that the
  /// estimator has found, whenever another part of the calibration is among it. Otherwise empty.
  std::string Add(const CalibrationEvidence& evidence);

 private:
  /// The values of the last seconds. A break as long as that begins anew, a shorter one does not:
  /// with a wrong IMU the estimator hardly starts before it is lost again.
  class RecentValues {
   public:
    void Add(Timestamp t, double value);
    /// The value that this share of them is below; empty until they are enough.
    std::optional<double> Quantile(double share) const;

   private:
    struct Value {
      Timestamp t;
      double value = 0;
    };
    std::deque<Value> values_;
    Timestamp begin_;
  };

  std::string FromStretch(const CalibrationEvidence& evidence);

  Episodes stretches_{Duration{30'000'000'000}};
  std::set<CalibrationPart> named_;  // in which the estimator has found something
  bool was_stereo_right_ = false;    // for a stretch
  RecentValues stereo_share_, imu_error_sigma_;
};

/// Of one keyframe that contradicts its IMU by so many sigmas (estimator/factors/imu_factor.h).
std::string ContradictionWarning(double sigma);

}  // namespace facet
