// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "facet/geometry/so3.h"
#include "facet/io/errors.h"
#include "facet/sim/euroc_csv.h"
#include "facet/sim/missing_biases.h"

namespace facet {
namespace {

constexpr double kImuLead_s = 0.2;   // IMU before the first frame
constexpr double kImuTail_s = 0.05;  // and after the last one
constexpr double kMargin_s = 0.1;    // of the path around the frames, for the exposure

std::vector<Timestamp> ListFrames(Timestamp first, double duration_s, double rate_hz) {
  std::vector<Timestamp> frames;
  const auto count = static_cast<std::int64_t>(std::floor(duration_s * rate_hz + 1e-9)) + 1;
  for (std::int64_t i = 0; i < count; ++i)
    frames.push_back(first + FromSeconds(static_cast<double>(i) / rate_hz));
  return frames;
}

template <class Load>
auto LoadCsv(const Load& load) {
  try {
    return load();
  } catch (const std::runtime_error& error) {
    throw InputError(error.what());
  }
}

Smoothing CompareWithRecord(const SplineTrajectory& trajectory,
                            const std::vector<NavState>& recorded) {
  Smoothing s;
  double count = 0;
  for (const NavState& state : recorded) {
    if (state.t < trajectory.begin() || state.t > trajectory.end()) continue;
    const SE3 T_WB = trajectory.At(state.t).state.T_WB;
    const double dp = (T_WB.p - state.T_WB.p).norm();
    const double dr = LogSO3(T_WB.q.conjugate() * state.T_WB.q).norm() * 180 / std::numbers::pi;
    s.position_rms_m += dp * dp;
    s.rotation_rms_deg += dr * dr;
    s.position_max_m = std::max(s.position_max_m, dp);
    s.rotation_max_deg = std::max(s.rotation_max_deg, dr);
    ++count;
  }
  s.position_rms_m = std::sqrt(s.position_rms_m / std::max(1.0, count));
  s.rotation_rms_deg = std::sqrt(s.rotation_rms_deg / std::max(1.0, count));
  return s;
}

/// The turn that makes the record's vertical the one that the accelerometer feels: the mean over
/// the whole record of what the measured force lacks to explain the path.
Quaterniond LevelingTurn(const SplineTrajectory& trajectory,
                         const std::vector<NavState>& recorded,
                         const std::vector<ImuSample>& imu) {
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  std::size_t next = 0;
  for (const ImuSample& sample : imu) {
    if (sample.t < trajectory.begin() || sample.t > trajectory.end()) continue;
    while (next + 1 < recorded.size() && recorded[next + 1].t <= sample.t)
      ++next;
    const TrajectoryPoint point = trajectory.At(sample.t);
    sum += point.a_W - point.state.T_WB.q * (sample.accel - recorded[next].bias.b_a);
    ++count;
  }
  if (count == 0) return Quaterniond::Identity();
  return Quaterniond::FromTwoVectors(sum, GravityInWorld());
}

/// Turned about its middle, so that it stays where it was.
SplineTrajectory Level(const SplineTrajectory& trajectory, const Quaterniond& turn) {
  const Timestamp middle =
      trajectory.begin() + FromSeconds(0.5 * ToSeconds(trajectory.end() - trajectory.begin()));
  const Vector3d p_W = trajectory.At(middle).state.T_WB.p;
  return trajectory.MovedBy(SE3(turn, p_W - turn * p_W));
}

/// The states from `begin` to `end`, one more at each side.
std::vector<NavState> Cut(const std::vector<NavState>& states, Timestamp begin, Timestamp end) {
  const auto before = [](const NavState& s, Timestamp t) { return s.t < t; };
  auto first = std::lower_bound(states.begin(), states.end(), begin, before);
  auto last = std::lower_bound(states.begin(), states.end(), end, before);
  if (first != states.begin()) --first;
  if (last != states.end()) ++last;
  return {first, last};
}

}  // namespace

Motion MakeUpMotion(FlightKind kind,
                    std::span<const Vector3d> route_W,
                    const MotionRange& range,
                    double look_down,
                    std::uint64_t seed) {
  FlightOptions options;
  options.duration_s = range.duration_s > 0 ? range.duration_s : 20;
  options.look_down = look_down;
  options.seed = seed;
  const std::vector<NavState> poses = MakeFlightPoses(kind, route_W, options);
  Motion motion;
  motion.trajectory = SplineTrajectory::Fit(poses, {0.05, 1e-6});
  motion.frames = ListFrames(options.start, options.duration_s, range.frame_rate_hz);
  motion.imu_begin = options.start - FromSeconds(kImuLead_s);
  motion.imu_end = motion.frames.back() + FromSeconds(kImuTail_s);
  motion.vibration = HasRotors(kind) ? VibrationKind::kRotors : VibrationKind::kHand;
  return motion;
}

Motion LoadMotion(const std::filesystem::path& truth_csv,
                  const std::filesystem::path& imu_csv,
                  const MotionRange& range) {
  std::vector<NavState> states = LoadCsv([&] { return LoadGroundTruthCsv(truth_csv); });
  std::vector<ImuSample> imu;
  Timestamp first = states.front().t, last = states.back().t;
  if (!imu_csv.empty()) {
    imu = LoadCsv([&] { return LoadImuCsv(imu_csv); });
    first = std::max(first, imu.front().t);
    last = std::min(last, imu.back().t);
  }
  const Timestamp begin = first + FromSeconds(kMargin_s + kImuLead_s + range.start_s);
  const double available_s = ToSeconds(last - begin) - kMargin_s - kImuTail_s;
  const double duration_s = range.duration_s > 0 ? range.duration_s : available_s;
  if (available_s < 1) {
    throw InputError(truth_csv.string() + ": after --start " + std::to_string(range.start_s) +
                     " ground truth and IMU have less than " +
                     std::to_string(1 + 2 * kMargin_s + kImuLead_s + kImuTail_s) +
                     " s in common, which a sequence needs at least");
  }
  if (duration_s > available_s) {
    throw InputError(truth_csv.string() + ": --start " + std::to_string(range.start_s) +
                     " and --duration " + std::to_string(duration_s) + " need more than the " +
                     std::to_string(available_s + range.start_s) +
                     " s that ground truth and IMU have in common");
  }
  Motion motion;
  if (!imu.empty()) motion.found_bias = FillInBiases(imu, states);
  motion.frames = ListFrames(begin, duration_s, range.frame_rate_hz);
  motion.imu_begin = begin - FromSeconds(kImuLead_s);
  motion.imu_end = motion.frames.back() + FromSeconds(kImuTail_s);
  // Half a second of poses on both sides, so that the ends of the spline lie outside.
  motion.recorded =
      Cut(states, motion.imu_begin - FromSeconds(0.5), motion.imu_end + FromSeconds(0.5));
  motion.trajectory = imu.empty() ? SplineTrajectory::Fit(motion.recorded)
                                  : SplineTrajectory::FitWithImu(states, imu);
  motion.smoothing = CompareWithRecord(motion.trajectory, motion.recorded);
  if (!imu.empty()) {
    const Quaterniond turn = LevelingTurn(motion.trajectory, states, imu);
    motion.trajectory = Level(motion.trajectory, turn);
    motion.smoothing->tilt_deg = LogSO3(turn).norm() * 180 / std::numbers::pi;
  }
  for (const ImuSample& sample : imu) {
    if (sample.t >= motion.imu_begin && sample.t <= motion.imu_end)
      motion.real_imu.push_back(sample);
  }
  return motion;
}

}  // namespace facet
