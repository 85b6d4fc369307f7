// SPDX-License-Identifier: BSD-2-Clause
// The vertices of the horizon mesh: landmarks where the estimator has them now, and support points
// carried by the keyframe that matched them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "facet/map/map_snapshot.h"
#include "facet/mesh/mesh_face.h"
#include "facet/mesh/mesh_view.h"

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

/// Sorted by id. Faces hold indices: what renumbers the vertices says so. Keeps its buffers; not
/// thread-safe.
class HorizonVertices {
 public:
  const std::vector<MeshVertex>& all() const { return vertices_; }
  const MeshVertex& operator[](int i) const { return vertices_[static_cast<std::size_t>(i)]; }
  std::size_t size() const { return vertices_.size(); }
  void Clear() { vertices_.clear(); }

  /// Takes the newest positions. A vertex that the estimator has forgotten keeps its last one, and
  /// expires when it has been forgotten for `horizon`.
  void Refresh(Timestamp t, Duration horizon, const MapSnapshot& snapshot, const SE3& T_BC);
  bool IsExpired(int i) const { return is_expired_[static_cast<std::size_t>(i)] != 0; }

  /// Adds or moves the vertices of these points of the view (sorted by id). Renumbers.
  void Add(const MeshView& view, std::span<const int> points);
  /// The vertex of the k-th point of the last Add, and whether a vertex is one of its points.
  int VertexOfPoint(int k) const { return vertex_of_point_[static_cast<std::size_t>(k)]; }
  bool IsInView(int vertex) const { return is_in_view_[static_cast<std::size_t>(vertex)] != 0; }

  /// Drops the vertices that are a corner of none of these faces. Renumbers.
  void KeepCornersOf(std::initializer_list<const std::vector<MeshFace>*> faces);

  /// After Add and KeepCornersOf: gives the corners of faces their new indices.
  void Renumber(std::vector<MeshFace>& faces) const;

  /// The first of the support points that this keyframe carries; size() if there are none.
  std::size_t FirstCarriedBy(FrameId host) const;
  /// Shows a vertex where its own depth times the factor puts it; only for vertices with a host.
  void ShowAt(std::size_t i, double depth_scale, const Vector3d& shown_W);

 private:
  bool RefreshLandmark(std::vector<LandmarkEstimate>::const_iterator& landmark,
                       std::vector<LandmarkEstimate>::const_iterator end,
                       MeshVertex& vertex) const;

  std::vector<MeshVertex> vertices_;
  std::vector<char> is_expired_;      // by vertex
  std::vector<int> vertex_of_point_;  // by point of the last Add
  std::vector<char> is_in_view_;      // by vertex
  std::vector<int> new_index_;        // by earlier vertex, -1: dropped
  std::vector<MeshVertex> merged_;    // buffer of Add
};

}  // namespace facet
