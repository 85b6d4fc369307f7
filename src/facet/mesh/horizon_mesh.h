// SPDX-License-Identifier: BSD-2-Clause
// The mesh over the landmarks of the estimator's horizon (paper II-A.1 and II-A.2): each keyframe's
// triangles are lifted, filtered and merged in; faces go when a vertex leaves the horizon or when
// newer sightings contradict them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "facet/map/map_snapshot.h"
#include "facet/mesh/delaunay.h"
#include "facet/mesh/face_filter.h"
#include "facet/mesh/face_standing.h"
#include "facet/mesh/mesh_view.h"
#include "facet/mesh/triangle_mesh.h"
#include "facet/mesh/triangle_stars.h"
#include "facet/mesh/view_check.h"

namespace facet {

struct MeshVertex {
  LandmarkId id;
  Vector3d p_W = Vector3d::Zero();
  double sigma_depth_m = 0;
  std::uint8_t intensity = 0;
  Timestamp last_known;  ///< newest keyframe after which the estimator still had it
  /// Support points are carried by the keyframe that saw them; landmarks have none.
  FrameId host;
  Vector3d p_H = Vector3d::Zero();  ///< in the host's left camera, as matched
  double depth_scale = 1;           ///< what is shown is p_H times this
  Vector3d shown_W = Vector3d::Zero();
};

struct MeshFace {
  /// Vertex indices, ascending.
  std::array<int, 3> corners{};
  /// Whether the corners must be read backwards to go counter-clockwise seen by the camera.
  bool is_flipped = false;
  bool may_vote = false;  ///< passed the strict limits: may vote for planes
  bool in_view = false;   ///< one of the newest keyframe's own faces
  int votes_against = 0;  ///< sightings through it
  int plane_id = -1;
  bool by_plane = false;   ///< rejected by the tests, shown because a known plane says so
  bool is_hidden = false;  ///< known planes say that there is no surface
  /// Of the sides opposite to the corners: whether the newest view that has it shows nothing
  /// beyond.
  std::array<bool, 3> is_rim{};
  /// The camera of the newest keyframe whose triangulation has it.
  Eigen::Vector3f eye_W = Eigen::Vector3f::Zero();

  /// Corners counter-clockwise as the camera saw them; the normal points to the camera.
  std::array<int, 3> CounterClockwise() const {
    if (is_flipped) return {corners[0], corners[2], corners[1]};
    return corners;
  }
};

/// A face that left the horizon, with its last estimate, without having been proven wrong.
struct LostFace {
  std::array<Vector3d, 3> p_W;  ///< counter-clockwise seen by the camera
  std::array<std::uint8_t, 3> intensity{};
  double sigma_depth_m = 0;  ///< mean of the vertices
  int plane_id = -1;
  std::optional<Vector3d> eye_W;  ///< the camera that saw it last, if known
  /// Of the sides opposite to p_W: no surface was seen beyond. Faces that newer ones cover have no
  /// rim, as it is for these to say what lies beyond.
  std::array<bool, 3> is_rim{};
};

/// Not thread-safe. Never throws for any content of the view; without a pose or a focal length it
/// is ignored.
///
/// Between calls: vertices are sorted by id and each is a corner of some face, or was one of a
/// rejected triangle of the last view; faces are sorted by their corners, no two are the same, and
/// every vertex is a landmark of the last snapshot, a support point of one of its keyframes, or was
/// so at most options.horizon_s ago.
class HorizonMesh {
 public:
  /// `keeps_rejected`: so that known planes can judge them.
  explicit HorizonMesh(const MeshOptions& options, bool keeps_rejected = false);

  /// The points of a new keyframe and what the estimator knows after it. T_BC: left camera of the
  /// rig.
  void Update(const MeshView& view, const MapSnapshot& snapshot, const SE3& T_BC);

  /// The plane of each of faces() that is not `by_plane`, -1: none.
  void SetFacePlanes(std::span<const int> planes);

