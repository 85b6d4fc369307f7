// SPDX-License-Identifier: BSD-2-Clause
// The regularities of the scene over the whole run (paper II-A.3 and II-A.4): planes are detected
// in the mesh, associated with planes that are known already, and given their landmarks. The result
// goes to the estimator as data, before its next keyframe. Pipeline SPR.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/regularities/constrain/plane_relations.h"
#include "facet/regularities/detect/plane_detector.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/regularity_result.h"
#include "facet/regularities/track/retired_planes.h"
#include "facet/regularities/track/tracked_plane.h"

namespace facet {

/// Finds planes among the faces that are not `taken` (one flag per face); the faces of one
/// candidate are in no other.
using PlaneSearch = std::function<std::vector<PlaneCandidate>(const SurfaceFaces& faces,
                                                              const std::vector<char>& taken)>;

/// Not thread-safe. Never throws for any content of the mesh.
class PlaneTracker {
 public:
  /// `find` replaces the detector, for studies of what follows it.
  explicit PlaneTracker(const RegularityOptions& options, PlaneSearch find = nullptr)
      : options_(options),
        detector_(options.detection),
        find_(std::move(find)),
        relations_(options.relations) {}

  /// After a keyframe: the mesh and what the estimator knows. Both must be of the same keyframe.
  RegularityResult Process(const SearchMesh& mesh, const MapSnapshot& map);

  /// Every plane that the estimator has ever solved for, in the order of their ids, but for those
  /// that were merged into another and those that turned out to be none.
  std::vector<PlaneRecord> Records() const;

  /// The estimator started over: its planes are gone.
  void Reset();

 private:
  // The steps of Process.
  void TakeEstimates(const MapSnapshot& map, PlaneAssignments& out);
  void Revise(const MapSnapshot& map, PlaneAssignments& out);
  void Detect(const MapSnapshot& map);
  void Confirm(PlaneAssignments& out);
  void Relate(PlaneAssignments& out);
  MeshRegularities JudgeMesh(const SearchMesh& mesh, const SE3& T_WB) const;

  void Associate(const MapSnapshot& map, const PlaneCandidate& candidate);
  int FindConfirmed(const MapSnapshot& map, const PlaneCandidate& candidate) const;
  int FindTentative(const PlaneCandidate& candidate) const;
  bool IsNearConfirmed(const PlaneCandidate& candidate) const;
  void AddFacesOfEarlierViews(int plane);
  void ReleaseFacesOfEarlierViews(int plane);
  bool HasEnoughLandmarks(int plane) const;
  std::vector<int> FacePlaneIds() const;
  std::vector<TriangleVerdict> JudgeShownTriangles(const SearchMesh& mesh,
                                                   const std::vector<double>& depth_scales,
                                                   const SE3& T_WB) const;
  /// Planes that leave the estimator because of their age get a new id when they come back.
  bool MayReidentify() const { return options_.tracking.max_age_s == 0; }
  void Retire(std::size_t plane);

  RegularityOptions options_;
  PlaneDetector detector_;
  PlaneSearch find_;  // empty: the detector's
  PlaneRelations relations_;
  std::vector<TrackedPlane> planes_;
  RetiredPlanes retired_;
  std::int64_t next_id_ = 0;
  Timestamp now_;
  // These belong to the newest keyframe.
  SurfaceFaces faces_;
  std::vector<int> landmark_of_point_;    // into MapSnapshot::landmarks, -1: none
  std::vector<int> plane_index_of_face_;  // into planes_, -1: none
};

}  // namespace facet
