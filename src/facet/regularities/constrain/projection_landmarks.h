// SPDX-License-Identifier: BSD-2-Clause
// Pipeline SP (paper II-B): landmarks on planes are treated as in its projection factors, and there
// is no plane variable. Each keyframe's planes are found anew and forgotten.
#pragma once

#include <set>

#include "facet/map/map_snapshot.h"
#include "facet/map/plane_assignments.h"
#include "facet/regularities/detect/plane_detector.h"

namespace facet {

/// Not thread-safe. Never throws for any content of the mesh.
class ProjectionLandmarks {
 public:
  explicit ProjectionLandmarks(const DetectionOptions& options)
      : only_in_view_(options.only_in_view), detector_(options) {}

  /// After a keyframe: which landmarks are on some plane from now on, and which of those that were
  /// have faces around them now, which were searched, and none on a plane.
  PlaneAssignments Process(const SearchMesh& mesh, const MapSnapshot& map);

  void Reset() { projected_.clear(); }

 private:
  bool only_in_view_;
  PlaneDetector detector_;
  SurfaceFaces faces_;
  std::set<LandmarkId> projected_;
};

}  // namespace facet
