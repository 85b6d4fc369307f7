// SPDX-License-Identifier: BSD-2-Clause
// Collects the estimator's outputs of a run into the record that the result files are written from.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "warning_log.h"

#include "facet/io/result_writer.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

/// What the run loop measured of one frame.
struct FrameCost {
  double decode_ms = 0;        ///< thread CPU time
  double wall_ms = 0;          ///< decoding and the call of the estimator
  double latency_ms = 0;       ///< from the arrival of the images to the output
  double pose_latency_ms = 0;  ///< the same to the pose
};

/// What is kept of a frame; without its costs but the stages'.
FrameRecord MakeFrameRecord(const VioOutput& output);

/// Not thread-safe.
class RunRecorder {
 public:
  void Add(const VioOutput& output, const FrameCost& cost);

  /// After the last output, with the keyframes still in the window.
  void Finish(const std::vector<KeyframePose>& window);

  const std::vector<FrameRecord>& frames() const { return frames_; }
  std::optional<Timestamp> last_good() const { return last_good_; }  ///< has a pose, is not lost

  /// Moves frames, keyframes, landmarks and counts into the record.
  void MoveInto(RunRecord& record);

  const Occurrences& imu_gaps() const { return imu_gaps_; }
  const Occurrences& repeated_images() const { return repeated_images_; }
  const Occurrences& blank_images() const { return blank_images_; }
  /// Frames that were degraded because they saw little.
  const Occurrences& few_landmarks() const { return few_landmarks_; }
  const Occurrences& resets() const { return resets_; }

 private:
  void AddMesh(const std::shared_ptr<const MeshSnapshot>& snapshot);

  std::vector<FrameRecord> frames_;
  std::vector<StampedPose> keyframes_;
  std::shared_ptr<const MapSnapshot> last_snapshot_;
  std::shared_ptr<const MeshSnapshot> last_mesh_;
  std::vector<double> mesh_areas_m2_, view_areas_m2_;
  std::optional<Timestamp> last_good_;
  Occurrences resets_, imu_gaps_, repeated_images_, blank_images_, few_landmarks_;
};

}  // namespace facet
