// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/horizon_mesh.h"

#include <algorithm>
#include <cmath>

#include "facet/mesh/vertex_normals.h"

namespace facet {
namespace {

constexpr double kGridPerPixel = 16;
constexpr double kMaxSlope = 10;  // |x/z| or |y/z| of a point that can be triangulated

bool IsUsable(const MeshPoint& point) {
  return point.id.IsValid() && point.xy.allFinite() && point.p_C.allFinite() &&
         std::isfinite(point.sigma_depth_m) && point.xy.cwiseAbs().maxCoeff() <= kMaxSlope;
}

bool ComesBefore(const MeshFace& a, const MeshFace& b) {
  return a.corners < b.corners;
}

/// Corners in ascending order; `is_flipped` tells whether that reverses the direction.
void SortCorners(MeshFace& face) {
  auto& c = face.corners;
  const auto swap_if = [&](int i, int j) {
    if (c[i] <= c[j]) return;
    std::swap(c[i], c[j]);
    face.is_flipped = !face.is_flipped;
  };
  swap_if(0, 1);
  swap_if(1, 2);
  swap_if(0, 1);
}

}  // namespace

HorizonMesh::HorizonMesh(const MeshOptions& options)
    : options_(options), check_(options.contradictions) {}

void HorizonMesh::Update(const MeshView& view, const MapSnapshot& snapshot, const SE3& T_BC) {
  lost_.clear();
  RefreshVertices(snapshot, T_BC);
  DropFaces();
  AddViewVertices(view);
  TriangulateView(view);
  if (options_.contradictions.by_triangulation) DropUntriangulated();
  if (options_.contradictions.by_view) DropContradicted(view);
  MergeViewFaces();
  DropUnusedVertices();
}

void HorizonMesh::Clear() {
  lost_.clear();
  for (const MeshFace& face : faces_)
    lost_.push_back(MakeLost(face));
  faces_.clear();
  vertices_.clear();
}

std::array<Vector3d, 3> HorizonMesh::Corners(const MeshFace& face) const {
  const auto [a, b, c] = face.CounterClockwise();
  return {vertices_[a].p_W, vertices_[b].p_W, vertices_[c].p_W};
}

LostFace HorizonMesh::MakeLost(const MeshFace& face) const {
  LostFace lost;
  lost.p_W = Corners(face);
  lost.plane_id = face.plane_id;
  const std::array<int, 3> corners = face.CounterClockwise();
  for (std::size_t i = 0; i < 3; ++i) {
    lost.intensity[i] = vertices_[corners[i]].intensity;
    lost.sigma_depth_m += vertices_[corners[i]].sigma_depth_m / 3;
  }
  return lost;
}

// Newest positions. A vertex that the horizon lost keeps its last one and is marked.
void HorizonMesh::RefreshVertices(const MapSnapshot& snapshot, const SE3& T_BC) {
  is_expired_.assign(vertices_.size(), 0);
  auto landmark = snapshot.landmarks.begin();
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    MeshVertex& vertex = vertices_[i];
    if (vertex.host.IsValid()) {
      const auto host = std::find_if(snapshot.keyframes.begin(),
                                     snapshot.keyframes.end(),
                                     [&](const KeyframePose& k) { return k.id == vertex.host; });
      is_expired_[i] = host == snapshot.keyframes.end() ? 1 : 0;
      if (is_expired_[i] == 0) vertex.p_W = host->T_WB * (T_BC * vertex.p_H);
      continue;
    }
    while (landmark != snapshot.landmarks.end() && landmark->id < vertex.id)
      ++landmark;
    const bool is_known = landmark != snapshot.landmarks.end() && landmark->id == vertex.id &&
                          landmark->p_W.allFinite();
    is_expired_[i] = is_known ? 0 : 1;
    if (!is_known) continue;
    vertex.p_W = landmark->p_W;
    vertex.sigma_depth_m = landmark->sigma_depth_m;
  }
}

// Takes away the faces with an expired vertex, and those whose shape is out of limits now.
void HorizonMesh::DropFaces() {
  std::erase_if(faces_, [this](MeshFace& face) {
    face.in_view = false;
    const auto [a, b, c] = face.corners;
    const bool has_good_shape = JudgeShape(Corners(face), options_.faces) == FaceVerdict::kAccepted;
    if (is_expired_[a] == 0 && is_expired_[b] == 0 && is_expired_[c] == 0) return !has_good_shape;
    if (has_good_shape && face.votes_against == 0) lost_.push_back(MakeLost(face));
    return true;
  });
}

// Merges the view's points into the vertices, both sorted by id. The order of the faces stays.
void HorizonMesh::AddViewVertices(const MeshView& view) {
  points_.clear();
  for (int i = 0; i < static_cast<int>(view.points.size()); ++i) {
    if (IsUsable(view.points[i])) points_.push_back(i);
  }
  const auto id_of = [&](int i) { return view.points[i].id; };
  std::sort(points_.begin(), points_.end(), [&](int i, int j) { return id_of(i) < id_of(j); });
  const auto same = [&](int i, int j) { return id_of(i) == id_of(j); };
  points_.erase(std::unique(points_.begin(), points_.end(), same), points_.end());

  merged_vertices_.clear();
  vertex_of_point_.clear();
  point_of_vertex_.clear();
  new_index_.assign(vertices_.size(), -1);
  std::size_t old = 0;
  const auto take_old = [&] {
    new_index_[old] = static_cast<int>(merged_vertices_.size());
    merged_vertices_.push_back(vertices_[old++]);
    point_of_vertex_.push_back(-1);
  };
  for (int i : points_) {
    const MeshPoint& point = view.points[i];
    while (old < vertices_.size() && vertices_[old].id < point.id)
      take_old();
    if (old < vertices_.size() && vertices_[old].id == point.id) {
      take_old();
    } else {
      merged_vertices_.push_back({});
      point_of_vertex_.push_back(-1);
    }
    MeshVertex& vertex = merged_vertices_.back();
    vertex.id = point.id;
    vertex.p_W = view.T_WC * point.p_C;
    vertex.sigma_depth_m = point.sigma_depth_m;
    vertex.intensity = point.intensity;
    vertex.host = IsSupport(point.id) ? view.frame : FrameId{};
    vertex.p_H = point.p_C;
    vertex_of_point_.push_back(static_cast<int>(merged_vertices_.size()) - 1);
    point_of_vertex_.back() = i;
  }
  while (old < vertices_.size())
    take_old();
  vertices_.swap(merged_vertices_);
  for (MeshFace& face : faces_) {
    for (int& corner : face.corners)
      corner = new_index_[corner];
  }
}

