// SPDX-License-Identifier: BSD-2-Clause
// What the window knows beside the measurements in it: where it started, and what is left of
// everything that has been marginalised.
#pragma once

#include <vector>

#include "facet/estimator/estimator_options.h"
#include "facet/estimator/window/variable.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Quadratic prior 1/2 d^T H d + b^T d over frozen variables, d = delta of those variables
/// (docs/math.md, equation (5.2)).
struct MarginalPrior {
  /// The columns of one variable; it is named by its id, because indices change.
  struct Block {
    Variable::Kind kind;
    FrameId frame;  ///< of a pose or motion
    PlaneId plane;  ///< of a plane
    int offset;     ///< first column in H

    static Block OfCalibration(int offset) {
      return {Variable::Kind::kCalibration, FrameId{}, PlaneId{}, offset};
    }
    static Block OfPose(FrameId frame, int offset) {
      return {Variable::Kind::kPose, frame, PlaneId{}, offset};
    }
    static Block OfMotion(FrameId frame, int offset) {
      return {Variable::Kind::kMotion, frame, PlaneId{}, offset};
    }
    static Block OfPlane(PlaneId plane, int offset) {
      return {Variable::Kind::kPlane, FrameId{}, plane, offset};
    }
    int size() const { return SizeOf(kind); }
  };
  std::vector<Block> blocks;
  MatrixXd H;
  VectorXd b;
  int dim() const { return static_cast<int>(b.size()); }
};

/// Wide prior of the first frame; fixes origin and heading. Part of the marginal prior later
/// (docs/math.md, section 6).
struct StartPrior {
  FrameId frame;
  SE3 T_WB;  ///< position and heading that are kept
  double sigma_position, sigma_yaw;
  double sigma_velocity, sigma_gyro_bias, sigma_accel_bias;

  StartPrior(FrameId first_frame, const SE3& T_WB_first, const StartOptions& options)
      : frame(first_frame),
        T_WB(T_WB_first),
        sigma_position(options.sigma_position),
        sigma_yaw(options.sigma_yaw),
        sigma_velocity(options.sigma_velocity),
        sigma_gyro_bias(options.sigma_gyro_bias),
        sigma_accel_bias(options.sigma_accel_bias) {}
};

}  // namespace facet
