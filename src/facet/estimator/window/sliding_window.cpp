// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/sliding_window.h"

#include <algorithm>
#include <numeric>

#include "facet/base/check.h"

namespace facet {

namespace {

template <class Items, class Id>
int IndexById(const Items& items, Id id) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

bool IsInPrior(const MarginalPrior& prior, Variable::Kind kind, FrameId frame) {
  return std::any_of(prior.blocks.begin(), prior.blocks.end(), [&](const auto& block) {
    return block.kind == kind && block.frame == frame;
  });
}

}  // namespace

SE3 SlidingWindow::BodyAt(int frame) const {
  const WindowFrame& at = frames[frame];
  return calibration ? calibration->AtImage(at.x.T_WB, at.Rates()) : at.x.T_WB;
}

SE3 SlidingWindow::LeftCameraAt(int frame) const {
  return BodyAt(frame) * (calibration ? calibration->T_BC(0) : T_BC0);
}

std::vector<SlidingWindow::IndexEntry>::iterator SlidingWindow::PlaceInIndex(LandmarkId id) {
  return std::ranges::lower_bound(index_, id, {}, &IndexEntry::first);
}

WindowLandmark* SlidingWindow::Find(LandmarkId id) {
  const auto it = PlaceInIndex(id);
  return it == index_.end() || it->first != id ? nullptr : &landmarks_[it->second];
}

int SlidingWindow::IndexOf(FrameId id) const {
  return IndexById(frames, id);
}

int SlidingWindow::IndexOf(PlaneId id) const {
  return IndexById(planes, id);
}

Variable SlidingWindow::VariableOf(const MarginalPrior::Block& block) const {
  if (block.kind == Variable::Kind::kCalibration) return Variable::Calibration();
  const bool is_plane = block.kind == Variable::Kind::kPlane;
  return {block.kind, is_plane ? IndexOf(block.plane) : IndexOf(block.frame)};
}

WindowLandmark& SlidingWindow::AddLandmark(LandmarkId id, int host) {
  const auto place = PlaceInIndex(id);
  FACET_CHECK(place == index_.end() || place->first != id) << "landmark " << id.value << " exists";
  index_.insert(place, {id, static_cast<int>(landmarks_.size())});
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
  const SE3 T_WH = LeftCameraAt(landmark.host);
  const SE3 T_WN = LeftCameraAt(new_host);
  // Homogeneous point seen from the new host: works for a point at infinity, too.
  const Vector3d y_W = T_WH.q * landmark.bearing_H + landmark.inverse_distance * (T_WH.p - T_WN.p);
  const double norm = y_W.norm();
  landmark.bearing_H = T_WN.q.conjugate() * (y_W / norm);
  landmark.inverse_distance /= norm;
  landmark.host = new_host;
  landmark.information = {};
}

void SlidingWindow::RemoveFrame(int index) {
  const FrameId id = frames[index].id;
  FACET_CHECK(!IsInPrior(prior, Variable::Kind::kPose, id) &&
              !IsInPrior(prior, Variable::Kind::kMotion, id))
      << "frame is still in the prior";
  CutImuLinks(index);
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
      if (!landmark.has_depth) landmark.bearing_H = obs.front().rays[0].bearing;
    }
    for (WindowObservation& o : obs) {
      if (o.frame > index) --o.frame;
    }
    if (landmark.host > index) --landmark.host;
  }
  for (WindowRelation& relation : relations) {
    if (relation.frame == id) AttachRelation(relation, index);
  }
  std::erase_if(measurements, [&](const PlaneMeasurement& s) { return s.frame == id; });
  frames.erase(frames.begin() + index);
  if (frames.empty()) relations.clear();
  RemoveLandmarks(gone);
}

void SlidingWindow::RemoveMotion(int index) {
  WindowFrame& frame = frames[index];
  FACET_CHECK(!IsInPrior(prior, Variable::Kind::kMotion, frame.id))
      << "motion is still in the prior";
  frame.last_v_B = frame.VelocityInBody();
  frame.has_motion = frame.motion_frozen = false;
  CutImuLinks(index);
}

void SlidingWindow::CutImuLinks(int frame) {
  frames[frame].imu_link.reset();
  if (frame < newest_frame()) frames[frame + 1].imu_link.reset();
}

void SlidingWindow::RemovePlane(int index) {
  const PlaneId id = planes[index].id;
  for (const MarginalPrior::Block& block : prior.blocks) {
    FACET_CHECK(block.kind != Variable::Kind::kPlane || block.plane != id)
        << "plane is still in the prior";
  }
  for (WindowLandmark& landmark : landmarks_)
    landmark.planes.RemoveFromWindow(index);
  std::erase_if(relations, [&](const WindowRelation& r) { return r.relation.Involves(id); });
  std::erase_if(measurements, [&](const PlaneMeasurement& s) { return s.plane == id; });
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
  const int newest = newest_frame();
  const int index = leaving == newest ? newest - 1 : newest;
  if (index < 0) return;
  const PlaneRelation& planes_of = relation.relation;
  const Vector3d& a_W = planes[IndexOf(planes_of.a)].anchor_W;
  const Vector3d& b_W = planes_of.IsUnary() ? a_W : planes[IndexOf(planes_of.b)].anchor_W;
  relation.frame = frames[index].id;
  relation.point_B = frames[index].x.T_WB.Inverse() * Vector3d(0.5 * (a_W + b_W));
}

Vector3d SlidingWindow::PositionOf(const WindowLandmark& landmark) const {
  const SE3 T_WH = LeftCameraAt(landmark.host);
  return T_WH * (landmark.bearing_H / landmark.inverse_distance);
}

std::vector<int> SlidingWindow::CountPlaneLandmarks() const {
  std::vector<int> num_landmarks(planes.size(), 0);
  for (const WindowLandmark& landmark : landmarks_) {
    if (!landmark.IsOnPlanes()) continue;
    for (const int plane : landmark.planes)
      ++num_landmarks[static_cast<std::size_t>(plane)];
  }
  return num_landmarks;
}

int SlidingWindow::NumPlaneLandmarks() const {
  const std::vector<int> num_landmarks = CountPlaneLandmarks();
  return std::accumulate(num_landmarks.begin(), num_landmarks.end(), 0);
}

void SlidingWindow::RebuildIndex() {
  index_.clear();
  for (std::size_t i = 0; i < landmarks_.size(); ++i)
    index_.emplace_back(landmarks_[i].id, static_cast<int>(i));
  std::ranges::sort(index_);
}

}  // namespace facet
