// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/bag_recording.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "facet/io/errors.h"
#include "facet/io/sample_depth.h"
#include "facet/messages/message_image.h"
#include "facet/messages/ros_calibration.h"
#include "facet/recording/frame_decoder.h"
#include "facet/recording/sensor_messages.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

// How long a frame waits for the IMU samples behind it, on the recorder's clock.
constexpr Duration kLongestWait{2000000000};
constexpr std::size_t kMostImu = 100000;  // samples that wait for a frame

std::string Milliseconds(Duration duration) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.1f", 1e3 * ToSeconds(duration));
  return text;
}

std::string NameOf(const fs::path& path) {
  std::error_code error;
  fs::path clean = fs::weakly_canonical(path, error);
  if (error) clean = path;
  return fs::is_directory(clean, error) ? clean.filename().string() : clean.stem().string();
}

}  // namespace

BagRecording::BagRecording(std::unique_ptr<MessageSource> source,
                           const fs::path& path,
                           const BagOptions& options)
    : source_(std::move(source)), path_(path), name_(NameOf(path)) {
  choice_ = ChooseTopics(source_->topics(), options.topics, path.string());
  const BagOpening opening = ReadBagOpening(*source_, choice_, path.string());
  FindCalibrationOf(opening, options);
  stamps_ = JudgeStamps(opening, choice_, source_->topics(), path.string());
  warnings_.insert(warnings_.end(), stamps_.warnings.begin(), stamps_.warnings.end());
  if (opening.largest_sample > 0) sample_bits_ = UsedSampleBits(opening.largest_sample);
  if (sample_bits_ < 16) {
    warnings_.push_back(SampleBitsWarning(sample_bits_, opening.largest_sample));
  }
  Rewind();
  RequireReadablePair();
  Rewind();
}

void BagRecording::FindCalibrationOf(const BagOpening& opening, const BagOptions& options) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path_, error) ? path_ : path_.parent_path();
  const fs::path beside = folder.empty() ? fs::path(".") : folder;
  const RosCalibration found =
      CalibrationFromMessages(opening.calibration, options.calibration.imu);
  if (!options.calibration.cameras.empty() || !found.calibration) {
    calibration_ = FindCalibrationBeside(beside, options.calibration);
  } else {
    calibration_ = found.calibration;
  }
  if (calibration_) {
    warnings_ = calibration_->warnings;
  } else if (options.needs_calibration) {
    throw InputError(path_.string() + ": the recording carries no calibration (" + found.problem +
                     ") and no camchain*.yaml lies beside it; give a "
                     "Kalibr calibration with --calibration FILE");
  }
}

void BagRecording::RequireReadablePair() {
  constexpr int kMaxPairs = 10;
  std::optional<FrameDecoder> decoder;
  if (calibration_) decoder.emplace(calibration_->rig);
  ImageReader reader;
  cv::Mat left, right;
  std::string first_problem;
  for (int num = 0; num < kMaxPairs;) {
    const auto event = Next();
    if (!event) break;
    const auto* frame = std::get_if<RecordedFrame>(&*event);
    if (frame == nullptr) continue;
    if (!frame->HasRight()) continue;
    ++num;
    std::string problem;
    try {
      if (decoder) {
        problem = decoder->Decode(*frame, left, right);
      } else {
        frame->left->Decode({}, reader, left);
        frame->right->Decode({}, reader, right);
      }
      if (problem.empty()) return;
    } catch (const InputError& error) {
      problem = error.what();
    }
    if (first_problem.empty()) first_problem = problem;
  }
  if (!first_problem.empty()) {
    throw InputError(first_problem + " (and the next pairs cannot be used either)");
  }
  const auto& topics = source_->topics();
  throw InputError(path_.string() + ": no image of " + topics[choice_.right].name +
                   " has the stamp of one of " + topics[choice_.left].name + " (within " +
                   Milliseconds(stamps_.tolerance) + " ms); are they triggered together?");
}

std::string BagRecording::PlaceOf(const Message& message) const {
  return source_->PlaceOf(message) + ": " + source_->topics()[message.topic].name;
}

Timestamp BagRecording::StampOf(const Message& message, Timestamp header) const {
  return stamps_.topics_without.contains(message.topic) ? message.received : header;
}

void BagRecording::Rewind() {
  source_->Rewind();
  images_.fill(StrayStamps<StampedImage>(kImagesToConfirm));
  readings_.clear();
  num_stray_images_ = num_stray_imu_ = 0;
  imu_.Clear();
  pairer_ = StereoPairer(stamps_.tolerance);
  last_imu_.reset();
  received_ = frame_ready_ = {};
  is_ended_ = is_frame_waiting_ = false;
  damage_.clear();
  num_damaged_ = 0;
  first_damaged_.clear();
}

void BagRecording::Take(const Message& message) {
  received_ = std::max(received_, message.received);
  try {
    if (message.topic == choice_.left || message.topic == choice_.right) {
      TakeImage(message, message.topic == choice_.left ? 0 : 1);
    } else if (message.topic == choice_.rates() || message.topic == choice_.accel) {
      TakeImuMessage(message);
    }
  } catch (const InputError& error) {
    if (num_damaged_++ == 0) first_damaged_ = PlaceOf(message) + ": " + error.what();
  }
}