HorizonMesh::ViewFace HorizonMesh::MakeViewFace(const MeshView& view,
                                                const std::array<int, 3>& triangle) {
  ViewFace made;
  CameraFace seen;
  for (std::size_t i = 0; i < 3; ++i) {
    const MeshPoint& point = view.points[points_[triangle[i]]];
    seen.p_C[i] = point.p_C;
    seen.sigma_depth_m[i] = point.sigma_depth_m;
    made.face.corners[i] = vertex_of_point_[triangle[i]];
  }
  // In the image y points down: turning from x to y is clockwise seen by the camera.
  made.face.is_flipped = true;
  SortCorners(made.face);
  made.face.in_view = true;
  const FaceVerdict verdict = JudgeFace(seen, options_.faces);
  ++verdicts_[static_cast<std::size_t>(verdict)];
  made.is_accepted = verdict == FaceVerdict::kAccepted;
  made.face.may_vote =
      made.is_accepted && JudgeFace(seen, options_.voting) == FaceVerdict::kAccepted;
  return made;
}

void HorizonMesh::TriangulateView(const MeshView& view) {
  grid_.clear();
  for (int i : points_) {
    const Vector2d place = view.points[i].xy * (view.focal_px * kGridPerPixel);
    grid_.push_back({static_cast<std::int32_t>(std::lround(place.x())),
                     static_cast<std::int32_t>(std::lround(place.y()))});
  }
  view_faces_.clear();
  verdicts_.fill(0);
  for (const std::array<int, 3>& triangle : delaunay_.Triangulate(grid_))
    view_faces_.push_back(MakeViewFace(view, triangle));
  std::sort(view_faces_.begin(), view_faces_.end(), [](const ViewFace& a, const ViewFace& b) {
    return ComesBefore(a.face, b.face);
  });
}

// An old face whose corners are all seen must be a triangle of the view; if not, the view has
// others in its place.
void HorizonMesh::DropUntriangulated() {
  auto candidate = view_faces_.begin();
  std::erase_if(faces_, [&](const MeshFace& face) {
    for (int corner : face.corners) {
      if (point_of_vertex_[corner] < 0) return false;
    }
    while (candidate != view_faces_.end() && ComesBefore(candidate->face, face))
      ++candidate;
    return candidate == view_faces_.end() || candidate->face.corners != face.corners;
  });
}

void HorizonMesh::DropContradicted(const MeshView& view) {
  check_.Begin(view);
  const SE3 T_CW = view.T_WC.Inverse();
  const Matrix3d R_CW = T_CW.R();
  const auto project = [&](const MeshFace& face, ProjectedFace& projected) {
    std::array<Vector3d, 3> p = Corners(face);
    for (Vector3d& point : p)
      point = R_CW * point + T_CW.p;
    return ProjectFace(p, projected);
  };
  ProjectedFace projected;
  for (const ViewFace& seen : view_faces_) {
    if (seen.is_accepted && project(seen.face, projected)) check_.Draw(projected);
  }
  auto same = view_faces_.begin();
  std::erase_if(faces_, [&](MeshFace& face) {
    while (same != view_faces_.end() && ComesBefore(same->face, face))
      ++same;
    if (same != view_faces_.end() && same->face.corners == face.corners) return false;
    if (!project(face, projected)) return false;
    const auto [a, b, c] = face.corners;
    const FaceSighting sighting =
        check_.Judge(projected, {vertices_[a].id, vertices_[b].id, vertices_[c].id});
    face.votes_against += sighting.votes_against;
    return sighting.is_replaced || face.votes_against >= options_.contradictions.min_votes;
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
  new_index_.assign(vertices_.size(), -1);
  for (const MeshFace& face : faces_) {
    for (int corner : face.corners)
      new_index_[corner] = 0;
  }
  int count = 0;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (new_index_[i] < 0) continue;
    new_index_[i] = count;
    vertices_[count++] = vertices_[i];
  }
  vertices_.resize(static_cast<std::size_t>(count));
  for (MeshFace& face : faces_) {
    for (int& corner : face.corners)
      corner = new_index_[corner];
  }
}

TriangleMesh HorizonMesh::ToTriangleMesh() const {
  TriangleMesh mesh;
  mesh.vertices.reserve(vertices_.size());
  mesh.colours.reserve(vertices_.size());
  mesh.faces.reserve(faces_.size());
  mesh.plane_ids.reserve(faces_.size());
  for (const MeshVertex& vertex : vertices_) {
    mesh.vertices.push_back(vertex.p_W);
    mesh.colours.push_back({vertex.intensity, vertex.intensity, vertex.intensity});
  }
  for (const MeshFace& face : faces_) {
    mesh.faces.push_back(face.CounterClockwise());
    mesh.plane_ids.push_back(face.plane_id);
  }
  SetVertexNormals(mesh);
  return mesh;
}

}  // namespace facet
