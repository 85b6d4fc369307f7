// SPDX-License-Identifier: BSD-2-Clause
// What both versions of the pipeline, on one thread and on two, consist of.
#pragma once

#include "facet/pipeline/front_stage.h"
#include "facet/pipeline/loop_stage.h"
#include "facet/pipeline/pose_stage.h"
#include "facet/pipeline/run_result.h"
#include "facet/pipeline/scene_stage.h"

namespace facet {

struct VioStages {
  VioStages(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
      : front(rig, options), pose(rig, noise, options), scene(rig, options), loops(rig, options) {}

  FrontStage front;
  PoseStage pose;
  SceneStage scene;
  LoopStage loops;

  RunResult Result() const {
    RunResult result = ResultWithoutMap();
    result.map = scene.Map(result.map_memory);
    return result;
  }

  RunResult TakeResult() {
    RunResult result = ResultWithoutMap();
    result.map = scene.TakeMap(result.map_memory);
    return result;
  }

 private:
  RunResult ResultWithoutMap() const {
    RunResult result;
    result.window_keyframes = pose.WindowKeyframes();
    result.planes = scene.Planes();
    result.loops = loops.Result();
    result.calibration = pose.Calibration();
    // The estimator knows the right camera as it would see without the turn.
    if (result.calibration && front.right_turn()) {
      Quaterniond& q = result.calibration->T_BC[1].q;
      q = (q * *front.right_turn()).normalized();
    }
    result.num_refused_imu = front.num_refused_imu();
    result.num_stray_imu = front.num_stray_imu();
    result.imu_screen = front.imu_screen_counts();
    return result;
  }
};

}  // namespace facet
