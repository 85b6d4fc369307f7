// SPDX-License-Identifier: BSD-2-Clause
// The path of the cameras: made up along a scene's route, or a recorded flight.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "facet/sim/flight.h"
#include "facet/sim/imu_sensor.h"

namespace facet {

/// How far the smoothed path is from the recorded poses.
struct Smoothing {
  double position_rms_m = 0, position_max_m = 0;
  double rotation_rms_deg = 0, rotation_max_deg = 0;
  /// With a real IMU the angle between the vertical of the record and the measured one, by which
  /// the path is turned.
  double tilt_deg = 0;
};

struct Motion {
  SplineTrajectory trajectory;    ///< the exact truth
  std::vector<Timestamp> frames;  ///< middle of the exposure of each stereo pair
  Timestamp imu_begin, imu_end;
  VibrationKind vibration = VibrationKind::kRotors;
  /// The following are filled for recorded flights only.
  std::vector<NavState> recorded;   ///< for its biases
  std::vector<ImuSample> real_imu;  ///< empty: the IMU is to be simulated
  std::optional<Smoothing> smoothing;
  std::optional<ImuBias> found_bias;  ///< see FillInBiases
};

/// Which part of a flight, and how often it is looked at.
struct MotionRange {
  double start_s = 0;     ///< after the record's first pose; ignored for made-up flights
  double duration_s = 0;  ///< 0: to the end of the record, 20 s of a made-up flight
  double frame_rate_hz = 20;
};

/// `look_down` as in FlightOptions. CHECKs that the route has two points.
Motion MakeUpMotion(FlightKind kind,
                    std::span<const Vector3d> route_W,
                    const MotionRange& range,
                    double look_down,
                    std::uint64_t seed);

/// Along EuRoC's ground truth, smoothed; with the record's own IMU if `imu_csv` is not empty.
/// Throws InputError for unreadable files and for a range that they do not cover.
Motion LoadMotion(const std::filesystem::path& truth_csv,
                  const std::filesystem::path& imu_csv,
                  const MotionRange& range);

}  // namespace facet
