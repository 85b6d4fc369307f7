// SPDX-License-Identifier: BSD-2-Clause
// Made-up motions along a route, by a drone or by a person who holds the cameras.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facet/imu/imu_types.h"

namespace facet {

enum class FlightKind { kGentle, kFast, kAggressive, kHover, kHandHeld, kWalk };

/// Returns the flight of a name: gentle, fast, aggressive, hover, hand-held or walk.
std::optional<FlightKind> FlightKindFromText(const std::string& name);
/// "gentle, fast, ...", for messages.
std::string FlightNames();
/// Whether rotors shake the IMU.
bool HasRotors(FlightKind kind);

struct FlightOptions {
  double duration_s = 20;
  double lead_s = 0.5;  ///< poses before the first and after the last second of the flight
  Timestamp start{1'400'000'000'000'000'000};  ///< stamp of the flight's begin
  std::uint64_t seed = 1;
  double look_down = 0;  ///< besides what the flight does by itself [rad]
};

/// Poses at 200 Hz along the route, with body axes as in EuRoC (x up, z forward). Where the route's
/// last point is one of the earlier ones, it goes on from there in laps; otherwise back again.
/// Corners are rounded. Differs with the seed.
/// CHECKs that the route has at least two points.
std::vector<NavState> MakeFlightPoses(FlightKind kind,
                                      std::span<const Vector3d> route_W,
                                      const FlightOptions& options);

}  // namespace facet
