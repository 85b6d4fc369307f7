// SPDX-License-Identifier: BSD-2-Clause
// Of the IMU: its bad day, its range, units and axes.
#include <algorithm>
#include <cmath>
#include <optional>

#include "facet/base/random.h"
#include "facet/faults/fault_kind.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

void GlitchImu(const FaultValues& value, RecordingCopy& recording) {
  const Timestamp t = recording.images[0].front().t + FromSeconds(value.at("at"));
  const auto axis = static_cast<Eigen::Index>(value.at("axis"));
  int left = static_cast<int>(value.at("samples"));
  for (ImuSample& sample : recording.imu) {
    if (sample.t < t || left-- <= 0) continue;
    if (value.at("gyro") != 0) sample.gyro[axis] = value.at("gyro");
    if (value.at("accel") != 0) sample.accel[axis] = value.at("accel");
  }
}

void CutImu(const FaultValues& value, RecordingCopy& recording) {
  Erase(recording.imu, SpanOf(value, recording));
}

void ClipImu(const FaultValues& value, RecordingCopy& recording) {
  const double w = value.at("gyro"), a = value.at("accel");
  for (ImuSample& sample : recording.imu) {
    if (w > 0) sample.gyro = sample.gyro.cwiseMax(-w).cwiseMin(w);
    if (a > 0) sample.accel = sample.accel.cwiseMax(-a).cwiseMin(a);
  }
}

void FreezeImu(const FaultValues& value, RecordingCopy& recording) {
  const FaultSpan span = SpanOf(value, recording);
  std::optional<ImuSample> kept;
  for (ImuSample& sample : recording.imu) {
    if (!span.Has(sample.t)) continue;
    if (!kept) kept = sample;
    sample.gyro = kept->gyro;
    sample.accel = kept->accel;
  }
}

void KillImuAxis(const FaultValues& value, RecordingCopy& recording) {
  const auto axis = static_cast<Eigen::Index>(value.at("axis"));
  for (ImuSample& sample : recording.imu)
    (value.at("of_gyro") != 0 ? sample.gyro : sample.accel)[axis] = value.at("value");
}

void ShiftImu(const FaultValues& value, RecordingCopy& recording) {
  for (ImuSample& sample : recording.imu)
    sample.t = sample.t - FromSeconds(1e-3 * value.at("ms"));
}

void GyroInDegrees(const FaultValues& /*value*/, RecordingCopy& recording) {
  for (ImuSample& sample : recording.imu)
    sample.gyro /= kDegree;
}

void NegateImu(const FaultValues& value, RecordingCopy& recording) {
  const auto axis = static_cast<Eigen::Index>(value.at("axis"));
  for (ImuSample& sample : recording.imu) {
    if (value.at("accel_only") == 0) sample.gyro[axis] *= -1;
    if (value.at("gyro_only") == 0) sample.accel[axis] *= -1;
  }
}

// Scale factors, and axes that are not quite orthogonal: what a calibration at one temperature
// leaves.
void ScaleImu(const FaultValues& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  AddImuErrors(DrawImuErrors(value.at("percent"), value.at("deg"), rng), recording);
}

// ---------------------------------------------------------------- wrong in the whole recording

void ScaleGyroscope(const FaultValues& value, RecordingCopy& recording) {
  ImuErrors errors;
  errors.of_gyro *= 1 + value.at("percent") / 100;
  AddImuErrors(errors, recording);
}

void BiasGyroscope(const FaultValues& value, RecordingCopy& recording) {
  const auto axis = static_cast<Eigen::Index>(value.at("axis"));
  for (ImuSample& sample : recording.imu)
    sample.gyro[axis] += value.at("bias");
}

void ScaleAccelerometer(const FaultValues& value, RecordingCopy& recording) {
  for (ImuSample& sample : recording.imu)
    sample.accel *= 1 + value.at("percent") / 100;
}

