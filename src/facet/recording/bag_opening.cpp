// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/bag_opening.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "facet/io/errors.h"
#include "facet/messages/message_image.h"
#include "facet/recording/sensor_messages.h"

namespace facet {
namespace {

// From the first left image on.
constexpr Duration kOpeningTime{3000000000};

double MedianSeconds(std::vector<std::int64_t> values_ns) {
  if (values_ns.empty()) return 0;
  const auto middle = values_ns.begin() + static_cast<std::ptrdiff_t>(values_ns.size() / 2);
  std::nth_element(values_ns.begin(), middle, values_ns.end());
  return static_cast<double>(*middle) * 1e-9;
}

/// By how much the recorder's stamps are later than those of the headers.
double MedianDelaySeconds(const std::vector<BagOpening::Stamps>& stamps) {
  std::vector<std::int64_t> delays_ns;
  for (const BagOpening::Stamps& stamp : stamps)
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

/// Collects what the messages of interest say.
class OpeningReader {
 public:
  OpeningReader(MessageSource& source, const TopicChoice& choice)
      : source_(source), choice_(choice) {
    const std::size_t images[] = {choice.left, choice.right};
    for (std::size_t i = 0; i < 2; ++i) {
      opening_.calibration.are_rectified[i] =
          source.topics()[images[i]].name.find("rect") != std::string::npos;
    }
  }

  BagOpening Read(const std::string& place) {
    source_.Rewind();
    std::optional<Timestamp> first_left;
    try {
      while (const auto message = source_.Next()) {
        Add(*message);
        if (!first_left && !opening_.left.empty()) first_left = message->received;
        if (first_left && message->received - *first_left > kOpeningTime) break;
      }
    } catch (const InputError&) {
      if (opening_.left.empty() || opening_.right.empty() || opening_.imu.empty()) throw;
    }
    const auto require = [&](const std::vector<BagOpening::Stamps>& stamps, std::size_t topic) {
      if (!stamps.empty()) return;
      throw InputError(place + ": no usable message of " + source_.topics()[topic].name +
                       " in the first seconds" +
                       (first_damaged_.empty() ? "" : "; " + first_damaged_));
    };
    require(opening_.left, choice_.left);
    require(opening_.right, choice_.right);
    require(opening_.imu, choice_.rates());
    return std::move(opening_);
  }

 private:
  void Add(const Message& message) {
    constexpr std::size_t kMaxTransforms = 10000;
    const Topic& topic = source_.topics()[message.topic];
    RosCalibrationMessages& calibration = opening_.calibration;
    try {
      if (message.topic == choice_.left || message.topic == choice_.right) {
        AddImage(message, message.topic == choice_.left ? 0 : 1);
      } else if (message.topic == choice_.rates()) {
        const ImuMessage imu = ReadImuMessage(message.bytes, topic.encoding);
        opening_.imu.push_back({imu.header.t, message.received});
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
      if (first_damaged_.empty())
        first_damaged_ = source_.PlaceOf(message) + ": " + topic.name + ": " + error.what();
    }
  }

  void AddImage(const Message& message, std::size_t camera) {
    constexpr int kNumSampleImages = 10;
    const ImageMessage image = ReadAnyImageMessage(source_.topics()[message.topic], message.bytes);
    (camera == 0 ? opening_.left : opening_.right).push_back({image.header.t, message.received});
    opening_.calibration.camera_frames[camera] = image.header.frame;
    if (num_sample_images_++ < kNumSampleImages) {
      opening_.largest_sample = std::max(opening_.largest_sample, LargestSample(image, reader_));
    }
  }

  MessageSource& source_;
  const TopicChoice& choice_;
  BagOpening opening_;
  ImageReader reader_;
  int num_sample_images_ = 0;
  std::string first_damaged_;
};

void FindMissingStamps(const BagOpening& opening,
                       const TopicChoice& choice,
                       const std::vector<Topic>& topics,
                       BagStamps& stamps) {
  const std::pair<const std::vector<BagOpening::Stamps>*, std::size_t> streams[] = {
      {&opening.left, choice.left}, {&opening.right, choice.right}, {&opening.imu, choice.rates()}};
  for (const auto& [stream, topic] : streams) {
    const bool has_none = std::ranges::all_of(
        *stream, [](const BagOpening::Stamps& one) { return one.header.ns == 0; });
    if (!has_none) continue;
    stamps.topics_without.insert(topic);
    stamps.warnings.push_back(topics[topic].name +
                              ": the messages have no stamps; those of the recorder are used, "
                              "which are late and irregular");
  }
  if (choice.accel && stamps.topics_without.contains(choice.rates()))
    stamps.topics_without.insert(*choice.accel);
}

void JudgeDelays(const BagOpening& opening, const std::string& place, BagStamps& stamps) {
  constexpr double kOddDelay_s = 1, kOddDifference_s = 0.1, kOtherClock_s = 10;
  if (!stamps.topics_without.empty()) return;
  const double camera_s = MedianDelaySeconds(opening.left), imu_s = MedianDelaySeconds(opening.imu);
  if (std::abs(camera_s - imu_s) > kOtherClock_s) {
    throw InputError(place + ": camera and IMU do not overlap in time: " +
                     Text("the recorder got images %.3f s after their stamps and IMU samples "
                          "%.3f s after theirs; are the stamps of the same clock and unit?",
                          camera_s,
                          imu_s));
  }
  if (std::abs(camera_s - imu_s) > kOddDifference_s) {
    stamps.warnings.push_back(
        Text("the recorder got images %.3f s after their stamps, but IMU samples "
             "%.3f s after theirs; if the clocks differ, calibrate the time offset",
             camera_s,
             imu_s));
  } else if (std::abs(camera_s) > kOddDelay_s) {
    stamps.warnings.push_back(
        Text("messages were recorded %.3f s after their stamps; the stamps are used", camera_s));
  }
}

}  // namespace

BagOpening ReadBagOpening(MessageSource& source,
                          const TopicChoice& choice,
                          const std::string& place) {
  return OpeningReader(source, choice).Read(place);
}

BagStamps JudgeStamps(const BagOpening& opening,
                      const TopicChoice& choice,
                      const std::vector<Topic>& topics,
                      const std::string& place) {
  BagStamps stamps;
  FindMissingStamps(opening, choice, topics, stamps);
  JudgeDelays(opening, place, stamps);
  const bool has_stamps = !stamps.topics_without.contains(choice.left);
  std::vector<Timestamp> left;
  for (const BagOpening::Stamps& one : opening.left)
    left.push_back(has_stamps ? one.header : one.received);
  stamps.tolerance = FromSeconds(MedianIntervalSeconds(left) / 8);
  stamps.first_left = left.front();
  return stamps;
}

}  // namespace facet