  /// Better depths of the support points that the newest keyframe carries: a factor for each of
  /// vertices(). Only shown: faces are judged by, and go to the map with, the depths as matched.
  void SetDepthScales(std::span<const double> scales);

  /// What known planes may judge: faces(), then the newest view's triangles that were rejected.
  std::vector<std::array<int, 3>> Triangles() const;
  /// What they say of each of Triangles(). Bridges are hidden, and stay otherwise what they were;
  /// rejected triangles on a plane become faces, for as long as they are on one.
  void SetStandings(std::span<const FaceStanding> standings);

  /// Every face leaves: the world has changed or the run is over.
  void Clear();

  const std::vector<MeshVertex>& vertices() const { return vertices_; }
  const std::vector<MeshFace>& faces() const { return faces_; }
  /// Faces that the last call took away because a vertex left the horizon, or because newer faces
  /// cover them.
  const std::vector<LostFace>& lost() const { return lost_; }
  /// How the triangles of the last view were judged.
  const std::array<int, static_cast<int>(FaceVerdict::kCount)>& verdicts() const {
    return verdicts_;
  }

  /// Where they are shown, in W.
  std::vector<Vector3d> ShownVertices() const;

  /// Without what is shown because of planes; as matched, with normals, intensities as grey, plane
  /// ids.
  TriangleMesh ToTriangleMesh() const;

 private:
  struct ViewFace {
    MeshFace face;
    bool is_accepted = false;
  };
  struct PlacedTriangle {
    std::array<int, 3> points;  // into points_
    CameraFace seen;
    FaceVerdict verdict = FaceVerdict::kAccepted;
  };

  void RefreshVertices(Timestamp t, const MapSnapshot& snapshot, const SE3& T_BC);
  void DropFaces();
  void AddViewVertices(const MeshView& view);
  void TriangulateView(const MeshView& view);
  void JudgeTriangles(const MeshView& view);
  bool IsRim(const PlacedTriangle& triangle, std::size_t corner) const;
  bool HasPlaneCorner(const MeshView& view, const PlacedTriangle& triangle) const;
  ViewFace MakeViewFace(const PlacedTriangle& triangle) const;
  void DropUntriangulated();
  void ProjectVertices(const SE3& T_WC);
  void DropContradicted(const MeshView& view);
  void MergeViewFaces();
  void KeepRejected();
  void DropUnusedVertices();
  void RescuePlanes(const MeshView& view);
  LostFace MakeLost(const MeshFace& face) const;
  std::array<Vector3d, 3> Corners(const MeshFace& face) const;

  MeshOptions options_;
  bool keeps_rejected_;
  FaceFilter shown_, voting_, rescued_;  // what a face has to be for each
  Delaunay delaunay_;
  ViewCheck check_;
  std::vector<MeshVertex> vertices_;
  std::vector<MeshFace> faces_;
  std::vector<MeshFace> rejected_;  // of the newest view, sorted by corners
  std::vector<LostFace> lost_;
  FrameId newest_;
  Vector3d camera_W_ = Vector3d::Zero();  // of the newest keyframe
  std::array<int, static_cast<int>(FaceVerdict::kCount)> verdicts_{};
  // Buffers
  std::vector<char> is_expired_;           // by vertex
  std::vector<ProjectedPoint> projected_;  // by vertex, in the newest view
  std::vector<int> points_;                // usable points of the view, sorted by id
  std::vector<GridPoint> grid_;            // of points_
  std::vector<int> vertex_of_point_;       // of points_
  std::vector<int> point_of_vertex_;       // index into the view's points, -1: not seen
  std::vector<int> new_index_;
  std::vector<MeshVertex> merged_vertices_;
  std::vector<PlacedTriangle> triangles_;
  TriangleStars stars_;  // of triangles_, by point
  std::vector<ViewFace> view_faces_;
  std::vector<MeshFace> merged_faces_;
};

}  // namespace facet
