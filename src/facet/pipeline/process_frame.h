// SPDX-License-Identifier: BSD-2-Clause
// The file to read first: one stereo frame, stage by stage, from images and IMU samples to pose,
// mesh and planes.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "facet/pipeline/loop_stage.h"
#include "facet/pipeline/pose_stage.h"
#include "facet/pipeline/scene_stage.h"
#include "facet/pipeline/tracked_frame.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

/// What a frame leaves: the output for the user, and what the front stage may use from now on.
struct ProcessedFrame {
  VioOutput output;
  std::optional<Feedback> feedback;
};

/// The part of a frame after the tracking, to be run on any thread, frame after frame.
using BackHalf = std::function<ProcessedFrame()>;

/// Runs the front half of a frame and returns the back half, which refers to `pose`, `scene` and
/// `on_pose`. `front`: FrontStage, or for tests and studies anything with its Predict and Track.
template <class Front>
BackHalf ProcessFrame(Front& front,
                      PoseStage& pose,
                      SceneStage& scene,
                      LoopStage& loops,
                      const StereoFrame& frame,
                      const PoseObserver& on_pose) {
  // Predict: where the IMU says the cameras are now, and so where landmarks will be seen.
  MotionPrediction prediction = front.Predict(frame.t);
  // Track and match: corners from left image to left image; on keyframes, from left to right.
  TrackedFrame tracked = front.Track(frame, std::move(prediction));

  return
      [&pose, &scene, &loops, &on_pose, left = frame.left, tracked = std::move(tracked)]() mutable {
        // Estimate: fixed-lag smoothing of landmarks, IMU and planes (paper section II-B).
        VioOutput output = pose.Estimate(tracked);
        loops.Correct(output);
        if (on_pose) on_pose(output);
        // The rest is for keyframes. Mesh: triangles between the keyframe's landmarks join the mesh
        // (II-A.1, II-A.2).
        scene.UpdateMesh(tracked, output);
        // Find planes: among the faces of the mesh, and the landmarks that lie on them (II-A.3,
        // II-A.4).
        const RegularityResult regularities = scene.FindPlanes(output);
        // Hand back: planes to the estimator, for the next keyframe, and to the mesh, which is then
        // part of the output; state and landmarks to the front stage, which may be two frames
        // ahead.
        pose.Assign(regularities.assignments);
        scene.ShowPlanes(regularities.mesh, output);
        // Recognise places, which corrects the map and never the odometry.
        loops.Add(left, tracked, output);
        output.observations =
            std::make_shared<FrameObservations>(std::move(tracked.frontend.observations));
        return ProcessedFrame{std::move(output), pose.TakeFeedback()};
      };
}

}  // namespace facet
