// SPDX-License-Identifier: BSD-2-Clause
// What the rungs of the ladder tell the estimator about planes: from the truth at the top of the
// ladder, from the product's own search at its foot.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "bench/consistency_run.h"
#include "bench/oracle_planes.h"

#include "facet/mesh/horizon_mesh.h"
#include "facet/pipeline/mesh_view_builder.h"
#include "facet/regularities/plane_tracker.h"

namespace facet {

/// How the search's answers compare with the truth.
struct SearchQuality {
  int num_created = 0;
  int num_joined = 0;
  int num_wrong = 0;   ///< joined a plane most of whose landmarks lie on another surface
  int num_events = 0;  ///< WrongReassociation: one if there was an occasion
};

/// True planes with the landmarks of others: each landmark is said to lie on the plane after its
/// own. The estimator has to refuse them.
class PlaceboPlanes {
 public:
  explicit PlaceboPlanes(const SimulatedRun& run) : oracle_(run, OraclePlaneOptions()) {}

  PlaneAssignments operator()(const FrameObservations& observations, const MapSnapshot& snapshot);

 private:
  OraclePlanes oracle_;
  std::vector<PlaneId> planes_;
};

/// Adds to what another policy says: for one second, a fifth of all landmarks is put on some plane
/// where it does not belong, past the limits that the estimator sets on joining.
class SpoiledPlanes {
 public:
  SpoiledPlanes(PlanePolicy policy, double from_s) : policy_(std::move(policy)), from_s_(from_s) {}

  PlaneAssignments operator()(const FrameObservations& observations, const MapSnapshot& snapshot);

 private:
  PlanePolicy policy_;
  double from_s_;
  std::optional<Timestamp> first_t_;
};

/// Adds one mistake to what another policy says: the first plane that comes back after some seconds
/// out of sight, and has a nearly parallel neighbour, is taken for that neighbour for one second.
/// Its landmarks join the neighbour past the limits that the estimator sets on joining.
class WrongReassociation {
 public:
  static constexpr double kAway_s = 5, kLasts_s = 1;

  /// `quality` must outlive this and is added to.
  WrongReassociation(PlanePolicy policy, SearchQuality& quality)
      : policy_(std::move(policy)), quality_(quality) {}

  PlaneAssignments operator()(const FrameObservations& observations, const MapSnapshot& snapshot);

 private:
  void Begin(const PlaneAssignments& out, const MapSnapshot& snapshot);

  PlanePolicy policy_;
  SearchQuality& quality_;
  std::map<PlaneId, Timestamp> last_seen_;
  std::optional<Timestamp> began_;
  PlaneId returned_, neighbour_;
};

enum class Measurements {
  kDetected,  ///< by the product
  kTrue       ///< of all true surfaces, with their true planes as seen from the camera
};

/// The product's own search: mesh, detection, recognition, membership.
class OwnSearch {
 public:
  /// `quality` must outlive this and is added to.
  OwnSearch(const SimulatedRun& run,
            const MeshOptions& mesh,
            const RegularityOptions& options,
            Measurements measurements,
            SearchQuality& quality);
  OwnSearch(const OwnSearch&) = delete;
  OwnSearch& operator=(const OwnSearch&) = delete;

  PlaneAssignments operator()(const FrameObservations& observations, const MapSnapshot& snapshot);

 private:
  std::vector<PlaneCandidate> SeeTrueSurfaces(const SurfaceFaces& faces,
                                              std::vector<char> taken) const;
  void Judge(const PlaneAssignments& found);

  const SimulatedRun& run_;
  RegularityOptions options_;
  MeshViewBuilder view_builder_;
  HorizonMesh mesh_;
  PlaneTracker tracker_;
  SE3 T_WG_;  // from the truth's frame, where the newest poses agree
  std::map<PlaneId, std::map<PlaneId, int>> surfaces_of_plane_;
  SearchQuality& quality_;
};

}  // namespace facet
