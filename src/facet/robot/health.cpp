// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/health.h"

#include <cstdio>

namespace facet {
namespace robot {

namespace {

using Level = Diagnosis::Level;

struct Verdict {
  Level level;
  std::string summary;
};

std::string WithReason(const std::string& text, const std::string& reason) {
  return reason.empty() ? text : text + ": " + reason;
}

std::optional<Verdict> JudgeSensor(const char* name,
                                   const std::optional<double>& since_s,
                                   double limit_s) {
  if (!since_s) return Verdict{Level::kError, std::string("no ") + name + " has come yet"};
  if (*since_s <= limit_s) return std::nullopt;
  return Verdict{Level::kError, std::string("no ") + name + " comes any more"};
}

Verdict JudgeStatus(const Health& health) {
  switch (health.status) {
    case api::Status::kInitialising:
      return {Level::kWarning,
              WithReason("initialising", health.reason.empty() ? health.problem : health.reason)};
    case api::Status::kDegraded:
      return {Level::kWarning, WithReason("degraded", health.reason)};
    case api::Status::kLost:
      return {Level::kError, WithReason("lost", health.reason)};
    case api::Status::kOk:
      break;
  }
  if (health.newly_lost > 0) {
    return {Level::kWarning,
            WithReason(std::to_string(health.newly_lost) + " messages were lost or unusable",
                       health.problem)};
  }
  if (!health.warning.empty()) return {Level::kWarning, health.warning};
  return {Level::kOk, "ok"};
}

Verdict VerdictOn(const Health& health) {
  if (!health.is_running) return {Level::kWarning, "stopped"};
  if (!health.has_odometry) {
    if (!health.problem.empty()) return {Level::kError, health.problem};
    return {Level::kWarning, "waiting for camera_info of both cameras"};
  }
  if (health.has_failed) return {Level::kError, "the odometry has failed; reset it"};
  if (const auto imu = JudgeSensor("IMU sample", health.since_imu_s, health.silence_s)) return *imu;
  if (const auto left = JudgeSensor("left image", health.since_left_s, health.silence_s))
    return *left;
  if (const auto right = JudgeSensor("right image", health.since_right_s, health.silence_s))
    return *right;
  return JudgeStatus(health);
}

std::string Milliseconds(double s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", 1e3 * s);
  return text;
}

}  // namespace

const char* NameOf(api::Status status) {
  switch (status) {
    case api::Status::kInitialising:
      return "initialising";
    case api::Status::kOk:
      return "ok";
    case api::Status::kDegraded:
      return "degraded";
    case api::Status::kLost:
      return "lost";
  }
  return "";
}

Diagnosis Judge(const Health& health) {
  const Verdict verdict = VerdictOn(health);
  Diagnosis diagnosis{verdict.level, verdict.summary, {}};
  const auto add = [&](const char* name, const std::string& value) {
    diagnosis.values.emplace_back(name, value);
  };
  const HealthCounts& counts = health.counts;
  add("status", NameOf(health.status));
  add("reason", health.reason);
  add("warning", health.warning);
  add("last problem", health.problem);
  add("images", std::to_string(counts.images));
  add("pairs", std::to_string(counts.pairs));
  add("done pairs", std::to_string(counts.done_pairs));
  add("dropped pairs", std::to_string(counts.dropped_pairs));
  add("lone images", std::to_string(counts.lone_images));
  add("repeated images", std::to_string(counts.repeated_images));
  add("bad images", std::to_string(counts.bad_images));
  add("IMU samples", std::to_string(counts.imu));
  add("dropped IMU samples", std::to_string(counts.dropped_imu));
  add("bad IMU samples", std::to_string(counts.bad_imu));
  add("pairs without IMU", std::to_string(counts.late_imu_pairs));
  add("restarts", std::to_string(counts.restarts));
  add("latency [ms]", Milliseconds(health.latency_s));
  add("largest latency [ms]", Milliseconds(health.max_latency_s));
  return diagnosis;
}

}  // namespace robot
}  // namespace facet
