// SPDX-License-Identifier: BSD-2-Clause
// Whether the estimated biases of the IMU change faster than a sensor's do. A sensor that fails
// slowly contradicts the images at no moment: the bias follows it.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "facet/imu/imu_types.h"

namespace facet {

/// The biases as one keyframe knows them.
struct BiasEvidence {
  Timestamp t;
  ImuBias bias;
  Vector3d sigma_b_g = Vector3d::Zero();  ///< 1-sigma [rad/s]
  Vector3d sigma_b_a = Vector3d::Zero();  ///< 1-sigma [m/s^2]
};

/// A bias that has changed by more than its sigmas and its random walk explain.
struct BiasDrift {
  bool is_gyro = false;
  int axis = 0;        ///< 0, 1, 2: x, y, z of the body
  double change = 0;   ///< rad/s or m/s^2
  double seconds = 0;  ///< within which it changed
  double num_sigmas = 0;
};

/// Not thread-safe.
class BiasWatch {
 public:
  explicit BiasWatch(const ImuNoise& noise) : noise_(noise) {}

  /// Of keyframes in order of time. Returns the largest drift over about 3 and 10 s, if there is
  /// one.
  std::optional<BiasDrift> Add(const BiasEvidence& evidence);

  /// Forgets everything: the state was given up.
  void Break() { history_.clear(); }

 private:
  std::optional<BiasDrift> Compare(const BiasEvidence& before, const BiasEvidence& now) const;

  ImuNoise noise_;
  std::deque<BiasEvidence> history_;
};

/// By how much what is taken for gravity may be turned meanwhile [rad].
double TiltOf(const BiasDrift& drift, double gravity);

/// The warning of a drift.
std::string InWords(const BiasDrift& drift);

}  // namespace facet
