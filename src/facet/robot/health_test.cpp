// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/health.h"

#include <gtest/gtest.h>

namespace facet::robot {
namespace {

using Level = Diagnosis::Level;

Health Good() {
  Health health;
  health.is_running = health.has_odometry = true;
  health.since_imu_s = 0.005;
  health.since_left_s = health.since_right_s = 0.05;
  health.status = api::Status::kOk;
  return health;
}

void Expect(const Health& health, Level level, const std::string& summary) {
  const Diagnosis diagnosis = Judge(health);
  EXPECT_EQ(diagnosis.level, level) << diagnosis.summary;
  EXPECT_EQ(diagnosis.summary, summary);
  EXPECT_GT(diagnosis.values.size(), 10u);
}

TEST(HealthTest, TheWorstIsSaidFirst) {
  Health health = Good();
  Expect(health, Level::kOk, "ok");
  health.warning = "the cameras may be swapped";
  Expect(health, Level::kWarning, "the cameras may be swapped");
  health.newly_lost = 3;
  health.problem = "left image: damaged";
  Expect(health, Level::kWarning, "3 messages were lost or unusable: left image: damaged");
  health.status = api::Status::kDegraded;
  health.reason = "few tracks";
  Expect(health, Level::kWarning, "degraded: few tracks");
  health.status = api::Status::kLost;
  Expect(health, Level::kError, "lost: few tracks");
  health.since_right_s = 1.5;
  Expect(health, Level::kError, "no right image comes any more");
  health.since_left_s = 1.5;
  Expect(health, Level::kError, "no left image comes any more");
  health.since_imu_s.reset();
  Expect(health, Level::kError, "no IMU sample has come yet");
  health.has_failed = true;
  Expect(health, Level::kError, "the odometry has failed; reset it");
  health.has_odometry = false;
  Expect(health, Level::kError, "left image: damaged");
  health.problem.clear();
  Expect(health, Level::kWarning, "waiting for camera_info of both cameras");
  health.is_running = false;
  Expect(health, Level::kWarning, "stopped");
}

}  // namespace
}  // namespace facet::robot
