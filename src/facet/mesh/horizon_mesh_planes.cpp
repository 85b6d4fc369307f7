// SPDX-License-Identifier: BSD-2-Clause
// The part of HorizonMesh that deals with planes: what their search gets, and what they change in
// what is shown. The search never sees the latter: it gets what the mesh's own tests accepted.
#include <algorithm>

#include "facet/base/check.h"
#include "facet/mesh/horizon_mesh.h"

namespace facet {

// Those of a shape that no tests of later keyframes would take away again.
void HorizonMesh::KeepRejected() {
  rejected_.clear();
  if (!keeps_rejected_) return;
  for (const ViewFace& seen : view_faces_) {
    if (!seen.is_accepted && triangulation_.HasGoodShape(Corners(seen.face)))
      rejected_.push_back(seen.face);
  }
}

void HorizonMesh::FillSearchMesh(const MeshView& view, SearchMesh& out) const {
  out.t = view.t;
  out.T_WC = view.T_WC;
  out.focal_px = view.focal_px;
  out.baseline_m = view.baseline_m;
  out.first_match = view.first_match;
  out.end_match = view.end_match;
  out.vertices.clear();
  out.vertex_ids.clear();
  out.sigma_depth_m.clear();
  out.shown_vertices.clear();
  for (const MeshVertex& vertex : vertices_.all()) {
    out.vertices.push_back(vertex.p_W);
    out.vertex_ids.push_back(vertex.id);
    out.sigma_depth_m.push_back(vertex.sigma_depth_m);
    out.shown_vertices.push_back(vertex.shown_W);
  }
  out.first_carried = vertices_.FirstCarriedBy(newest_.frame);
  out.faces.clear();
  out.may_vote.clear();
  out.in_view.clear();
  out.triangles.clear();
  for (const MeshFace& face : faces_) {
    if (keeps_rejected_) out.triangles.push_back(face.CounterClockwise());
    if (face.by_plane) continue;
    out.faces.push_back(face.CounterClockwise());
    out.may_vote.push_back(face.may_vote ? 1 : 0);
    out.in_view.push_back(face.in_view ? 1 : 0);
  }
  for (const MeshFace& face : rejected_)
    out.triangles.push_back(face.CounterClockwise());
}

void HorizonMesh::Take(const MeshRegularities& regularities) {
  SetFacePlanes(regularities.face_plane_ids);
  if (!regularities.depth_scales.empty()) SetDepthScales(regularities.depth_scales);
  if (keeps_rejected_) SetVerdicts(regularities.verdicts);
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
  const Vector3d& camera_W = newest_.camera_W;
  for (std::size_t i = vertices_.FirstCarriedBy(newest_.frame); i < scales.size(); ++i) {
    const Vector3d& matched_W = vertices_.all()[i].p_W;
    vertices_.ShowAt(i, scales[i], camera_W + scales[i] * (matched_W - camera_W));
  }
}

void HorizonMesh::SetVerdicts(std::span<const TriangleVerdict> verdicts) {
  FACET_CHECK(verdicts.size() == faces_.size() + rejected_.size())
      << verdicts.size() << " for " << faces_.size() << " and " << rejected_.size();
  const auto of_rejected = verdicts.subspan(faces_.size());
  std::size_t f = 0;
  std::erase_if(faces_, [&](MeshFace& face) {
    const TriangleVerdict& verdict = verdicts[f++];
    face.is_hidden = verdict.is_bridge;
    if (face.by_plane) face.plane_id = verdict.plane_id;
    return face.by_plane && verdict.plane_id < 0;
  });
  merged_faces_.clear();
  for (std::size_t r = 0; r < rejected_.size(); ++r) {
    if (of_rejected[r].plane_id < 0) continue;
    merged_faces_.push_back(rejected_[r]);
    merged_faces_.back().by_plane = true;
    merged_faces_.back().plane_id = of_rejected[r].plane_id;
  }
  // Where the mesh has the face already, its own comes first and stays.
  const auto added = static_cast<std::ptrdiff_t>(faces_.size());
  const auto same = [](const MeshFace& a, const MeshFace& b) { return a.corners == b.corners; };
  faces_.insert(faces_.end(), merged_faces_.begin(), merged_faces_.end());
  std::inplace_merge(faces_.begin(), faces_.begin() + added, faces_.end(), ComesBefore);
  faces_.erase(std::unique(faces_.begin(), faces_.end(), same), faces_.end());
  rejected_.clear();
}

}  // namespace facet
