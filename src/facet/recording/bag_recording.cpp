// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/bag_recording.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "facet/io/errors.h"
#include "facet/io/sample_depth.h"
#include "facet/recording/frame_decoder.h"
#include "facet/recording/message_image.h"
#include "facet/recording/ros_calibration.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

// How much is read to find out what the recording is like, from the first left image on.
constexpr Duration kOpeningTime{3000000000};
// How long a frame waits for the IMU samples behind it, on the recorder's clock.
constexpr Duration kLongestWait{2000000000};
constexpr std::size_t kMostImu = 100000;  // samples that wait for a frame

struct StampPair {
  Timestamp header, received;
};

double MedianSeconds(std::vector<std::int64_t> values_ns) {
  if (values_ns.empty()) return 0;
  const auto middle = values_ns.begin() + static_cast<std::ptrdiff_t>(values_ns.size() / 2);
  std::nth_element(values_ns.begin(), middle, values_ns.end());
  return static_cast<double>(*middle) * 1e-9;
}

/// By how much the recorder's stamps are later than those of the headers.
double MedianDelaySeconds(const std::vector<StampPair>& stamps) {
  std::vector<std::int64_t> delays_ns;
  for (const StampPair& stamp : stamps)
    delays_ns.push_back((stamp.received - stamp.header).ns);
  return MedianSeconds(delays_ns);
}

double MedianIntervalSeconds(const std::vector<Timestamp>& stamps) {
  std::vector<std::int64_t> intervals_ns;
  for (std::size_t i = 1; i < stamps.size(); ++i)
    intervals_ns.push_back((stamps[i] - stamps[i - 1]).ns);
  return intervals_ns.empty() ? 0.05 : std::max(0.0, MedianSeconds(intervals_ns));
}

std::string Text(const char* format, double a, double b = 0) {
  char text[200];
  std::snprintf(text, sizeof(text), format, a, b);
  return text;
}

std::string NameOf(const fs::path& path) {
  std::error_code error;
  fs::path clean = fs::weakly_canonical(path, error);
  if (error) clean = path;
  return fs::is_directory(clean, error) ? clean.filename().string() : clean.stem().string();
}

}  // namespace

/// What the first seconds show.
struct BagRecording::Opening {
  std::vector<StampPair> left, right, imu;
  RosCalibrationMessages calibration;
  std::uint16_t largest_sample = 0;
  ImageReader reader;
  int num_samples = 0;
};

BagRecording::BagRecording(std::unique_ptr<MessageSource> source,
                           const fs::path& path,
                           const BagOptions& options)
    : source_(std::move(source)), path_(path), name_(NameOf(path)) {
  choice_ = ChooseTopics(source_->topics(), options.topics, path.string());
  roles_[choice_.left] = Role::kLeft;
  roles_[choice_.right] = Role::kRight;
  if (choice_.imu) roles_[*choice_.imu] = Role::kImu;
  if (choice_.gyro) roles_[*choice_.gyro] = Role::kGyro;
  if (choice_.accel) roles_[*choice_.accel] = Role::kAccel;
  Opening opening;
  const std::size_t images[] = {choice_.left, choice_.right};
  for (std::size_t i = 0; i < 2; ++i) {
    opening.calibration.are_rectified[i] =
        source_->topics()[images[i]].name.find("rect") != std::string::npos;
  }
  ReadOpening(opening);
  FindCalibrationOf(opening, options);
  FindMissingStamps(opening);
  FindSampleBits(opening);
  JudgeDelays(opening);
  const bool has_stamps = !has_no_stamps_.contains(choice_.left);
  std::vector<Timestamp> left;
  for (const StampPair& stamp : opening.left)
    left.push_back(has_stamps ? stamp.header : stamp.received);
  tolerance_ = FromSeconds(MedianIntervalSeconds(left) / 8);
  first_left_ = left.front();
  Rewind();
  RequireReadablePair();
  Rewind();
}

