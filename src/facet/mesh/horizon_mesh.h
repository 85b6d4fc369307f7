// SPDX-License-Identifier: BSD-2-Clause
// The mesh over the landmarks of the estimator's horizon (paper II-A.1 and II-A.2): each keyframe's
// triangles are lifted, filtered and merged in; faces go when a vertex leaves the horizon or when
// newer views contradict them.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "facet/map/map_snapshot.h"
#include "facet/mesh/horizon_vertices.h"
#include "facet/mesh/mesh_face.h"
#include "facet/mesh/mesh_regularities.h"
#include "facet/mesh/mesh_view.h"
#include "facet/mesh/search_mesh.h"
#include "facet/mesh/triangle_mesh.h"
#include "facet/mesh/view_check.h"
#include "facet/mesh/view_triangulation.h"

namespace facet {

/// Not thread-safe. Never throws for any content of the view; without a pose or a focal length it
/// is ignored.
///
/// Between calls: vertices are sorted by id and each is a corner of some face, or was one of a
/// rejected triangle of the last view; faces are sorted by their corners, no two are the same, and
/// every vertex is a landmark of the last snapshot, a support point of one of its keyframes, or was
/// so at most options.horizon_s ago.
class HorizonMesh {
 public:
  /// `keeps_rejected`: so that planes can judge them.
  explicit HorizonMesh(const MeshOptions& options, bool keeps_rejected = false);

  /// The points of a new keyframe and what the estimator knows after it. T_BC: left camera of the
  /// rig.
  void Update(const MeshView& view, const MapSnapshot& snapshot, const SE3& T_BC);

  /// What the search for planes gets of the last update; `out` keeps its storage.
  void FillSearchMesh(const MeshView& view, SearchMesh& out) const;

  /// Applies to the search mesh what is known of planes: faces get the ids of their planes; the
  /// support points of the newest keyframe are shown where planes put them; bridges are hidden;
  /// rejected triangles on a plane become faces, for as long as they are on one. Only the plane ids
  /// reach the map and the next search.
  void Take(const MeshRegularities& regularities);

  /// Every face leaves: the world has changed or the run is over.
  void Clear();

  const std::vector<MeshVertex>& vertices() const { return vertices_.all(); }
  const std::vector<MeshFace>& faces() const { return faces_; }
  /// Faces that the last call took away because a vertex left the horizon, or because newer faces
  /// cover them.
  const std::vector<ExpiredFace>& expired() const { return expired_; }

  /// Without what is shown because of planes; as matched, with normals, intensities as grey, plane
  /// ids.
  TriangleMesh ToTriangleMesh() const;

 private:
  /// A triangle of the view over the vertices of the horizon.
  struct ViewFace {
    MeshFace face;
    bool is_accepted = false;
  };

  void DropFaces();
  void MakeViewFaces();
  ViewFace MakeViewFace(const ViewTriangulation::Triangle& triangle) const;
  void DropUntriangulated();
  void ProjectVertices(const SE3& T_WC);
  void DropContradicted(const MeshView& view);
  void MergeViewFaces();
  void KeepRejected();
  void DropUnusedVertices();
  void SetFacePlanes(std::span<const int> planes);
  void SetDepthScales(std::span<const double> scales);
  void SetVerdicts(std::span<const TriangleVerdict> verdicts);
  ExpiredFace MakeExpired(const MeshFace& face) const;
  std::array<Vector3d, 3> Corners(const MeshFace& face) const;

  MeshOptions options_;
  bool keeps_rejected_;
  ViewTriangulation triangulation_;
  ViewCheck check_;
  HorizonVertices vertices_;
  std::vector<MeshFace> faces_;
  std::vector<MeshFace> rejected_;  // of the newest view, sorted by corners
  std::vector<ExpiredFace> expired_;
  struct {
    FrameId frame;
    Vector3d camera_W = Vector3d::Zero();
  } newest_;                               // the newest keyframe
  std::vector<ViewFace> view_faces_;       // sorted by corners
  std::vector<MeshFace> merged_faces_;     // buffer
  std::vector<ProjectedPoint> projected_;  // by vertex, in the newest view
};

}  // namespace facet
