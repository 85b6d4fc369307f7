// SPDX-License-Identifier: BSD-2-Clause
// Joins what the front end saw with what the estimator knows, for the mesh.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "facet/camera/stereo_rig.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/observation.h"
#include "facet/mesh/border_points.h"
#include "facet/mesh/horizon_mesh.h"
#include "facet/mesh/mesh_snapshot.h"
#include "facet/mesh/surface_map.h"
#include "facet/pipeline/front_stage.h"

namespace facet {

/// Not thread-safe. Never throws for any content of the observations.
class MeshStage {
 public:
  /// `planes_judge`: JudgeBy will be called.
  MeshStage(const StereoRig& rig, const MeshOptions& options, bool planes_judge = false);

  /// A keyframe with a pose. Null when the mesh is switched off.
  std::shared_ptr<MeshSnapshot> Process(const FrameObservations& observations,
                                        const MeshPacket& images,
                                        const MapSnapshot& snapshot);

  /// Which plane each face of the last snapshot is on, -1: none. The map keeps it.
  void SetFacePlanes(std::span<const int> planes) { horizon_.SetFacePlanes(planes); }

  /// See HorizonMesh::SetDepthScales.
  void SetDepthScales(std::span<const double> scales) { horizon_.SetDepthScales(scales); }

  /// Judges the horizon's triangles as they are shown. What it finds is shown from now on.
  using TriangleJudge = std::function<std::vector<FaceStanding>(
      std::span<const MeshVertex> vertices, std::span<const std::array<int, 3>> triangles)>;
  void JudgeBy(const TriangleJudge& judge);

  /// The last snapshot as planes left it.
  MeshSnapshot Shown() const { return MakeShownSnapshot(view_, horizon_); }

  /// The estimator started over: what was in the horizon stays in the map as it is.
  void Reset();

  /// The map of the run so far, horizon included; empty when it is switched off.
  std::optional<TriangleMesh> Map() const;
  /// Of what Map returns.
  MapMemory map_memory() const { return WithHorizon(map_, horizon_).memory(); }

 private:
  void KeepLostFaces();
  void FillView(const FrameObservations& observations,
                const MeshPacket& images,
                const MapSnapshot& snapshot);
  void AddUnknownCorner(const FeatureObservation& feature,
                        double inverse_depth,
                        std::uint8_t intensity);
  void AddSupport(const MeshPacket& images);
  void AddBorder();

  MeshOptions options_;
  CameraModel camera_;
  SE3 T_BC_;
  double baseline_focal_px_;
  std::vector<Vector2d> border_xy_;  // places on the image's border, undistorted
  BorderPoints border_;
  std::vector<MeshPoint> found_;  // buffer of AddBorder
  HorizonMesh horizon_;
  SurfaceMap map_;
  MeshView view_;
  std::int64_t next_support_id_ = kFirstSupportId;
};

}  // namespace facet
