// SPDX-License-Identifier: BSD-2-Clause
// What the planes of a building have in common (the paper's future work, section IV): walls stand
// upright, floors lie level, walls are parallel or at right angles to each other, tables have one
// height.
#pragma once

#include <map>
#include <optional>
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
  double area_m2 = 0;                      ///< of its extent
  Vector3d centroid_W = Vector3d::Zero();  ///< of its extent
};

/// Proposes relations that held for several keyframes in a row, each one once. Walls are related to
/// one wall per heading, level planes to one per height, oblique ones to one per direction, each
/// time to the largest at the moment of the choice. These are stars: a clique would count one fact
/// many times. Since walls are related to gravity as well, comparing their headings is enough.
/// Not thread-safe.
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

  /// How far two planes of one star are from the relation of that star.
  struct Difference {
    PlaneRelationKind kind;
    double value, limit;  // both [rad] or [m]
  };
  using Planes = std::vector<RelatedPlane>;

  void RelateToGravity(const RelatedPlane& plane, std::vector<PlaneRelation>& out);
  template <class Compare>
  void RelateStar(const Planes& planes,
                  PlaneOrientation orientation,
                  const Compare& compare,
                  std::vector<PlaneId>& middles,
                  std::vector<PlaneRelation>& out);
  /// These three are empty when the planes do not belong to one star.
  std::optional<Difference> CompareHeadings(const RelatedPlane& a, const RelatedPlane& b) const;
  std::optional<Difference> CompareHeights(const RelatedPlane& a, const RelatedPlane& b) const;
  std::optional<Difference> CompareSlopes(const RelatedPlane& a, const RelatedPlane& b) const;
  double AngleLimit(double sigma) const;
  bool Weigh(const PlaneRelation& relation, double difference, double limit);

  PlaneRelationOptions options_;
  /// The planes in the middle of the stars: one wall for each heading of the building, one level
  /// plane for each height, one oblique plane for each direction.
  std::vector<PlaneId> headings_, heights_, slopes_;
  std::map<std::pair<int, std::pair<PlaneId, PlaneId>>, Evidence> evidence_;
};

}  // namespace facet
