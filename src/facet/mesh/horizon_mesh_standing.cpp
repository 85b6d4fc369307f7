// SPDX-License-Identifier: BSD-2-Clause
// What of the horizon mesh is shown when planes are known. None of it reaches the search for
// planes: it sees the faces that the mesh's own tests accepted.
#include <algorithm>

#include "facet/base/check.h"
#include "facet/mesh/horizon_mesh.h"

namespace facet {

// Those of a shape that no tests of later keyframes would take away again.
void HorizonMesh::KeepRejected() {
  rejected_.clear();
  if (!keeps_rejected_) return;
  for (const ViewFace& seen : view_faces_) {
    if (!seen.is_accepted && shown_.JudgeShape(Corners(seen.face)) == FaceVerdict::kAccepted)
      rejected_.push_back(seen.face);
  }
}

std::vector<std::array<int, 3>> HorizonMesh::Triangles() const {
  std::vector<std::array<int, 3>> out;
  out.reserve(faces_.size() + rejected_.size());
  for (const MeshFace& face : faces_)
    out.push_back(face.CounterClockwise());
  for (const MeshFace& face : rejected_)
    out.push_back(face.CounterClockwise());
  return out;
}

void HorizonMesh::SetStandings(std::span<const FaceStanding> standings) {
  FACET_CHECK(standings.size() == faces_.size() + rejected_.size())
      << standings.size() << " for " << faces_.size() << " and " << rejected_.size();
  const auto of_rejected = standings.subspan(faces_.size());
  std::size_t f = 0;
  std::erase_if(faces_, [&](MeshFace& face) {
    const FaceStanding& standing = standings[f++];
    face.is_hidden = standing.is_bridge;
    if (face.by_plane) face.plane_id = standing.plane_id;
    return face.by_plane && standing.plane_id < 0;
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
  const auto before = [](const MeshFace& a, const MeshFace& b) { return a.corners < b.corners; };
  const auto same = [](const MeshFace& a, const MeshFace& b) { return a.corners == b.corners; };
  faces_.insert(faces_.end(), merged_faces_.begin(), merged_faces_.end());
  std::inplace_merge(faces_.begin(), faces_.begin() + added, faces_.end(), before);
  faces_.erase(std::unique(faces_.begin(), faces_.end(), same), faces_.end());
  rejected_.clear();
}

}  // namespace facet
