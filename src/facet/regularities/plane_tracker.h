// SPDX-License-Identifier: BSD-2-Clause
// The regularities of the scene over the whole run (paper II-A.3 and II-A.4): planes are found in
// the mesh, recognised when they are seen again, and given their landmarks. What this finds goes to
// the estimator as data, before its next keyframe.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/regularities/former_planes.h"
#include "facet/regularities/known_plane.h"
#include "facet/regularities/plane_detector.h"
#include "facet/regularities/plane_relations.h"
#include "facet/regularities/regularity_options.h"
#include "facet/regularities/regularity_result.h"

namespace facet {

/// Finds planes among the faces that are not `taken` (one flag per face); faces of one are in no
/// other.
using FindPlanes = std::function<std::vector<PlaneCandidate>(const SurfaceFaces& faces,
                                                             const std::vector<char>& taken)>;

/// Not thread-safe. Never throws for any content of the mesh.
class PlaneTracker {
 public:
  /// `find` replaces the detector, for studies of what follows it.
  explicit PlaneTracker(const RegularityOptions& options, FindPlanes find = nullptr)
      : options_(options),
        detector_(options.detection),
        find_(std::move(find)),
        relations_(options.relations) {}

  /// After a keyframe: the mesh and what the estimator knows. Both must be of the same keyframe.
  RegularityResult Process(const SearchMesh& mesh, const MapSnapshot& map);

  /// Every plane that the estimator has ever solved for, in the order of their ids, but for those
  /// that became part of another and those that turned out to be none.
  std::vector<PlaneRecord> Records() const;

  /// The estimator started over: its planes are gone.
  void Reset();

 private:
  void Refresh(const MapSnapshot& map, PlaneAssignments& out);
  void Recognise(const MapSnapshot& map, const PlaneCandidate& candidate);
  int FindKnown(const MapSnapshot& map, const PlaneCandidate& candidate) const;
  int FindTentative(const PlaneCandidate& candidate) const;
  bool IsNearKnown(const PlaneCandidate& candidate) const;
  void Promote(PlaneAssignments& out);
  void AddOldFaces(int plane);
  void GiveUpOldFaces(int plane);
  bool HasEnoughLandmarks(int plane) const;
  /// Planes that have had their time are not the same when they come back.
  bool MayRecall() const { return options_.tracking.max_age_s == 0; }
  void Relate(PlaneAssignments& out);
  MeshRegularities JudgeMesh(const SearchMesh& mesh, const SE3& T_WB) const;
  std::vector<int> FacePlanes() const;
  std::vector<TriangleVerdict> JudgeTriangles(const SearchMesh& mesh,
                                              const std::vector<double>& depth_scales,
                                              const SE3& T_WB) const;
  void Forget(std::size_t plane);

  RegularityOptions options_;
  PlaneDetector detector_;
  FindPlanes find_;  // empty: the detector's
  PlaneRelations relations_;
  std::vector<KnownPlane> planes_;
  FormerPlanes former_;
  std::int64_t next_id_ = 0;
  Timestamp now_;
  // Of the last keyframe
  SurfaceFaces faces_;
  std::vector<int> landmark_of_point_;  // into MapSnapshot::landmarks, -1: none
  std::vector<int> plane_of_face_;      // into planes_, -1: none
};

}  // namespace facet
