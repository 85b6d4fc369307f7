// SPDX-License-Identifier: BSD-2-Clause
// Whether the gyroscope turns with the images: its units, its axes, and the rotation between it and
// the camera. Sets what is usually done wrong against the calibration as given, and decides when
// one of them explains what the other cannot.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "facet/geometry/se3.h"
#include "facet/plausibility/two_view_rotation.h"

namespace facet {

/// The same turn, seen by both.
struct SharedTurn {
  TwoViewRotation image;               ///< of the left camera
  Vector3d gyro_B = Vector3d::Zero();  ///< integral of what the gyroscope measured
  double duration_s = 0;
};

/// Not thread-safe.
class GyroscopeCheck {
 public:
  /// R_BC of the left camera as the calibration gives it.
  explicit GyroscopeCheck(const Quaterniond& R_BC);

  /// Whether a turn at this rate would say something new.
  bool IsOfUse(const Vector3d& gyro_B) const;

  /// What is wrong, in words that follow "the images turn as if"; empty: nothing is, or it is not
  /// clear yet.
  std::string Add(const SharedTurn& turn);

  /// Units and all three axes are right: nothing more is to be learnt.
  bool IsConvinced() const;

 private:
  /// What might be true instead: the camera turns by A * gyro_B.
  struct Hypothesis {
    Matrix3d A;
    std::string words;
    bool is_common = false;   ///< one of those that people make
    bool is_refuted = false;  ///< the calibration as given explains what it cannot
  };

  struct Costs {
    double sum = 0;
    std::vector<double> turns;
  };

  Costs Cost(const Matrix3d& A) const;
  bool IsClear(const Costs& better, const Costs& worse) const;
  void AddAxes(double scale, const std::string& unit_words);
  std::vector<Hypothesis> Fitted() const;
  std::string Decide(const Costs& as_given, const std::vector<const Hypothesis*>& open) const;

  struct WeightedTurn {
    SharedTurn turn;
    Matrix3d information;  ///< of the difference between image and gyroscope
  };

  Quaterniond R_BC_;
  std::vector<Hypothesis> hypotheses_;  // simplest first
  std::deque<WeightedTurn> turns_;
};

}  // namespace facet
