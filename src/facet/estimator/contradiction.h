// SPDX-License-Identifier: BSD-2-Clause
// What to believe after the IMU and the images have contradicted each other. One of them was wrong:
// something large moves in front of the cameras, or a sensor lies for a moment. Which one cannot be
// told in time, so that from then on the state is uncertain by what they differed in.
#pragma once

#include <optional>

#include "facet/estimator/window/imu_link.h"

namespace facet {

/// Not thread-safe.
class Contradiction {
 public:
  /// After the solve of a keyframe: its interval of the IMU and the states at its two ends.
  /// `error_sigma`: how far they are from each other (ImuErrorSigma).
  void Add(const ImuLink& link, const NavState& begin, const NavState& end, double error_sigma);

  /// A keyframe at which the world may be tilted by this angle [rad], because a bias of the IMU has
  /// followed something else.
  void AddTilt(const NavState& x, double tilt);

  /// What the differences so far have added up to in this state, of theta p v b_g b_a
  /// (docs/math.md, section 4.6). A wrong velocity moves on, and is forgotten within some seconds;
  /// a wrong heading leads astray with the distance; where they have led to is not forgotten.
  Matrix<15, 15> CovarianceOf(const NavState& x) const;

  /// The state was given up at this time: what follows has its tilt and its velocity anew.
  void StartOver(Timestamp t);

  /// Whether it is so new that the state is not to be trusted.
  bool IsRecentAt(Timestamp t) const;

 private:
  /// At the last keyframe with one: when and where, the angle, and how far it had led astray.
  struct Tilt {
    Timestamp t;
    Vector3d place;
    double angle = 0, astray_m = 0;

    double AngleAt(Timestamp later) const;
    double AstrayAt(const NavState& x) const;
  };

  Vector3d PositionAt(double seconds_later) const;
  Vector3d AstrayAt(const Vector3d& p_W) const;
  void MoveTo(Timestamp t);

  std::optional<Timestamp> t_;  // of the last contradiction
  /// In the world: sizes of the differences, and where the body was at the last one.
  Vector3d theta_ = Vector3d::Zero(), p_ = Vector3d::Zero(), v_ = Vector3d::Zero();
  Vector3d place_ = Vector3d::Zero();
  std::optional<Tilt> tilt_;
};

}  // namespace facet