void BagRecording::TakeImage(const Message& message, int camera) {
  const ImageMessage image = ReadAnyImageMessage(source_->topics()[message.topic], message.bytes);
  images_[camera].Add(
      {StampOf(message, image.header.t),
       message.received,
       std::make_shared<MessageImage>(image, sample_bits_, PlaceOf(message)),
       image.data.size()},
      [&](const StampedImage& one) { PassImage(camera, one); },
      [&](const StampedImage&) { ++num_stray_images_; });
}

void BagRecording::TakeImuMessage(const Message& message) {
  const Topic& topic = source_->topics()[message.topic];
  ImuSample reading = ReadImuMessage(message.bytes, topic.encoding).sample;
  reading.t = StampOf(message, reading.t);
  readings_.try_emplace(message.topic, kSamplesToConfirm)
      .first->second.Add(
          reading,
          [&](const ImuSample& one) { PassReading(message.topic, one); },
          [&](const ImuSample&) { ++num_stray_imu_; });
}

void BagRecording::PassImage(int camera, const StampedImage& image) {
  pairer_.Add(camera, image.t, image.image, image.received, image.num_bytes);
}

void BagRecording::PassReading(std::size_t topic, const ImuSample& reading) {
  if (topic == choice_.imu) imu_.AddSample(reading);
  if (topic == choice_.gyro) imu_.AddGyro(reading.t, reading.gyro);
  if (topic == choice_.accel) imu_.AddAccel(reading.t, reading.accel);
}

void BagRecording::End() {
  for (int camera = 0; camera < 2; ++camera) {
    images_[camera].End([&](const StampedImage& one) { PassImage(camera, one); },
                        [&](const StampedImage&) { ++num_stray_images_; });
  }
  for (auto& [topic, readings] : readings_) {
    readings.End([&, name = topic](const ImuSample& one) { PassReading(name, one); },
                 [&](const ImuSample&) { ++num_stray_imu_; });
  }
  is_ended_ = true;
  pairer_.End();
}

std::optional<RecordingEvent> BagRecording::TakeImu() {
  const ImuSample sample = imu_.samples().front();
  imu_.samples().pop_front();
  last_imu_ = sample.t;
  return sample;
}

/// Whether the IMU samples that belong before the frame were handed out, or will not come.
bool BagRecording::IsSettled(const RecordedFrame& frame) const {
  const Duration offset = calibration_ ? calibration_->rig.time_offset : Duration{};
  return is_ended_ || (last_imu_ && *last_imu_ > frame.t + offset) ||
         received_ - frame_ready_ > kLongestWait || pairer_.IsFull();
}

std::optional<RecordingEvent> BagRecording::Next() {
  const Duration offset = calibration_ ? calibration_->rig.time_offset : Duration{};
  while (true) {
    const std::optional<RecordedFrame>& frame = pairer_.Front();
    if (frame && !std::exchange(is_frame_waiting_, true)) frame_ready_ = received_;
    const bool has_imu = !imu_.samples().empty();
    if (frame) {
      if (has_imu && (!last_imu_ || *last_imu_ <= frame->t + offset)) return TakeImu();
      if (IsSettled(*frame)) {
        RecordingEvent event = *frame;
        pairer_.Pop();
        is_frame_waiting_ = false;
        return event;
      }
    } else if (has_imu && (is_ended_ || imu_.samples().size() > kMostImu)) {
      return TakeImu();
    } else if (is_ended_) {
      if (!damage_.empty()) throw InputError(damage_);
      return std::nullopt;
    }
    try {
      if (const auto message = source_->Next()) {
        Take(*message);
        continue;
      }
    } catch (const InputError& error) {
      damage_ = error.what();
    }
    End();
  }
}

int BagRecording::NumFrames(Timestamp from, Timestamp to) const {
  const auto num = static_cast<double>(source_->topics()[choice_.left].num_messages);
  const double all_s = source_->IndexedDuration() ? ToSeconds(*source_->IndexedDuration()) : 0;
  const double begin_s = std::max(0.0, ToSeconds(from - stamps_.first_left));
  const double end_s = std::min(all_s, ToSeconds(to - stamps_.first_left));
  if (!(end_s > begin_s)) return 0;
  return static_cast<int>(std::min(1e9, num * (end_s - begin_s) / all_s));
}

std::vector<std::string> BagRecording::Warnings() const {
  std::vector<std::string> warnings = warnings_;
  const auto append = [&](const std::vector<std::string>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  append(source_->Warnings());
  append(pairer_.Warnings());
  append(imu_.Warnings());
  const auto warn_of_strays = [&](int num, const char* what) {
    if (num > 0)
      warnings.push_back(std::to_string(num) + what +
                         " have stamps far away from those around them and were left out");
  };
  warn_of_strays(num_stray_images_, " images");
  warn_of_strays(num_stray_imu_, " IMU messages");
  if (num_damaged_ > 0) {
    warnings.push_back(std::to_string(num_damaged_) +
                       " messages are damaged and were left out; the first: " + first_damaged_);
  }
  return warnings;
}

}  // namespace facet
