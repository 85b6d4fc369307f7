// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/horizon_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facet/base/check.h"
#include "facet/mesh/vertex_normals.h"

namespace facet {
namespace {

constexpr double kGridPerPixel = 16;
constexpr double kMaxSlope = 10;  // |x/z| or |y/z| of a point that can be triangulated

bool IsUsable(const MeshPoint& point) {
  return point.id.IsValid() && point.xy.allFinite() && point.p_C.allFinite() &&
         std::isfinite(point.sigma_depth_m) && point.xy.cwiseAbs().maxCoeff() <= kMaxSlope;
}

bool IsUsable(const MeshView& view) {
  constexpr double kMaxFocal_px = 1e5;  // of the grid of the triangulation
  return view.T_WC.p.allFinite() && view.T_WC.q.coeffs().allFinite() && view.focal_px > 0 &&
         view.focal_px <= kMaxFocal_px;
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
    std::swap(face.is_rim[i], face.is_rim[j]);
    face.is_flipped = !face.is_flipped;
  };
  swap_if(0, 1);
  swap_if(1, 2);
  swap_if(0, 1);
}

FaceLimits RescueLimits(const MeshOptions& options) {
  FaceLimits limits = options.faces;
  limits.min_elongation = options.plane_rescue.min_elongation;
  limits.max_grazing_deg = options.plane_rescue.max_grazing_deg;
  limits.max_side_per_depth = options.plane_rescue.max_side_per_depth;
  return limits;
}

struct CameraPlace {
  Matrix3d R_WC;
  Vector3d p_W;
  Vector3d operator()(const Vector3d& p_C) const { return R_WC * p_C + p_W; }
};

std::optional<CameraPlace> FindCamera(const MapSnapshot& snapshot, FrameId id, const SE3& T_BC) {
  const auto found = std::find_if(snapshot.keyframes.begin(),
                                  snapshot.keyframes.end(),
                                  [&](const KeyframePose& k) { return k.id == id; });
  if (found == snapshot.keyframes.end()) return std::nullopt;
  const SE3 T_WC = found->T_WB * T_BC;
  return CameraPlace{T_WC.R(), T_WC.p};
}

}  // namespace

HorizonMesh::HorizonMesh(const MeshOptions& options, bool keeps_rejected)
    : options_(options),
      keeps_rejected_(keeps_rejected),
      shown_(options.faces),
      voting_(options.voting),
      rescued_(RescueLimits(options)),
      check_(options.contradictions) {}

void HorizonMesh::Update(const MeshView& view, const MapSnapshot& snapshot, const SE3& T_BC) {
  lost_.clear();
  rejected_.clear();
  if (!IsUsable(view)) return;
  newest_ = view.frame;
  camera_W_ = view.T_WC.p;
  RefreshVertices(view.t, snapshot, T_BC);
  DropFaces();
  AddViewVertices(view);
  TriangulateView(view);
  if (options_.contradictions.by_triangulation) DropUntriangulated();
  if (options_.contradictions.by_view) DropContradicted(view);
  MergeViewFaces();
  KeepRejected();
  DropUnusedVertices();
}

void HorizonMesh::Clear() {
  lost_.clear();
  for (const MeshFace& face : faces_)
    lost_.push_back(MakeLost(face));
  faces_.clear();
  rejected_.clear();
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
  lost.eye_W = face.eye_W.cast<double>();
  lost.is_rim = face.is_rim;
  if (face.is_flipped) std::swap(lost.is_rim[1], lost.is_rim[2]);
  const std::array<int, 3> corners = face.CounterClockwise();
  for (std::size_t i = 0; i < 3; ++i) {
    lost.intensity[i] = vertices_[corners[i]].intensity;
    lost.sigma_depth_m += vertices_[corners[i]].sigma_depth_m / 3;
  }
  return lost;
}

// Newest positions. A vertex that the estimator has forgotten keeps its last one, and expires.
// Support points of one keyframe follow each other.
void HorizonMesh::RefreshVertices(Timestamp t, const MapSnapshot& snapshot, const SE3& T_BC) {
  is_expired_.assign(vertices_.size(), 0);
  const Duration horizon = FromSeconds(options_.horizon_s);
  auto landmark = snapshot.landmarks.begin();
  FrameId host;
  std::optional<CameraPlace> to_W;  // of the host
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    MeshVertex& vertex = vertices_[i];
    bool is_known = false;
    if (vertex.host.IsValid()) {
      if (vertex.host != host) {
        host = vertex.host;
        to_W = FindCamera(snapshot, host, T_BC);
      }
      is_known = to_W.has_value();
      if (is_known) {
        vertex.p_W = (*to_W)(vertex.p_H);
        vertex.shown_W = (*to_W)(vertex.depth_scale * vertex.p_H);
      }
    } else {
      while (landmark != snapshot.landmarks.end() && landmark->id < vertex.id)
        ++landmark;
      is_known = landmark != snapshot.landmarks.end() && landmark->id == vertex.id &&
                 landmark->p_W.allFinite();
      if (is_known) vertex.p_W = vertex.shown_W = landmark->p_W;
      if (is_known) vertex.sigma_depth_m = landmark->sigma_depth_m;
    }
    if (is_known) vertex.last_known = t;
    is_expired_[i] = !is_known && t - vertex.last_known >= horizon ? 1 : 0;
  }
}

