// SPDX-License-Identifier: BSD-2-Clause
// How well the IMU alone predicts the motion of a real flight over short intervals, compared with
// the recorded ground truth and with what the preintegrated covariance promises.
#pragma once

#include <filesystem>
#include <vector>

#include "facet/imu/preintegration.h"

namespace facet {

/// One interval predicted from the true state at its start with the true biases there.
struct PredictedInterval {
  Timestamp t0;
  Duration length;
  Vector<9> error;          ///< predicted - true: theta in B (end), p and v in W
  Vector<9> error_B;        ///< the same with p and v in B at the start, as the covariance has them
  Matrix<9, 9> covariance;  ///< with the densities of the datasheet
  double speed = 0;         ///< at the start [m/s]
  double vibration = 0;     ///< rms per axis of accelerations minus their mean over 50 ms [m/s^2]
  Vector<6> odd_minus_even;  ///< see OddEvenDensity
  bool at_rest = false;
};

struct Flight {
  std::vector<NavState> truth;
  std::vector<ImuSample> imu;
};

/// Reads groundtruth.csv and imu.csv of a folder.
Flight LoadFlight(const std::filesystem::path& folder);

/// Non-overlapping intervals of `length` over the whole flight. The truth's frame may be tilted
/// against gravity: `g_W` is gravity there.
std::vector<PredictedInterval> PredictFlight(const Flight& flight,
                                             Duration length,
                                             const Vector3d& g_W = GravityInWorld());

/// The gravity that would make the mean velocity error zero, given the one that was used.
Vector3d GravityWithoutMeanError(const std::vector<PredictedInterval>& intervals,
                                 const Vector3d& g_W = GravityInWorld());

struct NineErrors {
  Vector<9> mean = Vector<9>::Zero();
  Vector<9>
      standard_error;  ///< of mean, from means over 2 s: errors are correlated over about 0.5 s
  Vector<9> rms = Vector<9>::Zero();
};

struct ErrorStatistics {
  int count = 0;
  NineErrors W;       ///< of error
  NineErrors B;       ///< of error_B
  Vector3d norm_rms;  ///< rms length of theta, p, v
  /// sqrt of the mean normalised squared error per degree of freedom of theta, p, v: the factor on
  /// the datasheet densities that explains the error, with the truth's own error counted as the
  /// IMU's.
  Vector3d factor;
  double nees = 0;  ///< mean of the joint one, 9 expected
};

ErrorStatistics Summarise(const std::vector<PredictedInterval>& intervals);

/// White-noise densities of gyroscope [rad/s/sqrt(Hz)] and accelerometer [m/s^2/sqrt(Hz)] near half
/// the sample rate, from the difference between the integrals of odd and of even samples:
/// independent of the ground truth, blind to errors that change slowly. Vibration is motion that
/// really happens: what of it does not cancel in the integral is far less than this.
Vector2d OddEvenDensity(const std::vector<PredictedInterval>& intervals);

}  // namespace facet
