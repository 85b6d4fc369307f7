// SPDX-License-Identifier: BSD-2-Clause
// What the search for regularities tells the estimator after a keyframe: which planes there are and
// which landmarks lie on them, and how the planes are related.
#pragma once

#include <utility>
#include <vector>

#include "facet/base/types.h"
#include "facet/geometry/plane.h"
#include "facet/map/plane_measurement.h"
#include "facet/map/plane_relation.h"

namespace facet {

/// A plane that becomes a variable. Its value is only where the estimation starts.
struct NewPlane {
  PlaneId id;
  Plane plane_W;
  Vector3d centroid_W = Vector3d::Zero();  ///< of what was seen of it
};

/// A landmark that is on a plane from now on, unless it is hardly known across the plane or is
/// farther from it than its uncertainty and max_distance_m allow.
struct PlaneAttachment {
  LandmarkId landmark;
  PlaneId plane;
  double max_distance_m = 0;
  /// How far away it is (mesh/far_surfaces.h): by this it may be known less, and is expected to
  /// stand out more.
  double length_scale = 1;
};

/// How far the surface of a plane is from flat, 1-sigma.
struct PlaneUnevenness {
  PlaneId plane;
  double sigma_m = 0;
};

struct PlaneAssignments {
  std::vector<NewPlane> created;
  std::vector<PlaneAttachment> attached;
  std::vector<std::pair<LandmarkId, PlaneId>> detached;  ///< landmarks that no longer lie there
  std::vector<PlaneId> retired;                          ///< planes that leave the estimator
  std::vector<PlaneUnevenness> unevenness;               ///< from now on
  std::vector<PlaneRelation> relations;                  ///< hold from now on
  std::vector<PlaneMeasurement> measurements;            ///< by the newest keyframe
  /// Pipeline SP: landmarks that count with the paper's projection noise and loss from now on, and
  /// those that no longer do. These need no plane.
  std::vector<LandmarkId> projected, unprojected;

  bool IsEmpty() const {
    return created.empty() && attached.empty() && detached.empty() && retired.empty() &&
           unevenness.empty() && relations.empty() && measurements.empty() && projected.empty() &&
           unprojected.empty();
  }
};

}  // namespace facet
