// SPDX-License-Identifier: BSD-2-Clause
// The map of places: keyframes that are recognised when they come into view again, and what that
// says about the drift of the odometry. It corrects nothing in the odometry itself: T_MW, from the
// odometry's world W to the map M (REP 105: odom and map), takes the corrections.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/loop/closure_check.h"
#include "facet/loop/loop_options.h"
#include "facet/loop/map_graph.h"
#include "facet/loop/place_record.h"
#include "facet/map/map_snapshot.h"

namespace facet {

inline constexpr const char* kClosureAccepted = "accepted";

/// A comparison of a keyframe with a place, for closures.csv.
struct ClosureRecord {
  Timestamp t;        ///< of the keyframe
  Timestamp t_place;  ///< of the place
  int num_matches = 0, num_inliers = 0, num_visible = 0;
  UprightPose T_WplaceWquery;
  double sigma_m = 0, sigma_yaw_rad = 0;
  std::string verdict;  ///< accepted, waiting for others, or why it was refused
  int edge = -1;        ///< of the graph, if it became one
};

/// From the odometry's world to the map, at the time of a node.
struct MapCorrection {
  Timestamp t;
  int segment = 0;
  UprightPose T_MW;
};

/// Not thread-safe; deterministic.
class PlaceMap {
 public:
  PlaceMap(const StereoRig& rig, const LoopOptions& options);

  /// Whether Add would do anything with a keyframe of this time.
  bool IsWanted(Timestamp t) const;

  /// Looks for the keyframe in the map and keeps it, if it shows something new.
  void Add(const KeyframeView& view);

  /// Takes over what the estimator has learnt about the newest places since: their poses and those
  /// of their points.
  void Refine(const MapSnapshot& snapshot);

  /// Where the odometry says the keyframe was, now that its window has closed; ignored if it is not
  /// in the map.
  void Smooth(FrameId frame, const SE3& T_WB);

  /// At the newest keyframe.
  const UprightPose& T_MW() const { return T_MW_; }

  /// All nodes in order of time, as after the last optimisation.
  std::vector<MapCorrection> Corrections() const;

  /// Everything that was compared, with the final verdicts.
  std::vector<ClosureRecord> Closures() const;

  int num_places() const { return static_cast<int>(places_.size()); }
  std::size_t memory_bytes() const;

 private:
  struct NodeRecord {
    FrameId frame;
    Timestamp t;
    int segment = 0;
  };
  struct Pending {
    std::size_t closure = 0;  // index into closures_
    int place_node = 0, query_node = 0;
    UprightPose T_WplaceWquery;
    Matrix4d covariance;
    double stretch_per_px = 0;  // see GraphEdge
    Vector3d p_W;               // the keyframe's body, in its world
    Vector3d p_place;           // from the place's body to the keyframe's, in the place's world
    Timestamp t;
  };

  bool Hovers(const KeyframeView& view) const;
  std::vector<int> Candidates(const KeyframeView& view) const;
  double SeenShare(const PlaceRecord& place, const SE3& T_CW_place, const SE3& T_WC) const;
  ClosurePrediction Predict(const PlaceRecord& place, const KeyframeView& view) const;
  std::vector<const PlaceRecord*> WithNeighbours(int place) const;
  int NodeOf(const KeyframeView& view);
  void Consider(const ClosureCheck& check, int place, const KeyframeView& view);
  bool Agree(const Pending& a, const Pending& b) const;
  void BelieveWhatAgrees();
  void Keep(const KeyframeView& view);
  void KeepPoints(const KeyframeView& view, PlaceRecord& place);

  CameraModel camera_;
  double focal_baseline_;  // [px m]
  LoopOptions options_;
  UprightCorners corners_;
  ClosureChecker checker_;
  MapGraph graph_;
  std::vector<NodeRecord> nodes_;  // like the graph's
  std::deque<PlaceRecord> places_;
  std::deque<Pending> pending_;
  std::vector<ClosureRecord> closures_;
  UprightPose T_MW_;
  std::optional<Timestamp> last_query_, last_kept_;
  SE3 last_query_T_WB_;
  int last_query_segment_ = 0;
  KeyframeView last_node_view_;  // without image and points
  PlaceQuery query_;
  ImagePyramid pyramid_;        // of the keyframe at hand
  bool is_known_well_ = false;  // the newest keyframe sees a place from nearly the same pose
};

}  // namespace facet
