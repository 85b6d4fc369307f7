// SPDX-License-Identifier: BSD-2-Clause
#include "step_reader.h"

#include <cstdio>
#include <variant>

#include "facet/io/errors.h"

namespace facet {
namespace {

// A frame this close to the border of the chosen part belongs to it: EuRoC's stamps jitter by 256
// ns.
constexpr double kStampJitterS = 1e-3;

}  // namespace

bool StepReader::FindFirst(RunStep& step) {
  std::deque<ImuSample> imu;
  while (const auto event = NextEvent()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      imu.push_back(*sample);
      continue;
    }
    const auto& frame = std::get<RecordedFrame>(*event);
    if (!origin_) origin_ = frame.t;
    last_ = frame.t;
    DropEarly(imu, frame.t);
    if (SecondsOf(frame.t) < range_.start_s - kStampJitterS || !frame.HasRight()) continue;
    if (IsBehind(frame.t)) break;
    step.frame = frame;
    step.imu.assign(imu.begin(), imu.end());
    return true;
  }
  return false;
}

bool StepReader::Next(RunStep& step) {
  step.imu.clear();
  while (const auto event = NextEvent()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      step.imu.push_back(*sample);
      continue;
    }
    step.frame = std::get<RecordedFrame>(*event);
    return !IsBehind(step.frame.t);
  }
  return false;
}

void StepReader::ThrowNoPair() {
  const double length_s = LengthSeconds();
  if (!damage_.empty()) throw InputError(damage_);
  char text[120];
  std::snprintf(text,
                sizeof(text),
                "--start %g --duration %g: no stereo pair there, the sequence lasts %.1f s",
                range_.start_s,
                range_.duration_s,
                length_s);
  throw ConfigError(text);
}

int StepReader::NumFramesFrom(Timestamp first) const {
  const double end_s = range_.start_s + range_.duration_s + kStampJitterS;
  return recording_.NumFrames(first, *origin_ + FromSeconds(end_s));
}

double StepReader::LengthSeconds() {
  while (const auto event = NextEvent()) {
    if (const auto* frame = std::get_if<RecordedFrame>(&*event)) last_ = frame->t;
  }
  return origin_ ? SecondsOf(last_) : 0;
}

bool StepReader::IsBehind(Timestamp t) const {
  return SecondsOf(t) > range_.start_s + range_.duration_s + kStampJitterS;
}

std::optional<RecordingEvent> StepReader::NextEvent() {
  if (!damage_.empty()) return std::nullopt;
  try {
    return recording_.Next();
  } catch (const InputError& error) {
    damage_ = error.what();
    return std::nullopt;
  }
}

void StepReader::DropEarly(std::deque<ImuSample>& imu, Timestamp frame) const {
  const Timestamp first =
      frame + recording_.calibration()->rig.time_offset - FromSeconds(range_.imu_history_s);
  while (imu.size() > 1 && imu[1].t <= first)
    imu.pop_front();
}

}  // namespace facet
