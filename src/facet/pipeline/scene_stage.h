// SPDX-License-Identifier: BSD-2-Clause
// Last part of a frame: the mesh over the landmarks, the map of the run, and the planes in it.
#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "facet/map/plane_record.h"
#include "facet/mesh/horizon_mesh.h"
#include "facet/mesh/surface_map.h"
#include "facet/pipeline/mesh_view_builder.h"
#include "facet/pipeline/tracked_frame.h"
#include "facet/pipeline/vio_options.h"
#include "facet/pipeline/vio_output.h"
#include "facet/regularities/constrain/projection_landmarks.h"
#include "facet/regularities/plane_tracker.h"

namespace facet {

/// For each frame UpdateMesh, FindPlanes and ShowPlanes are called in this order. They work on
/// keyframes with a pose, whose output has a snapshot; all others, and all frames if the mesh is
/// switched off, they pass over. Not thread-safe. Never throws for any content of the frame.
class SceneStage {
 public:
  SceneStage(const StereoRig& rig, const VioOptions& options);

  /// Merges the triangles between the keyframe's points into the horizon mesh; what leaves the
  /// horizon goes to the map. When the estimator has started over, everything does.
  void UpdateMesh(const TrackedFrame& frame, VioOutput& out);

  /// Pipelines SPR: planes in the mesh, recognised and given their landmarks; SP: the landmarks on
  /// some plane.
  RegularityResult FindPlanes(VioOutput& out);

  /// What the planes say about the mesh comes into force; the output gets the mesh.
  void ShowPlanes(const MeshRegularities& regularities, VioOutput& out);

  /// The next keyframe's output gets a SceneUpdate. May be called from any thread.
  void RequestUpdate() { is_update_wanted_ = true; }

  /// The mesh of the whole run so far, the horizon included; empty when the map is switched off.
  /// Its plane ids are those of Planes(). `memory`: what it takes up.
  std::optional<TriangleMesh> Map(MapMemory& memory) const;

  /// The same without a copy of what it is made from, which is gone then: no more frames may
  /// follow.
  std::optional<TriangleMesh> TakeMap(MapMemory& memory);

  /// Every plane that was ever a variable, in the order of their ids; empty but in pipeline SPR.
  std::optional<std::vector<PlaneRecord>> Planes() const;

 private:
  bool IsWorked(const VioOutput& out) const { return options_.enabled && out.snapshot; }
  void AddUpdate(VioOutput& out);
  void Reset();
  void KeepExpiredFaces();
  TriangleMesh MeshOf(SurfaceMap map, HorizonMesh horizon, MapMemory& memory) const;

  MeshOptions options_;
  SE3 T_BC_;
  MeshViewBuilder view_builder_;
  HorizonMesh horizon_;
  SurfaceMap map_;
  std::optional<PlaneTracker> planes_;              // pipeline SPR
  std::optional<ProjectionLandmarks> projections_;  // pipeline SP
  SearchMesh search_mesh_;                          // keeps its storage
  std::atomic<bool> is_update_wanted_ = false;
};

}  // namespace facet