void BagRecording::ReadOpening(Opening& opening) {
  source_->Rewind();
  std::optional<Timestamp> first_left;
  try {
    while (const auto message = source_->Next()) {
      LookAt(*message, opening);
      if (!first_left && !opening.left.empty()) first_left = message->received;
      if (first_left && message->received - *first_left > kOpeningTime) break;
    }
  } catch (const InputError&) {
    if (opening.left.empty() || opening.right.empty() || opening.imu.empty()) throw;
  }
  const auto require = [&](const std::vector<StampPair>& stamps, std::size_t topic) {
    if (!stamps.empty()) return;
    throw InputError(path_.string() + ": no usable message of " + source_->topics()[topic].name +
                     " in the first seconds" +
                     (num_damaged_ > 0 ? "; " + first_damaged_ : std::string()));
  };
  require(opening.left, choice_.left);
  require(opening.right, choice_.right);
  require(opening.imu, choice_.imu ? *choice_.imu : *choice_.gyro);
}

void BagRecording::LookAt(const Message& message, Opening& opening) {
  constexpr int kNumSampleImages = 10;
  constexpr std::size_t kMaxTransforms = 10000;
  const Topic& topic = source_->topics()[message.topic];
  RosCalibrationMessages& calibration = opening.calibration;
  const auto role = roles_.find(message.topic);
  try {
    if (role != roles_.end() && (role->second == Role::kLeft || role->second == Role::kRight)) {
      const std::size_t camera = role->second == Role::kLeft ? 0 : 1;
      const ImageMessage image = ReadImage(message);
      (camera == 0 ? opening.left : opening.right).push_back({image.header.t, message.received});
      calibration.camera_frames[camera] = image.header.frame;
      if (opening.num_samples++ < kNumSampleImages) {
        opening.largest_sample =
            std::max(opening.largest_sample, LargestSample(image, opening.reader));
      }
    } else if (role != roles_.end() && role->second != Role::kAccel) {
      const ImuMessage imu = ReadImuMessage(message.bytes, topic.encoding);
      opening.imu.push_back({imu.header.t, message.received});
      calibration.imu_frame = imu.header.frame;
    } else if (message.topic == choice_.left_info) {
      calibration.cameras[0] = ReadCameraInfoMessage(message.bytes, topic.encoding);
    } else if (message.topic == choice_.right_info) {
      calibration.cameras[1] = ReadCameraInfoMessage(message.bytes, topic.encoding);
    } else if (topic.type == kTransformsType && topic.name.ends_with("tf_static")) {
      for (FrameTransform& transform : ReadTransformsMessage(message.bytes, topic.encoding)) {
        if (calibration.transforms.size() < kMaxTransforms)
          calibration.transforms.push_back(std::move(transform));
      }
    }
  } catch (const InputError& error) {
    if (num_damaged_++ == 0) first_damaged_ = PlaceOf(message) + ": " + error.what();
  }
}

void BagRecording::FindCalibrationOf(const Opening& opening, const BagOptions& options) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path_, error) ? path_ : path_.parent_path();
  const fs::path beside = folder.empty() ? fs::path(".") : folder;
  const RosCalibration found =
      CalibrationFromMessages(opening.calibration, options.calibration.imu);
  calibration_problem_ = found.problem;
  if (!options.calibration.cameras.empty() || !found.calibration) {
    calibration_ = FindCalibrationBeside(beside, options.calibration);
  } else {
    calibration_ = found.calibration;
  }
  if (calibration_) {
    warnings_ = calibration_->warnings;
  } else if (options.needs_calibration) {
    throw InputError(path_.string() + ": the recording carries no calibration (" +
                     calibration_problem_ +
                     ") and no camchain*.yaml lies beside it; give a "
                     "Kalibr calibration with --calibration FILE");
  }
}

void BagRecording::FindMissingStamps(const Opening& opening) {
  const auto has_none = [](const std::vector<StampPair>& stamps) {
    return std::ranges::all_of(stamps, [](const StampPair& s) { return s.header.ns == 0; });
  };
  const std::pair<const std::vector<StampPair>*, std::size_t> streams[] = {
      {&opening.left, choice_.left},
      {&opening.right, choice_.right},
      {&opening.imu, choice_.imu ? *choice_.imu : *choice_.gyro}};
  for (const auto& [stamps, topic] : streams) {
    if (!has_none(*stamps)) continue;
    has_no_stamps_[topic] = true;
    warnings_.push_back(source_->topics()[topic].name +
                        ": the messages have no stamps; those of the recorder are used, which are "
                        "late and irregular");
  }
  if (choice_.accel && has_no_stamps_.contains(*choice_.gyro))
    has_no_stamps_[*choice_.accel] = true;
}

void BagRecording::FindSampleBits(const Opening& opening) {
  if (opening.largest_sample == 0) return;
  sample_bits_ = UsedSampleBits(opening.largest_sample);
  if (sample_bits_ == 16) return;
  warnings_.push_back(SampleBitsWarning(sample_bits_, opening.largest_sample));
}

