// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/scene_worker.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <iterator>
#include <string>
#include <utility>

namespace facet {
namespace robot {

SceneWorker::SceneWorker(RobotListener& listener, double period_s)
    : listener_(listener),
      period_ns_(static_cast<std::int64_t>(1e9 * period_s)),
      thread_([this] { Run(); }) {}

SceneWorker::~SceneWorker() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
  thread_.join();
  // Their threads call Notify.
  retired_.clear();
  odometry_.reset();
}

void SceneWorker::Follow(std::shared_ptr<api::LiveOdometry> odometry) {
  const std::lock_guard<std::mutex> telling(telling_mutex_);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (odometry_) retired_.push_back(std::move(odometry_));
    odometry_ = std::move(odometry);
    is_notified_ = false;
  }
  Forget();
  listener_.OnClear();
  changed_.notify_all();
}

void SceneWorker::Forget() {
  mesh_ns_ = request_ns_ = 0;
  has_requested_ = false;
  part_ids_.clear();
  shown_parts_.clear();
  shown_planes_.clear();
}

void SceneWorker::Notify() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_notified_ = true;
  }
  changed_.notify_all();
}

void SceneWorker::RepeatMap() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_repeat_wanted_ = true;
}

// The last owner of an odometry waits for its end: that must be this thread, so a retired one is
// kept until no other thread has it.
void SceneWorker::Run() {
  constexpr auto kPatience = std::chrono::milliseconds(100);
  while (true) {
    std::vector<std::shared_ptr<api::LiveOdometry>> ended;
    bool is_notified = false;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      const auto has_work = [this] { return is_over_ || is_notified_; };
      if (retired_.empty())
        changed_.wait(lock, [&] { return has_work() || !retired_.empty(); });
      else
        changed_.wait_for(lock, kPatience, has_work);
      if (is_over_) return;
      is_notified = std::exchange(is_notified_, false);
      const auto alone = std::partition(
          retired_.begin(), retired_.end(), [](const auto& o) { return o.use_count() > 1; });
      std::move(alone, retired_.end(), std::back_inserter(ended));
      retired_.erase(alone, retired_.end());
    }
    ended.clear();
    if (!is_notified) continue;
    const std::lock_guard<std::mutex> telling(telling_mutex_);
    std::shared_ptr<api::LiveOdometry> odometry;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      odometry = odometry_;
    }
    try {
      if (odometry) Tell(*odometry);
    } catch (const std::exception& error) {
      listener_.OnLog(LogLevel::kError, std::string("mesh and planes: ") + error.what());
    }
  }
}

void SceneWorker::Tell(api::LiveOdometry& odometry) {
  std::int64_t t_ns = mesh_ns_;
  if (listener_.WantsMesh() || listener_.WantsScene()) {
    const api::Mesh mesh = odometry.HorizonMesh();
    t_ns = mesh.t_ns;
    if (t_ns > mesh_ns_ && listener_.WantsMesh()) listener_.OnMesh(mesh);
  }
  mesh_ns_ = t_ns;
  if (listener_.WantsScene()) TellScene(odometry, t_ns);
}

void SceneWorker::TellScene(api::LiveOdometry& odometry, std::int64_t t_ns) {
  bool is_repeated = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_repeated = is_repeat_wanted_;
  }
  const auto changes = odometry.TakeScene(is_repeated);
  if (changes) {
    if (is_repeated) {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_repeat_wanted_ = false;
    }
    TellMap(*changes);
    TellPlanes(*changes);
  }
  const bool is_more = changes && changes->is_partial;
  if (has_requested_ && !is_more && t_ns - request_ns_ < period_ns_) return;
  has_requested_ = true;
  request_ns_ = t_ns;
  odometry.RequestScene();
}

// A part that was never shown needs no removal.
void SceneWorker::TellMap(const api::SceneChanges& changes) {
  std::vector<MapPartOutput> parts;
  for (const api::MapPart& part : changes.parts) {
    const bool is_there = !part.mesh.faces.empty();
    if (!is_there && shown_parts_.erase(part.index) == 0) continue;
    if (is_there) shown_parts_.insert(part.index);
    const auto next = static_cast<std::int32_t>(part_ids_.size());
    parts.push_back({part_ids_.emplace(part.index, next).first->second, part.mesh});
  }
  if (!parts.empty()) listener_.OnMap(changes.t_ns, parts);
}

void SceneWorker::TellPlanes(const api::SceneChanges& changes) {
  PlanesOutput output{changes.t_ns, changes.planes, {}};
  std::set<std::int64_t> shown;
  for (const api::Plane& plane : changes.planes)
    shown.insert(plane.id);
  std::set_difference(shown_planes_.begin(),
                      shown_planes_.end(),
                      shown.begin(),
                      shown.end(),
                      std::back_inserter(output.removed));
  shown_planes_ = std::move(shown);
  listener_.OnPlanes(output);
}

}  // namespace robot
}  // namespace facet
