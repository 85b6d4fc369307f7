// SPDX-License-Identifier: BSD-2-Clause
// Of the streams: stamps, order, rates, what is missing.
#include <algorithm>
#include <cmath>
#include <utility>

#include "facet/base/random.h"
#include "facet/faults/fault_kind.h"

namespace facet {

namespace {

/// 0: both cameras, 1: the IMU.
bool IsOfImu(const FaultValues& value) {
  return value.at("imu") != 0;
}

void CutOut(const FaultValues& value, RecordingCopy& recording) {
  const FaultSpan span = SpanOf(value, recording);
  const auto is_outside = [&](const auto& item) { return !span.Has(item.t); };
  std::erase_if(recording.imu, is_outside);
  for (auto& images : recording.images)
    std::erase_if(images, is_outside);
}

/// Calls change(i) for this share of the positions from 1 to num - 2, evenly spread.
template <class Change>
void ForShare(double share, std::size_t num, const Change& change) {
  double owed = 0.5;
  for (std::size_t i = 1; i + 1 < num; ++i) {
    owed += share;
    if (owed < 1) continue;
    owed -= 1;
    change(i);
  }
}

// Two neighbours change places.
void Disorder(const FaultValues& value, RecordingCopy& recording) {
  const auto disorder = [&](auto& items) {
    ForShare(
        value.at("share"), items.size(), [&](std::size_t i) { std::swap(items[i], items[i - 1]); });
  };
  if (IsOfImu(value)) return disorder(recording.imu);
  for (auto& images : recording.images)
    disorder(images);
}

void RepeatStamps(const FaultValues& value, RecordingCopy& recording) {
  const auto repeat = [&](auto& items) {
    ForShare(value.at("share"), items.size(), [&](std::size_t i) { items[i].t = items[i - 1].t; });
  };
  if (IsOfImu(value)) return repeat(recording.imu);
  for (auto& images : recording.images)
    repeat(images);
}

void DropImu(const FaultValues& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  std::erase_if(recording.imu, [&](const ImuSample&) { return rng.Uniform() < value.at("share"); });
}

void DropRight(const FaultValues& value, RecordingCopy& recording) {
  Rng rng(static_cast<std::uint64_t>(value.at("seed")));
  std::erase_if(recording.images[1],
                [&](const RecordedImage&) { return rng.Uniform() < value.at("share"); });
}

// Both cameras alike.
void Jitter(const FaultValues& value, RecordingCopy& recording) {
  const auto jitter = [&](auto& items) {
    Rng rng(7);
    for (auto& item : items)
      item.t = item.t + FromSeconds(1e-3 * value.at("ms") * rng.Normal());
  };
  if (IsOfImu(value)) return jitter(recording.imu);
  for (auto& images : recording.images)
    jitter(images);
}

void Thin(const FaultValues& value, RecordingCopy& recording) {
  const auto every = static_cast<std::size_t>(std::max(1.0, value.at("every")));
  const auto thin = [&](auto& items) {
    std::size_t i = 0;
    std::erase_if(items, [&](const auto&) { return i++ % every != 0; });
  };
  if (IsOfImu(value)) return thin(recording.imu);
  for (auto& images : recording.images)
    thin(images);
}

void StampRightLate(const FaultValues& value, RecordingCopy& recording) {
  for (RecordedImage& image : recording.images[1])
    image.t = image.t + FromSeconds(1e-3 * value.at("ms"));
}

void DelayRight(const FaultValues& value, RecordingCopy& recording) {
  std::vector<RecordedImage>& right = recording.images[1];
  const auto num = static_cast<std::size_t>(std::max(0.0, value.at("images")));
  for (std::size_t i = right.size(); i-- > num;)
    right[i].file = right[i - num].file;
}

void StartImuLate(const FaultValues& value, RecordingCopy& recording) {
  const Timestamp begin = recording.images[0].front().t + FromSeconds(value.at("length"));
  std::erase_if(recording.imu, [&](const ImuSample& sample) { return sample.t < begin; });
}

void JumpClock(const FaultValues& value, RecordingCopy& recording) {
  const Timestamp begin = recording.images[0].front().t + FromSeconds(value.at("at"));
  for (auto& images : recording.images) {
    for (RecordedImage& image : images) {
      if (image.t >= begin) image.t = image.t + FromSeconds(1e-3 * value.at("ms"));
    }
  }
}

}  // namespace

std::vector<FaultKind> StampFaults() {
  return {
      {"cut", {{"at", 0}, {"length", 20}}, "only this part of the recording", CutOut},
      {"disordered",
       {{"imu", 1}, {"share", 0.01}},
       "lines that changed places with the one before (imu: 0 the images', 1 the IMU's)",
       Disorder},
      {"stamps_repeated",
       {{"imu", 1}, {"share", 0.01}},
       "stamps that are those of the line before",
       RepeatStamps},
      {"imu_dropped", {{"share", 0.05}, {"seed", 1}}, "samples that are missing", DropImu},
      {"right_dropped", {{"share", 0.1}, {"seed", 1}}, "right images that are missing", DropRight},
      {"jitter", {{"imu", 0}, {"ms", 5}}, "white noise on the stamps (1-sigma)", Jitter},
      {"thinned", {{"imu", 0}, {"every", 3}}, "only every n-th is left", Thin},
      {"right_stamped_late", {{"ms", 3}}, "stamps of the right images", StampRightLate},
      {"right_late", {{"images", 1}}, "right images are those of earlier pairs", DelayRight},
      {"imu_late", {{"length", 1}}, "no IMU for the first seconds of the images", StartImuLate},
      {"clock_jump", {{"at", 8}, {"ms", 30}}, "from then on stamps of images are later", JumpClock},
  };
}

}  // namespace facet
