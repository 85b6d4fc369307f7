// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/horizon_mesh.h"

#include <algorithm>

#include "facet/mesh/vertex_normals.h"

namespace facet {
namespace {

// A face is wrong when so many landmarks were seen behind it: single mismatches do not tear holes.
constexpr int kMaxSeenThrough = 3;

/// Corners in ascending order; `is_flipped` tells whether that reverses the direction.
void SortCorners(MeshFace& face) {
  auto& c = face.corners;
  const auto swap_if = [&](int i, int j) {
    if (c[i] <= c[j]) return;
    std::swap(c[i], c[j]);
    std::swap(face.is_boundary[i], face.is_boundary[j]);
    face.is_flipped = !face.is_flipped;
  };
  swap_if(0, 1);
  swap_if(1, 2);
  swap_if(0, 1);
}

}  // namespace

HorizonMesh::HorizonMesh(const MeshOptions& options, bool keeps_rejected)
    : options_(options), keeps_rejected_(keeps_rejected), triangulation_(options) {}

void HorizonMesh::Update(const MeshView& view, const MapSnapshot& snapshot, const SE3& T_BC) {
  expired_.clear();
  rejected_.clear();
  if (!IsUsable(view)) return;
  newest_ = {view.frame, view.T_WC.p};
  vertices_.Refresh(view.t, FromSeconds(options_.horizon_s), snapshot, T_BC);
  DropFaces();
  triangulation_.Build(view);
  vertices_.Add(view, triangulation_.points());
  vertices_.Renumber(faces_);
  MakeViewFaces();
  if (options_.contradictions.by_triangulation) DropUntriangulated();
  if (options_.contradictions.by_view) DropContradicted(view);
  MergeViewFaces();
  KeepRejected();
  DropUnusedVertices();
}

void HorizonMesh::Clear() {
  expired_.clear();
  for (const MeshFace& face : faces_)
    expired_.push_back(MakeExpired(face));
  faces_.clear();
  rejected_.clear();
  vertices_.Clear();
}

std::array<Vector3d, 3> HorizonMesh::Corners(const MeshFace& face) const {
  const auto [a, b, c] = face.CounterClockwise();
  return {vertices_[a].p_W, vertices_[b].p_W, vertices_[c].p_W};
}

ExpiredFace HorizonMesh::MakeExpired(const MeshFace& face) const {
  ExpiredFace expired;
  expired.p_W = Corners(face);
  expired.plane_id = face.plane_id;
  expired.eye_W = face.eye_W.cast<double>();
  expired.is_boundary = face.is_boundary;
  if (face.is_flipped) std::swap(expired.is_boundary[1], expired.is_boundary[2]);
  const std::array<int, 3> corners = face.CounterClockwise();
  for (std::size_t i = 0; i < 3; ++i) {
    expired.intensity[i] = vertices_[corners[i]].intensity;
    expired.sigma_depth_m += vertices_[corners[i]].sigma_depth_m / 3;
  }
  return expired;
}

// Takes away the faces with an expired vertex, and those whose shape is out of limits now.
void HorizonMesh::DropFaces() {
  std::erase_if(faces_, [this](MeshFace& face) {
    face.in_view = false;
    const auto [a, b, c] = face.corners;
    const bool has_good_shape = triangulation_.HasGoodShape(Corners(face));
    if (!vertices_.IsExpired(a) && !vertices_.IsExpired(b) && !vertices_.IsExpired(c))
      return !has_good_shape;
    if (has_good_shape) expired_.push_back(MakeExpired(face));
    return true;
  });
}

HorizonMesh::ViewFace HorizonMesh::MakeViewFace(const ViewTriangulation::Triangle& triangle) const {
  ViewFace made;
  made.is_accepted = triangle.IsAccepted();
  for (std::size_t i = 0; i < 3; ++i) {
    made.face.corners[i] = vertices_.VertexOfPoint(triangle.points[i]);
    if (made.is_accepted || keeps_rejected_)
      made.face.is_boundary[i] = triangulation_.IsBoundary(triangle, i);
  }
  // In the image y points down: turning from x to y is clockwise seen by the camera.
  made.face.is_flipped = true;
  SortCorners(made.face);
  made.face.in_view = true;
  made.face.may_vote = triangulation_.MayVote(triangle);
  made.face.eye_W = newest_.camera_W.cast<float>();
  return made;
}

void HorizonMesh::MakeViewFaces() {
  view_faces_.clear();
  for (const ViewTriangulation::Triangle& triangle : triangulation_.triangles())
    view_faces_.push_back(MakeViewFace(triangle));
  std::sort(view_faces_.begin(), view_faces_.end(), [](const ViewFace& a, const ViewFace& b) {
    return ComesBefore(a.face, b.face);
  });
}

// An old face whose corners are all seen must be a triangle of the view; if not, the view has
// others in its place.
void HorizonMesh::DropUntriangulated() {
  auto candidate = view_faces_.begin();
  std::erase_if(faces_, [&](const MeshFace& face) {
    for (const int corner : face.corners) {
      if (!vertices_.IsInView(corner)) return false;
    }
    while (candidate != view_faces_.end() && ComesBefore(candidate->face, face))
      ++candidate;
    return candidate == view_faces_.end() || candidate->face.corners != face.corners;
  });
}

void HorizonMesh::ProjectVertices(const SE3& T_WC) {
  const SE3 T_CW = T_WC.Inverse();
  const Matrix3d R_CW = T_CW.R();
  projected_.clear();
  for (const MeshVertex& vertex : vertices_.all())
    projected_.push_back(check_.Project(R_CW * vertex.p_W + T_CW.p));
}

void HorizonMesh::DropContradicted(const MeshView& view) {
  check_.Begin(view);
  ProjectVertices(view.T_WC);
  const auto projection = [this](const MeshFace& face) {
    const auto [a, b, c] = face.corners;
    return ProjectedFace{projected_[a], projected_[b], projected_[c]};
  };
  for (const ViewFace& seen : view_faces_) {
    if (seen.is_accepted) check_.Draw(projection(seen.face));
  }
  auto same = view_faces_.begin();
  std::erase_if(faces_, [&](MeshFace& face) {
    while (same != view_faces_.end() && ComesBefore(same->face, face))
      ++same;
    if (same != view_faces_.end() && same->face.corners == face.corners) return false;
    const auto [a, b, c] = face.corners;
    const FaceVisibility visibility =
        check_.Judge(projection(face), {vertices_[a].id, vertices_[b].id, vertices_[c].id});
    face.num_seen_through += visibility.num_seen_through;
    if (visibility.is_covered) {
      expired_.push_back(MakeExpired(face));
      expired_.back().is_boundary.fill(false);
    }
    return visibility.is_covered || face.num_seen_through >= kMaxSeenThrough;
  });
}

// Set union; where both have a face, the view's is taken.
void HorizonMesh::MergeViewFaces() {
  merged_faces_.clear();
  auto old = faces_.begin();
  for (const ViewFace& seen : view_faces_) {
    if (!seen.is_accepted) continue;
    while (old != faces_.end() && ComesBefore(*old, seen.face))
      merged_faces_.push_back(*old++);
    merged_faces_.push_back(seen.face);
    if (old == faces_.end() || old->corners != seen.face.corners) continue;
    merged_faces_.back().plane_id = old->plane_id;
    ++old;
  }
  merged_faces_.insert(merged_faces_.end(), old, faces_.end());
  faces_.swap(merged_faces_);
}

void HorizonMesh::DropUnusedVertices() {
  vertices_.KeepCornersOf({&faces_, &rejected_});
  vertices_.Renumber(faces_);
  vertices_.Renumber(rejected_);
}

TriangleMesh HorizonMesh::ToTriangleMesh() const {
  TriangleMesh mesh;
  mesh.vertices.reserve(vertices_.size());
  mesh.colours.reserve(vertices_.size());
  mesh.faces.reserve(faces_.size());
  mesh.plane_ids.reserve(faces_.size());
  for (const MeshVertex& vertex : vertices_.all()) {
    mesh.vertices.push_back(vertex.p_W);
    mesh.colours.push_back({vertex.intensity, vertex.intensity, vertex.intensity});
  }
  for (const MeshFace& face : faces_) {
    if (face.by_plane) continue;
    mesh.faces.push_back(face.CounterClockwise());
    mesh.plane_ids.push_back(face.plane_id);
  }
  SetVertexNormals(mesh);
  return mesh;
}

}  // namespace facet
