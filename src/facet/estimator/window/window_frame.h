// SPDX-License-Identifier: BSD-2-Clause
// One stereo frame of the window: its variables, and the IMU from the frame before.
#pragma once

#include <optional>

#include "facet/estimator/window/image_motion.h"
#include "facet/estimator/window/imu_link.h"
#include "facet/estimator/window/window_calibration.h"

namespace facet {

/// Variables that appear in the marginal prior are "frozen": their Jacobians are always taken at
/// `lin` (first-estimate Jacobians, docs/math.md, section 5.2), and the estimate is x = lin (+)
/// delta. For the others lin == x.
struct WindowFrame {
  FrameId id;
  bool is_keyframe = false;
  bool is_reported = false;  ///< the front end chose it as keyframe: its final pose is an output
  bool has_motion = true;    ///< velocity and biases are variables; otherwise only the pose is
  bool pose_frozen = false;
  bool motion_frozen = false;
  NavState x;
  NavState lin;
  Vector<15> delta = Vector<15>::Zero();  ///< theta p v b_g b_a; only the frozen parts are used
  std::optional<ImuLink> imu_link;        ///< to the previous frame
  ImageMotion to_image;                   ///< by the time offset of when it was made
  Vector3d last_v_B = Vector3d::Zero();   ///< velocity in B when it was still a variable

  /// Velocity in B at its stamp [m/s].
  Vector3d VelocityInBody() const {
    return has_motion ? Vector3d(x.T_WB.q.conjugate() * x.v_WB) : last_v_B;
  }
  /// How the body moves on the way to its image.
  BodyRates Rates() const { return {to_image.w_B, VelocityInBody() + to_image.dv_B}; }

  /// Applies a step in the tangent space of the pose and, if the frame has motion, of the rest.
  void ApplyStep(const Vector<15>& step);

  /// From here on the Jacobians are taken at the present estimate, unless they already are at one.
  void FreezePose();
  void FreezeMotion();
};

}  // namespace facet