// Takes away the faces with an expired vertex, and those whose shape is out of limits now.
void HorizonMesh::DropFaces() {
  std::erase_if(faces_, [this](MeshFace& face) {
    face.in_view = false;
    const auto [a, b, c] = face.corners;
    const bool has_good_shape = shown_.JudgeShape(Corners(face)) == FaceVerdict::kAccepted;
    if (is_expired_[a] == 0 && is_expired_[b] == 0 && is_expired_[c] == 0) return !has_good_shape;
    if (has_good_shape) lost_.push_back(MakeLost(face));
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
    vertex.p_W = vertex.shown_W = view.T_WC * point.p_C;
    vertex.sigma_depth_m = point.sigma_depth_m;
    vertex.intensity = point.intensity;
    vertex.host = IsSupport(point.id) ? view.frame : FrameId{};
    vertex.p_H = point.p_C;
    vertex.depth_scale = 1;
    vertex.last_known = view.t;
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

void HorizonMesh::JudgeTriangles(const MeshView& view) {
  triangles_.clear();
  for (const std::array<int, 3>& corners : delaunay_.Triangulate(grid_)) {
    PlacedTriangle& triangle = triangles_.emplace_back();
    triangle.points = corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const MeshPoint& point = view.points[points_[corners[i]]];
      triangle.seen.p_C[i] = point.p_C;
      triangle.seen.sigma_depth_m[i] = point.sigma_depth_m;
    }
    triangle.verdict = shown_.Judge(triangle.seen);
  }
}

// Whether all points around one of the corners lie in the triangle's plane.
bool HorizonMesh::HasPlaneCorner(const MeshView& view, const PlacedTriangle& triangle) const {
  constexpr std::size_t kMinStar = 4;  // fewer triangles around a corner say little
  const auto& [a, b, c] = triangle.seen.p_C;
  const Vector3d n_C = (b - a).cross(c - a).normalized();
  const double slope = std::tan(options_.plane_rescue.max_deviation_deg * std::numbers::pi / 180);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const int centre = triangle.points[corner];
    const std::span<const int> star = stars_.Around(centre);
    if (star.size() < kMinStar) continue;
    const auto lies_in_plane = [&](int other) {
      const MeshPoint& point = view.points[points_[other]];
      const Vector3d d = point.p_C - triangle.seen.p_C[corner];
      const double noise = std::abs(n_C.dot(point.p_C)) / point.p_C.z() * point.sigma_depth_m;
      return std::abs(n_C.dot(d)) <= slope * d.norm() + noise;
    };
    const bool is_plane = std::all_of(star.begin(), star.end(), [&](int t) {
      const auto& points = triangles_[t].points;
      return std::all_of(points.begin(), points.end(), lies_in_plane);
    });
    if (is_plane) return true;
  }
  return false;
}

// Whether no accepted triangle lies beyond the side opposite to a corner.
bool HorizonMesh::IsRim(const PlacedTriangle& triangle, std::size_t corner) const {
  const int from = triangle.points[(corner + 1) % 3], to = triangle.points[(corner + 2) % 3];
  const std::span<const int> star = stars_.Around(from);
  return std::none_of(star.begin(), star.end(), [&](int t) {
    const PlacedTriangle& other = triangles_[t];
    return other.verdict == FaceVerdict::kAccepted && other.points != triangle.points &&
           std::find(other.points.begin(), other.points.end(), to) != other.points.end();
  });
}

HorizonMesh::ViewFace HorizonMesh::MakeViewFace(const PlacedTriangle& triangle) const {
  ViewFace made;
  made.is_accepted = triangle.verdict == FaceVerdict::kAccepted;
  for (std::size_t i = 0; i < 3; ++i) {
    made.face.corners[i] = vertex_of_point_[triangle.points[i]];
    if (made.is_accepted || keeps_rejected_) made.face.is_rim[i] = IsRim(triangle, i);
  }
  // In the image y points down: turning from x to y is clockwise seen by the camera.
  made.face.is_flipped = true;
  SortCorners(made.face);
  made.face.in_view = true;
  made.face.may_vote = made.is_accepted && voting_.Judge(triangle.seen) == FaceVerdict::kAccepted;
  return made;
}

void HorizonMesh::TriangulateView(const MeshView& view) {
  grid_.clear();
  for (int i : points_) {
    const Vector2d place = view.points[i].xy * (view.focal_px * kGridPerPixel);
    grid_.push_back({static_cast<std::int32_t>(std::lround(place.x())),
                     static_cast<std::int32_t>(std::lround(place.y()))});
  }
  JudgeTriangles(view);
  stars_.Build(
      points_.size(), triangles_.size(), [this](std::size_t t) -> const auto& {
        return triangles_[t].points;
      });
  if (options_.plane_rescue.enabled) RescuePlanes(view);
  view_faces_.clear();
  verdicts_.fill(0);
  const Eigen::Vector3f eye_W = view.T_WC.p.cast<float>();
  for (const PlacedTriangle& triangle : triangles_) {
    ++verdicts_[static_cast<std::size_t>(triangle.verdict)];
    view_faces_.push_back(MakeViewFace(triangle));
    view_faces_.back().face.eye_W = eye_W;
  }
  std::sort(view_faces_.begin(), view_faces_.end(), [](const ViewFace& a, const ViewFace& b) {
    return ComesBefore(a.face, b.face);
  });
}

void HorizonMesh::RescuePlanes(const MeshView& view) {
  for (PlacedTriangle& triangle : triangles_) {
    if (triangle.verdict == FaceVerdict::kAccepted || triangle.verdict == FaceVerdict::kNotFinite)
      continue;
    if (rescued_.Judge(triangle.seen) == FaceVerdict::kAccepted && HasPlaneCorner(view, triangle)) {
      triangle.verdict = FaceVerdict::kAccepted;
    }
  }
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

void HorizonMesh::ProjectVertices(const SE3& T_WC) {
  const SE3 T_CW = T_WC.Inverse();
  const Matrix3d R_CW = T_CW.R();
  projected_.clear();
  for (const MeshVertex& vertex : vertices_)
    projected_.push_back(ProjectPoint(R_CW * vertex.p_W + T_CW.p));
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
    const FaceSighting sighting =
        check_.Judge(projection(face), {vertices_[a].id, vertices_[b].id, vertices_[c].id});
    face.votes_against += sighting.votes_against;
    if (sighting.is_replaced) {
      lost_.push_back(MakeLost(face));
      lost_.back().is_rim.fill(false);
    }
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
  for (const std::vector<MeshFace>* faces : {&faces_, &rejected_}) {
    for (const MeshFace& face : *faces) {
      for (int corner : face.corners)
        new_index_[corner] = 0;
    }
  }
  int count = 0;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (new_index_[i] < 0) continue;
    new_index_[i] = count;
    vertices_[count++] = vertices_[i];
  }
  vertices_.resize(static_cast<std::size_t>(count));
  for (std::vector<MeshFace>* faces : {&faces_, &rejected_}) {
    for (MeshFace& face : *faces) {
      for (int& corner : face.corners)
        corner = new_index_[corner];
    }
  }
}

void HorizonMesh::SetFacePlanes(std::span<const int> planes) {
  std::size_t f = 0;
  for (MeshFace& face : faces_) {
    if (face.by_plane) continue;
    FACET_CHECK(f < planes.size()) << planes.size() << " for " << faces_.size();
    face.plane_id = planes[f++];
  }
  FACET_CHECK(f == planes.size()) << planes.size() << " for " << f;
}

void HorizonMesh::SetDepthScales(std::span<const double> scales) {
  FACET_CHECK(scales.size() == vertices_.size()) << scales.size() << " for " << vertices_.size();
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    MeshVertex& vertex = vertices_[i];
    if (!vertex.host.IsValid() || vertex.host != newest_) continue;
    vertex.depth_scale = scales[i];
    vertex.shown_W = camera_W_ + scales[i] * (vertex.p_W - camera_W_);
  }
}

std::vector<Vector3d> HorizonMesh::ShownVertices() const {
  std::vector<Vector3d> out;
  out.reserve(vertices_.size());
  for (const MeshVertex& vertex : vertices_)
    out.push_back(vertex.shown_W);
  return out;
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
    if (face.by_plane) continue;
    mesh.faces.push_back(face.CounterClockwise());
    mesh.plane_ids.push_back(face.plane_id);
  }
  SetVertexNormals(mesh);
  return mesh;
}

}  // namespace facet
