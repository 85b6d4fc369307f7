// SPDX-License-Identifier: BSD-2-Clause
// First half of a stereo frame: IMU interval, prediction, feature tracking.
#pragma once

#include <deque>
#include <unordered_map>

#include "facet/frontend/stereo_frontend.h"
#include "facet/imu/imu_buffer.h"
#include "facet/map/map_snapshot.h"
#include "facet/pipeline/support_points.h"
#include "facet/pipeline/vio_options.h"

namespace facet {

/// What the back stage knew after a keyframe; helps to predict where tracked points will be.
struct Feedback {
  FrameId frame;
  bool is_reset = false;  ///< the estimator started over: nothing is known any more
  NavState state;         ///< at the keyframe, IMU clock
  std::vector<LandmarkEstimate> landmarks;
};

/// What the mesh needs from the images of a keyframe.
struct MeshPacket {
  std::vector<std::uint8_t> intensities;  ///< of the left image at the observations
  /// [1/m] along z of the left camera, of the observations; 0 where not matched.
  std::vector<double> inverse_depths;
  std::vector<DepthPoint> support;  ///< points between them
  std::vector<std::uint8_t> support_intensities;
};

/// What the front stage hands to the back stage.
struct FrontPacket {
  FrontendResult frontend;
  MeshPacket mesh;             ///< on keyframes only
  ImuInterval imu;             ///< from the previous frame to this one
  bool used_feedback = false;  ///< the tracks were predicted with more than the gyroscope
  StageTimes times;
};

/// Not thread-safe. Deterministic: frame k uses the newest feedback of a keyframe k - kLag or
/// older, no matter how far the back stage has come.
class FrontStage {
 public:
  /// The back stage may work on one frame while the front stage works on the next.
  static constexpr std::int64_t kLag = 2;

  /// IMU samples older than this are forgotten until the first frame comes.
  static constexpr Duration kLongestHistory{600'000'000'000};

  FrontStage(const StereoRig& rig, const VioOptions& options);

  ImuBuffer::AddResult AddImu(const ImuSample& sample);
  void AddFeedback(Feedback feedback) { feedback_.push_back(std::move(feedback)); }

  FrontPacket Process(const StereoFrame& frame);

  std::size_t num_imu_samples() const { return imu_.size(); }

 private:
  void FillMeshPacket(const StereoFrame& frame, FrontPacket& packet);
  ImuInterval IntervalTo(Timestamp t_imu) const;
  FrontendHint Predict(const ImuInterval& now);
  void TakeFeedback();
  void ForgetOldImu();

  StereoRig rig_;
  double max_gap_s_;
  MeshOptions mesh_options_;
  StereoFrontend frontend_;
  SupportPlaces support_places_;
  ImuBuffer imu_;
  std::deque<Feedback> feedback_;  ///< front: in use (if its frame is old enough)
  bool has_feedback_ = false;
  std::int64_t next_frame_ = 0;
  bool has_previous_ = false;
  Timestamp previous_t_;          ///< IMU clock
  std::deque<Timestamp> recent_;  ///< of the last kLag frames, IMU clock
  std::unordered_map<LandmarkId, double> inverse_depth_;
};

}  // namespace facet