void BagRecording::JudgeDelays(const Opening& opening) {
  constexpr double kOddDelay_s = 1, kOddDifference_s = 0.1, kOtherClock_s = 10;
  if (!has_no_stamps_.empty()) return;
  const double camera_s = MedianDelaySeconds(opening.left), imu_s = MedianDelaySeconds(opening.imu);
  if (std::abs(camera_s - imu_s) > kOtherClock_s) {
    throw InputError(path_.string() + ": camera and IMU do not overlap in time: " +
                     Text("the recorder got images %.3f s after their stamps and IMU samples "
                          "%.3f s after theirs; are the stamps of the same clock and unit?",
                          camera_s,
                          imu_s));
  }
  if (std::abs(camera_s - imu_s) > kOddDifference_s) {
    warnings_.push_back(
        Text("the recorder got images %.3f s after their stamps, but IMU samples "
             "%.3f s after theirs; if the clocks differ, calibrate the time offset",
             camera_s,
             imu_s));
  } else if (std::abs(camera_s) > kOddDelay_s) {
    warnings_.push_back(
        Text("messages were recorded %.3f s after their stamps; the stamps are used", camera_s));
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
  throw InputError(
      path_.string() + ": no image of " + topics[choice_.right].name + " has the stamp of one of " +
      topics[choice_.left].name +
      Text(" (within %.1f ms); are they triggered together?", 1e3 * ToSeconds(tolerance_)));
}

std::string BagRecording::PlaceOf(const Message& message) const {
  return source_->PlaceOf(message) + ": " + source_->topics()[message.topic].name;
}

ImageMessage BagRecording::ReadImage(const Message& message) const {
  const Topic& topic = source_->topics()[message.topic];
  return topic.type == kImageType ? ReadImageMessage(message.bytes, topic.encoding)
                                  : ReadCompressedImageMessage(message.bytes, topic.encoding);
}

Timestamp BagRecording::StampOf(const Message& message, Timestamp header) const {
  return has_no_stamps_.contains(message.topic) ? message.received : header;
}

void BagRecording::Rewind() {
  source_->Rewind();
  imu_.Clear();
  pairer_ = StereoPairer(tolerance_);
  last_imu_.reset();
  received_ = frame_ready_ = {};
  is_ended_ = is_frame_waiting_ = false;
  damage_.clear();
  num_damaged_ = 0;
  first_damaged_.clear();
}

void BagRecording::Take(const Message& message) {
  received_ = std::max(received_, message.received);
  const auto role = roles_.find(message.topic);
  if (role == roles_.end()) return;
  try {
    if (role->second == Role::kLeft || role->second == Role::kRight) {
      const ImageMessage image = ReadImage(message);
      pairer_.Add(role->second == Role::kLeft ? 0 : 1,
                  StampOf(message, image.header.t),
                  std::make_shared<MessageImage>(image, sample_bits_, PlaceOf(message)),
                  message.received,
                  image.data.size());
      return;
    }
    ImuSample sample =
        ReadImuMessage(message.bytes, source_->topics()[message.topic].encoding).sample;
    sample.t = StampOf(message, sample.t);
    if (role->second == Role::kImu) imu_.AddSample(sample);
    if (role->second == Role::kGyro) imu_.AddGyro(sample.t, sample.gyro);
    if (role->second == Role::kAccel) imu_.AddAccel(sample.t, sample.accel);
  } catch (const InputError& error) {
    if (num_damaged_++ == 0) first_damaged_ = PlaceOf(message) + ": " + error.what();
  }
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
    is_ended_ = true;
    pairer_.End();
  }
}

int BagRecording::NumFrames(Timestamp from, Timestamp to) const {
  const auto num = static_cast<double>(source_->topics()[choice_.left].num_messages);
  const double all_s = source_->IndexedDuration() ? ToSeconds(*source_->IndexedDuration()) : 0;
  const double begin_s = std::max(0.0, ToSeconds(from - first_left_));
  const double end_s = std::min(all_s, ToSeconds(to - first_left_));
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
  if (num_damaged_ > 0) {
    warnings.push_back(std::to_string(num_damaged_) +
                       " messages are damaged and were left out; the first: " + first_damaged_);
  }
  return warnings;
}

}  // namespace facet
