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
#include "facet/loop/place_index.h"
#include "facet/loop/place_record.h"
#include "facet/loop/saved_map.h"
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

/// Where little is known of where the keyframes are, they are looked for by appearance: the run is
/// found when three frames say the same, and none that count something else. With a map of runs
/// before that is the case from the beginning on, and T_MW leads to a map of the run's own until it
/// is found. After a loss of the odometry it is the case, too, and T_MW stays what it was until
/// then. A finding after which nothing of what should be seen is seen is taken back.
///
/// Not thread-safe; deterministic.
class PlaceMap {
 public:
  PlaceMap(const StereoRig& rig, const LoopOptions& options);
  /// The map M is that of `known`.
  PlaceMap(const StereoRig& rig, const LoopOptions& options, const SavedMap& known);

  /// Whether Add would do anything with a keyframe of this time.
  bool IsWanted(Timestamp t) const;

  /// Looks for the keyframe in the map and keeps it, if it shows something new.
  void Add(const KeyframeView& view);

  /// Whether Look would do anything with a frame of this time.
  bool IsLookedFor(Timestamp t) const;

  /// While the run is looked for frames between keyframes help; their views need no points.
  void Look(const KeyframeView& view);

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

  /// Whether T_MW leads to the map. Always, where there is no map of runs before.
  bool is_localised() const { return is_localised_; }
  /// Of the keyframe by which the run was found in the map; empty without one, or before.
  std::optional<Timestamp> localised() const { return localised_; }
  /// Keyframes agree on more than one place in the map, so that none is believed.
  bool is_ambiguous() const { return is_ambiguous_; }

  /// The map with this run, but for what is still looked for: a run that was not found in the map
  /// of runs before, or what came after a loss.
  SavedMap Saved() const;

  /// With those of runs before.
  int num_places() const { return static_cast<int>(places_.size()); }
  std::size_t memory_bytes() const;

 private:
  struct Pending {
    std::size_t closure = 0;  // index into closures_
    int place_node = 0, query_node = 0;
    UprightPose T_WplaceWquery;
    Matrix4d covariance;
    double stretch_per_px = 0;  // see GraphEdge
    Vector3d p_W;               // the keyframe's body, in its world
    Vector3d p_place;           // from the place's body to the keyframe's, in the place's world
    Timestamp t;
    bool is_by_appearance = false;  // before the run was found
  };

  bool Hovers(const KeyframeView& view) const;
  std::vector<int> Candidates(const KeyframeView& view) const;
  double Interval_s(Timestamp t) const;
  void LookFor(const KeyframeView& view);
  void BeginSearch(const KeyframeView& view);
  void EndLongSearch(Timestamp t);
  void DropByAppearance();
  void CompareByAppearance(const KeyframeView& view);
  bool IsOfThisPart(int place) const;
  double SeenShare(const PlaceRecord& place, const SE3& T_CW_place, const SE3& T_WC) const;
  ClosurePrediction Predict(const PlaceRecord& place, const KeyframeView& view) const;
  int NodeOf(const KeyframeView& view);
  void Consider(const ClosureCheck& check, int place, const KeyframeView& view);
  bool Agree(const Pending& a, const Pending& b) const;
  std::vector<int> AgreeingKeyframes(const Pending& one, bool by_appearance) const;
  bool IsMoreThanOneView(const Pending& one) const;
  void FindInMap();
  void JudgeFinding(std::size_t num_expected, std::size_t num_seen, Timestamp t);
  void TakeFindingBack(Timestamp t);
  void BelieveWhatAgrees();
  void Keep(const KeyframeView& view);
  void KeepPoints(const KeyframeView& view, PlaceRecord& place);

  CameraModel camera_;
  double focal_baseline_;  // [px m]
  LoopOptions options_;
  UprightCorners corners_;
  ClosureChecker checker_;
  MapGraph graph_;
  std::vector<MapKeyframe> keyframes_;          // like the graph's nodes
  std::vector<CameraIntrinsics> known_lenses_;  // by session before
  std::deque<PlaceRecord> places_;
  std::deque<Pending> pending_;
  std::vector<ClosureRecord> closures_;
  UprightPose T_MW_;
  // While the run is looked for: of all places before, and when that began.
  std::optional<PlaceIndex> index_;
  std::optional<Timestamp> search_began_;
  int session_ = 0;
  int first_own_node_ = 0;
  int first_sought_node_ =
      0;  // of the part of the run that is looked for: since its begin or a loss
  int num_places_before_ = 0;  // those of that part come after them
  bool is_localised_ = true, is_ambiguous_ = false;
  /// That of the newest finding, until a place is seen where it says.
  struct Finding {
    bool was_localised = false;
    UprightPose moved;    // by how much it has moved the part that was looked for, in the map
    int num_in_vain = 0;  // keyframes that saw nothing of what they should
  };
  std::optional<Finding> finding_;
  std::optional<Timestamp> localised_;
  std::optional<Timestamp> last_query_, last_kept_;
  std::optional<Timestamp> last_look_;  // of a keyframe or not
  SE3 last_query_T_WB_;
  int last_query_segment_ = 0;
  KeyframeView last_node_view_;  // without image and points
  PlaceQuery query_;
  ImagePyramid pyramid_;        // of the keyframe at hand
  bool is_known_well_ = false;  // the newest keyframe sees a place from nearly the same pose
};

}  // namespace facet
