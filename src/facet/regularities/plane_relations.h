// SPDX-License-Identifier: BSD-2-Clause
// What the planes of a building have in common (the paper's future work, section IV): walls stand
// upright, floors lie level, walls are parallel or at right angles to each other.
#pragma once

#include <map>
#include <vector>

#include "facet/map/map_snapshot.h"
#include "facet/map/plane_assignments.h"
#include "facet/map/plane_record.h"
#include "facet/regularities/regularity_options.h"

namespace facet {

/// A plane that may be related to others.
struct RelatedPlane {
  const PlaneEstimate* estimate = nullptr;
  PlaneOrientation orientation = PlaneOrientation::kOblique;
  double area_m2 = 0;
};

/// Proposes relations that held for several keyframes in a row, each one once. Walls are related to
/// one wall per heading, the largest when it was chosen: a star, since a clique would count one
/// fact many times. Not thread-safe.
class PlaneRelations {
 public:
  explicit PlaneRelations(const PlaneRelationOptions& options) : options_(options) {}

  /// After a keyframe; `planes` are those of the estimator.
  void Update(const std::vector<RelatedPlane>& planes, std::vector<PlaneRelation>& out);

  /// The estimator no longer has the plane; what was proposed of it may be proposed again.
  void Forget(PlaneId plane);

  void Clear();

 private:
  struct Evidence {
    int num_keyframes = 0;
    bool is_proposed = false;
  };

  void RelateToGravity(const RelatedPlane& plane, std::vector<PlaneRelation>& out);
  void RelateHeadings(const std::vector<RelatedPlane>& planes, std::vector<PlaneRelation>& out);
  bool Weigh(const PlaneRelation& relation, double angle, double sigma);

  PlaneRelationOptions options_;
  std::vector<PlaneId> headings_;  ///< one wall for each direction of the building and its normals
  std::map<std::pair<int, std::pair<PlaneId, PlaneId>>, Evidence> evidence_;
};

}  // namespace facet
