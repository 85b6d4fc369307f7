// SPDX-License-Identifier: BSD-2-Clause
// Collects the estimator's outputs of a run into the record that the result files are written from.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "facet/io/result_writer.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

/// What the run loop measured of one frame.
struct FrameCost {
  double decode_ms = 0;   ///< thread CPU time
  double wall_ms = 0;     ///< decoding and the call of the estimator
  double latency_ms = 0;  ///< from the arrival of the images to the output
};

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

  int num_imu_gaps() const { return num_imu_gaps_; }
  int num_repeated_images() const { return num_repeated_images_; }
  int num_blank_images() const { return num_blank_images_; }
  int num_resets() const { return num_resets_; }

 private:
  void AddMesh(const std::shared_ptr<const MeshSnapshot>& snapshot);

  std::vector<FrameRecord> frames_;
  std::vector<StampedPose> keyframes_;
  std::shared_ptr<const MapSnapshot> last_snapshot_;
  std::shared_ptr<const MeshSnapshot> last_mesh_;
  std::vector<double> mesh_areas_m2_, view_areas_m2_;
  std::optional<Timestamp> last_good_;
  int num_resets_ = 0;
  int num_imu_gaps_ = 0;
  int num_repeated_images_ = 0;
  int num_blank_images_ = 0;
};

}  // namespace facet
