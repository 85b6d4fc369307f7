// SPDX-License-Identifier: BSD-2-Clause
// A robot's loop on three threads: the IMU, the cameras, and a controller that asks 200 times a
// second where the robot is now. Runs for two seconds of the machine's clock.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <thread>

#include "sensors.h"

namespace {

constexpr std::int64_t kEnd_ns = 2'000'000'000;

/// What a controller needs beside the state: is it to be trusted?
bool IsUsable(const facet::api::Motion& motion) {
  return motion.status == facet::api::Status::kOk && motion.since_pair_s < 0.5;
}

}  // namespace

int main() {
  facet::api::LiveOdometry::Options options;
  options.overrides = {"mesh.map.enabled=false"};  // no map of the whole run
  options.smoothing_s = 0.1;                       // no jumps when images correct the IMU
  facet::api::LiveOdometry odometry(Sensors::Calibration(), options);

  Sensors sensors;
  std::atomic<bool> is_over = false;
  std::thread imu([&] {
    while (!is_over)
      odometry.AddImu(sensors.NextImu());
  });
  std::thread cameras([&] {
    while (!is_over) {
      const Sensors::Pair pair = sensors.NextPair();
      odometry.AddStereo(pair.t_ns, pair.left, pair.right);
    }
  });

  int num_usable = 0;
  facet::api::Motion last;
  while (sensors.Now() < kEnd_ns) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const auto motion = odometry.PredictAt(sensors.Now());
    if (!motion || !IsUsable(*motion)) continue;
    last = *motion;  // here the controller would steer
    ++num_usable;
  }
  is_over = true;
  imu.join();
  cameras.join();
  const facet::api::Vec3& p = last.T_WF.p;
  std::printf("%d usable states, the last at %.4f %.4f %.4f m\n", num_usable, p[0], p[1], p[2]);
  return num_usable > 20 && std::hypot(p[0], p[1], p[2]) < 0.01 ? 0 : 1;
}
