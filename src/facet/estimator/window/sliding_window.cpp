// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/sliding_window.h"

#include <algorithm>

#include "facet/base/check.h"

namespace facet {

void WindowFrame::ApplyStep(const Vector<15>& step) {
  if (pose_frozen) {
    delta.head<6>() += step.head<6>();
    x.T_WB = lin.T_WB.Retract(delta.head<3>(), delta.segment<3>(3));
  } else {
    x.T_WB = x.T_WB.Retract(step.head<3>(), step.segment<3>(3));
    lin.T_WB = x.T_WB;
  }
  if (!has_motion) return;
  const Vector<9> motion_step = step.tail<9>();
  if (motion_frozen) delta.tail<9>() += motion_step;
  x.v_WB += motion_step.head<3>();
  x.bias.b_g += motion_step.segment<3>(3);
  x.bias.b_a += motion_step.segment<3>(6);
  if (!motion_frozen) {
    lin.v_WB = x.v_WB;
    lin.bias = x.bias;
  }
}

void WindowPlane::ApplyStep(const Vector3d& step) {
  offset += step.z();
  if (frozen) {
    delta += step;
    n = RetractDirection(n_lin, delta.head<2>());
  } else {
    n = n_lin = RetractDirection(n, step.head<2>());
  }
}

void WindowPlane::Freeze() {
  if (frozen) return;
  frozen = true;
  n_lin = n;
  delta.setZero();
}

bool PlaneLinks::Contains(int plane) const {
  return std::find(index.begin(), index.begin() + count, plane) != index.begin() + count;
}

bool PlaneLinks::Add(int plane) {
  if (count == kMax || Contains(plane)) return false;
  index[static_cast<std::size_t>(count++)] = plane;
  return true;
}

void PlaneLinks::Remove(int plane) {
  count =
      static_cast<int>(std::remove(index.begin(), index.begin() + count, plane) - index.begin());
}

WindowLandmark* SlidingWindow::Find(LandmarkId id) {
  const auto it = index_.find(id);
  return it == index_.end() ? nullptr : &landmarks_[it->second];
}

int SlidingWindow::IndexOf(FrameId id) const {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

int SlidingWindow::IndexOf(PlaneId id) const {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (planes[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

WindowLandmark& SlidingWindow::AddLandmark(LandmarkId id, int host) {
  FACET_CHECK(!index_.contains(id)) << "landmark " << id.value << " exists";
  index_[id] = static_cast<int>(landmarks_.size());
  WindowLandmark& landmark = landmarks_.emplace_back();
  landmark.id = id;
  landmark.host = host;
  return landmark;
}

void SlidingWindow::RemoveLandmarks(const std::vector<char>& flags) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    if (flags[i]) continue;
    if (kept != i) landmarks_[kept] = std::move(landmarks_[i]);
    ++kept;
  }
  if (kept == landmarks_.size()) return;
  landmarks_.resize(kept);
  RebuildIndex();
}

void SlidingWindow::Rehost(WindowLandmark& landmark, int new_host) {
  const SE3 T_WH = frames[landmark.host].x.T_WB * T_BC0;
  const SE3 T_WN = frames[new_host].x.T_WB * T_BC0;
  // Homogeneous point seen from the new host: works for a point at infinity, too.
  const Vector3d y_W = T_WH.q * landmark.bearing_H + landmark.inverse_distance * (T_WH.p - T_WN.p);
  const double norm = y_W.norm();
  landmark.bearing_H = T_WN.q.conjugate() * (y_W / norm);
  landmark.inverse_distance /= norm;
  landmark.host = new_host;
}

void SlidingWindow::RemoveFrame(int index) {
  for (const MarginalPrior::Block& block : prior.blocks) {
    FACET_CHECK(block.IsPlane() || block.frame != frames[index].id)
        << "frame is still in the prior";
  }
  std::vector<char> gone(landmarks_.size(), 0);
  for (std::size_t l = 0; l < landmarks_.size(); ++l) {
    WindowLandmark& landmark = landmarks_[l];
    auto& obs = landmark.observations;
    std::erase_if(obs, [&](const WindowObservation& o) { return o.frame == index; });
    if (obs.empty()) {
      gone[l] = 1;
      continue;
    }
    if (landmark.host == index) {
      Rehost(landmark, obs.front().frame);
      if (!landmark.has_depth) landmark.bearing_H = obs.front().xy[0].homogeneous().normalized();
    }
    for (WindowObservation& o : obs) {
      if (o.frame > index) --o.frame;
    }
    if (landmark.host > index) --landmark.host;
  }
  for (WindowRelation& relation : relations) {
    if (relation.frame == frames[index].id) AttachRelation(relation, index);
  }
  std::erase_if(sightings, [&](const PlaneSighting& s) { return s.frame == frames[index].id; });
  frames.erase(frames.begin() + index);
  if (frames.empty()) relations.clear();
  RemoveLandmarks(gone);
}

void SlidingWindow::RemovePlane(int index) {
  for (const MarginalPrior::Block& block : prior.blocks) {
    FACET_CHECK(block.plane != planes[index].id) << "plane is still in the prior";
  }
  for (WindowLandmark& landmark : landmarks_) {
    landmark.planes.Remove(index);
    for (int& plane : landmark.planes.index)
      plane -= plane > index;
  }
  std::erase_if(relations,
                [&](const WindowRelation& r) { return r.relation.Involves(planes[index].id); });
  std::erase_if(sightings, [&](const PlaneSighting& s) { return s.plane == planes[index].id; });
  planes.erase(planes.begin() + index);
}

bool SlidingWindow::AddRelation(const PlaneRelation& relation) {
  const PlaneRelation canonical = relation.Canonical();
  const bool is_known = std::any_of(
      relations.begin(), relations.end(), [&](const auto& r) { return r.relation == canonical; });
  if (is_known || frames.empty() || IndexOf(canonical.a) < 0) return false;
  if (!canonical.IsUnary() && (canonical.a == canonical.b || IndexOf(canonical.b) < 0))
    return false;
  AttachRelation(relations.emplace_back(WindowRelation{canonical, FrameId{}}));
  return true;
}

void SlidingWindow::AttachRelation(WindowRelation& relation, int leaving) const {
  const int newest = static_cast<int>(frames.size()) - 1;
  const int index = leaving == newest ? newest - 1 : newest;
  if (index < 0) return;
  const PlaneRelation& planes_of = relation.relation;
  const Vector3d& a_W = planes[IndexOf(planes_of.a)].anchor_W;
  const Vector3d& b_W = planes_of.IsUnary() ? a_W : planes[IndexOf(planes_of.b)].anchor_W;
  relation.frame = frames[index].id;
  relation.point_B = frames[index].x.T_WB.Inverse() * Vector3d(0.5 * (a_W + b_W));
}

Vector3d SlidingWindow::PositionOf(const WindowLandmark& landmark) const {
  const SE3 T_WH = frames[landmark.host].x.T_WB * T_BC0;
  return T_WH * (landmark.bearing_H / landmark.inverse_distance);
}

void SlidingWindow::Clear() {
  frames.clear();
  planes.clear();
  relations.clear();
  sightings.clear();
  landmarks_.clear();
  index_.clear();
  prior = MarginalPrior();
  start_prior = StartPrior();
}

void SlidingWindow::RebuildIndex() {
  index_.clear();
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    index_[landmarks_[i].id] = static_cast<int>(i);
  }
}

}  // namespace facet
