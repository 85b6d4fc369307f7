// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/horizon_vertices.h"

#include <algorithm>
#include <optional>

namespace facet {
namespace {

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

// Both lists are sorted by id: `landmark` moves on to the vertex.
bool HorizonVertices::RefreshLandmark(std::vector<LandmarkEstimate>::const_iterator& landmark,
                                      std::vector<LandmarkEstimate>::const_iterator end,
                                      MeshVertex& vertex) const {
  while (landmark != end && landmark->id < vertex.id)
    ++landmark;
  if (landmark == end || landmark->id != vertex.id || !landmark->p_W.allFinite()) return false;
  vertex.p_W = vertex.shown_W = landmark->p_W;
  vertex.sigma_depth_m = landmark->sigma_depth_m;
  return true;
}

void HorizonVertices::Refresh(Timestamp t,
                              Duration horizon,
                              const MapSnapshot& snapshot,
                              const SE3& T_BC) {
  is_expired_.assign(vertices_.size(), 0);
  auto landmark = snapshot.landmarks.begin();
  FrameId host;  // support points of one keyframe follow each other
  std::optional<CameraPlace> to_W;
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
      is_known = RefreshLandmark(landmark, snapshot.landmarks.end(), vertex);
    }
    if (is_known) vertex.last_known = t;
    is_expired_[i] = !is_known && t - vertex.last_known >= horizon ? 1 : 0;
  }
}

void HorizonVertices::Add(const MeshView& view, std::span<const int> points) {
  merged_.clear();
  vertex_of_point_.clear();
  is_in_view_.clear();
  new_index_.assign(vertices_.size(), -1);
  std::size_t old = 0;
  const auto take_old = [&] {
    new_index_[old] = static_cast<int>(merged_.size());
    merged_.push_back(vertices_[old++]);
    is_in_view_.push_back(0);
  };
  for (const int i : points) {
    const MeshPoint& point = view.points[i];
    while (old < vertices_.size() && vertices_[old].id < point.id)
      take_old();
    if (old < vertices_.size() && vertices_[old].id == point.id) {
      take_old();
    } else {
      merged_.push_back({});
      is_in_view_.push_back(0);
    }
    MeshVertex& vertex = merged_.back();
    vertex.id = point.id;
    vertex.p_W = vertex.shown_W = view.T_WC * point.p_C;
    vertex.sigma_depth_m = point.sigma_depth_m;
    vertex.intensity = point.intensity;
    vertex.host = IsSupport(point.id) ? view.frame : FrameId{};
    vertex.p_H = point.p_C;
    vertex.depth_scale = 1;
    vertex.last_known = view.t;
    vertex_of_point_.push_back(static_cast<int>(merged_.size()) - 1);
    is_in_view_.back() = 1;
  }
  while (old < vertices_.size())
    take_old();
  vertices_.swap(merged_);
}

void HorizonVertices::KeepCornersOf(std::initializer_list<const std::vector<MeshFace>*> faces) {
  new_index_.assign(vertices_.size(), -1);
  for (const std::vector<MeshFace>* list : faces) {
    for (const MeshFace& face : *list) {
      for (const int corner : face.corners)
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
}

void HorizonVertices::Renumber(std::vector<MeshFace>& faces) const {
  for (MeshFace& face : faces) {
    for (int& corner : face.corners)
      corner = new_index_[corner];
  }
}

// Support ids grow from keyframe to keyframe, so the newest keyframe's come last.
std::size_t HorizonVertices::FirstCarriedBy(FrameId host) const {
  std::size_t first = vertices_.size();
  while (first > 0 && host.IsValid() && vertices_[first - 1].host == host)
    --first;
  return first;
}

void HorizonVertices::ShowAt(std::size_t i, double depth_scale, const Vector3d& shown_W) {
  vertices_[i].depth_scale = depth_scale;
  vertices_[i].shown_W = shown_W;
}

}  // namespace facet
