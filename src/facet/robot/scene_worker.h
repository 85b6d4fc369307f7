// SPDX-License-Identifier: BSD-2-Clause
// Mesh, map and planes for the listener, on a thread of their own: extracting and sending them must
// hold up neither the estimator nor the IMU.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "facet/facet.h"
#include "facet/robot/robot_output.h"

namespace facet {
namespace robot {

/// Thread-safe.
class SceneWorker {
 public:
  SceneWorker(RobotListener& listener, double period_s);
  ~SceneWorker();
  SceneWorker(const SceneWorker&) = delete;
  SceneWorker& operator=(const SceneWorker&) = delete;

  /// The odometry whose scene is told; null: none. The one before is given up on the worker's
  /// thread, because its end waits for the frame in work; nothing of it is told any more.
  void Follow(std::shared_ptr<api::LiveOdometry> odometry);

  /// A keyframe's mesh is there. Returns at once.
  void Notify();

  /// The next update has the whole map.
  void RepeatMap();

 private:
  void Run();
  void Tell(api::LiveOdometry& odometry);
  void TellScene(api::LiveOdometry& odometry, std::int64_t t_ns);
  void TellMap(const api::SceneChanges& changes);
  void TellPlanes(const api::SceneChanges& changes);
  void Forget();

  RobotListener& listener_;
  const std::int64_t period_ns_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<api::LiveOdometry> odometry_;
  std::vector<std::shared_ptr<api::LiveOdometry>> retired_;
  bool is_notified_ = false, is_repeat_wanted_ = false, is_over_ = false;

  std::mutex telling_mutex_;  // of what follows: nothing is told after Follow of another
  std::int64_t mesh_ns_ = 0, request_ns_ = 0;
  bool has_requested_ = false;
  std::map<std::array<int, 3>, std::int32_t> part_ids_;
  std::set<std::array<int, 3>> shown_parts_;
  std::set<std::int64_t> shown_planes_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace robot
}  // namespace facet
