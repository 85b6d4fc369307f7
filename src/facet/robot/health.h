// SPDX-License-Identifier: BSD-2-Clause
// What a node tells of itself: a level and a sentence, and the figures behind it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "facet/facet.h"
#include "facet/robot/robot_output.h"

namespace facet {
namespace robot {

/// Totals since the node began.
struct HealthCounts {
  std::int64_t images = 0, pairs = 0, imu = 0;  ///< that came; pairs: given to the odometry
  std::int64_t done_pairs = 0, dropped_pairs = 0, dropped_imu = 0, late_imu_pairs = 0;
  std::int64_t lone_images = 0;      ///< without a partner
  std::int64_t repeated_images = 0;  ///< whose stamps did not rise
  std::int64_t bad_images = 0;       ///< damaged, of an unknown encoding, or of another size
  std::int64_t bad_imu = 0;          ///< not finite
  std::int64_t restarts = 0;         ///< by Reset, or because the clock went back

  std::int64_t lost() const {
    return dropped_pairs + dropped_imu + lone_images + bad_images + bad_imu;
  }
};

struct Health {
  bool is_running = false;
  bool has_odometry = false;  ///< a calibration is there
  bool has_failed = false;
  std::string problem;  ///< with the calibration, or what the newest image lacked
  std::string warning;  ///< of the newest state that had one
  /// By the machine's clock; empty: none came.
  std::optional<double> since_imu_s, since_left_s, since_right_s;
  double silence_s = 1;  ///< limit of all three
  api::Status status = api::Status::kInitialising;
  std::string reason;
  double latency_s = 0, max_latency_s = 0;
  HealthCounts counts;
  std::int64_t newly_lost = 0;  ///< since the last time
};

Diagnosis Judge(const Health& health);

/// "initialising", "ok", "degraded", "lost".
const char* NameOf(api::Status status);

}  // namespace robot
}  // namespace facet
