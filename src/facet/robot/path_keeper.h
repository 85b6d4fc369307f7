// SPDX-License-Identifier: BSD-2-Clause
// The path so far, in bounded memory: a longer one has fewer poses of a second.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facet/robot/robot_output.h"

namespace facet {
namespace robot {

/// Not thread-safe.
class PathKeeper {
 public:
  PathKeeper(std::size_t max_poses, double period_s)
      : max_poses_(max_poses), period_ns_(static_cast<std::int64_t>(1e9 * period_s)) {}

  /// True: it is time to tell.
  bool Add(const PathPose& pose) {
    if (num_seen_++ % step_ == 0) poses_.push_back(pose);
    if (poses_.size() > max_poses_) Thin();
    if (pose.t_ns < next_ns_) return false;
    next_ns_ = pose.t_ns + period_ns_;
    return true;
  }

  void Clear() { *this = PathKeeper(max_poses_, 1e-9 * static_cast<double>(period_ns_)); }

  const std::vector<PathPose>& poses() const { return poses_; }

 private:
  void Thin() {
    for (std::size_t i = 0; 2 * i < poses_.size(); ++i)
      poses_[i] = poses_[2 * i];
    poses_.resize((poses_.size() + 1) / 2);
    step_ *= 2;
  }

  std::size_t max_poses_;
  std::int64_t period_ns_;
  std::vector<PathPose> poses_;
  std::size_t step_ = 1, num_seen_ = 0;
  std::int64_t next_ns_ = INT64_MIN;
};

}  // namespace robot
}  // namespace facet