// As drivers do: what lasts for a second is taken for gravity.
void TakeGravityOut(const FaultValues& value, RecordingCopy& recording) {
  constexpr std::size_t kHalfWindow = 100;
  const std::vector<ImuSample> raw = recording.imu;
  Vector3d sum = Vector3d::Zero();
  std::size_t begin = 0, end = 0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    for (; end < std::min(raw.size(), i + kHalfWindow); ++end)
      sum += raw[end].accel;
    for (; begin + kHalfWindow < i; ++begin)
      sum -= raw[begin].accel;
    recording.imu[i].accel -= value.at("share") * sum / static_cast<double>(end - begin);
  }
}

void ExchangeAccelAxes(const FaultValues& value, RecordingCopy& recording) {
  const auto kept = static_cast<Eigen::Index>(value.at("axis"));
  for (ImuSample& sample : recording.imu)
    std::swap(sample.accel[(kept + 1) % 3], sample.accel[(kept + 2) % 3]);
}

// The sensor's range ends where this share of the samples of an axis is beyond it.
void SaturateGyroscope(const FaultValues& value, RecordingCopy& recording) {
  std::vector<double> rates;
  for (const ImuSample& sample : recording.imu)
    rates.push_back(sample.gyro.cwiseAbs().maxCoeff());
  std::ranges::sort(rates);
  const double kept = (1 - value.at("share")) * static_cast<double>(rates.size() - 1);
  const double limit = rates[static_cast<std::size_t>(kept)];
  for (ImuSample& sample : recording.imu)
    sample.gyro = sample.gyro.cwiseMax(-limit).cwiseMin(limit);
}

}  // namespace

std::vector<FaultKind> ImuFaults() {
  return {
      {"imu_glitch",
       {{"at", 5}, {"samples", 1}, {"axis", 0}, {"gyro", 35}, {"accel", 0}},
       "samples with this value [rad/s, m/s^2; 0: as recorded]",
       GlitchImu},
      {"imu_gap", {{"at", 5}, {"length", 0.3}}, "no IMU", CutImu},
      {"imu_clip", {{"gyro", 0.6}, {"accel", 0}}, "the sensor's range ends there", ClipImu},
      {"imu_frozen", {{"at", 5}, {"length", 0.3}}, "the IMU repeats itself", FreezeImu},
      {"imu_dead_axis",
       {{"axis", 1}, {"of_gyro", 0}, {"value", 0}},
       "an axis of the accelerometer, or of the gyroscope, has this value [m/s^2, rad/s] all the "
       "time",
       KillImuAxis},
      {"imu_early", {{"ms", 10}}, "stamps of the IMU are early", ShiftImu},
      {"imu_degrees", {}, "the gyroscope measures in deg/s", GyroInDegrees},
      {"imu_negated",
       {{"axis", 0}, {"gyro_only", 0}, {"accel_only", 0}},
       "an axis points the other way",
       NegateImu},
      {"imu_scaled",
       {{"percent", 0.3}, {"deg", 0.05}, {"seed", 1}},
       "scale factors and misalignment of both sensors (1-sigma)",
       ScaleImu},
      {"gyro_scaled", {{"percent", 5}}, "all rates are too large by this", ScaleGyroscope},
      {"gyro_biased", {{"axis", 0}, {"bias", 0.2}}, "added to all rates [rad/s]", BiasGyroscope},
      {"accel_scaled", {{"percent", 10}}, "all forces are too large by this", ScaleAccelerometer},
      {"no_gravity",
       {{"share", 1}},
       "gravity is filtered out of the accelerations",
       TakeGravityOut},
      {"accel_exchanged",
       {{"axis", 2}},
       "the two other axes of the accelerometer are exchanged",
       ExchangeAccelAxes},
      {"imu_saturated",
       {{"share", 0.01}},
       "the gyroscope's range ends below this share of its samples",
       SaturateGyroscope},
  };
}

}  // namespace facet
