// SPDX-License-Identifier: BSD-2-Clause
// Turns of the left camera that the images tell, beside the gyroscope around them.
#pragma once

#include <span>
#include <vector>

#include "facet/geometry/se3.h"
#include "facet/plausibility/two_view_rotation.h"

namespace facet {

/// The left camera from one image to another.
struct ImageTurn {
  Timestamp begin, end;
  TwoViewRotation rotation;
  double duration_s() const { return ToSeconds(end - begin); }
};

/// Samples of a gyroscope in order of time, for integrals over any interval.
class GyroTrack {
 public:
  void Add(Timestamp t, const Vector3d& gyro) { samples_.push_back({t, gyro}); }
  std::size_t size() const { return samples_.size(); }

  /// Log of the rotation of the body from `begin` to `end` [rad], as R_begin_end; false where
  /// there are no samples around, or a hole of more than 0.1 s.
  bool Turn(Timestamp begin, Timestamp end, Vector3d& theta) const;

  /// The sum of the rates instead, which has no largest angle: units may be wrong.
  bool Sum(Timestamp begin, Timestamp end, Vector3d& angle) const;

 private:
  struct Sample {
    Timestamp t;
    Vector3d gyro;
  };
  Vector3d At(std::size_t behind, Timestamp t) const;

  /// Calls step(angle) for each part of the interval.
  template <class Step>
  bool Integrate(Timestamp begin, Timestamp end, const Step& step) const;

  std::vector<Sample> samples_;
};

}  // namespace facet
