// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_frame.h"

namespace facet {

void WindowFrame::ApplyStep(const Vector<15>& step) {
  if (pose_frozen) {
    delta.head<6>() += step.head<6>();
    x.T_WB = lin.T_WB.Retract(delta.head<3>(), delta.segment<3>(3));
  } else {
    x.T_WB = x.T_WB.Retract(step.head<3>(), step.segment<3>(3));
    lin.T_WB = x.T_WB;
  }
  if (!has_motion) return;
  const Vector<9> motion_step = step.tail<9>();
  if (motion_frozen) delta.tail<9>() += motion_step;
  x.v_WB += motion_step.head<3>();
  x.bias.b_g += motion_step.segment<3>(3);
  x.bias.b_a += motion_step.segment<3>(6);
  if (!motion_frozen) {
    lin.v_WB = x.v_WB;
    lin.bias = x.bias;
  }
}

void WindowFrame::FreezePose() {
  if (pose_frozen) return;
  pose_frozen = true;
  lin.T_WB = x.T_WB;
  delta.head<6>().setZero();
}

void WindowFrame::FreezeMotion() {
  if (motion_frozen) return;
  motion_frozen = true;
  lin.v_WB = x.v_WB;
  lin.bias = x.bias;
  delta.tail<9>().setZero();
}

}  // namespace facet
