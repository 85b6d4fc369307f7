// SPDX-License-Identifier: BSD-2-Clause
// `facet info`: topics, rates, gaps, resolution, duration and calibration of a recording.
#include "info.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <variant>

#include "facet/io/errors.h"
#include "facet/recording/open_recording.h"

namespace facet {
namespace {

/// Stamps of one kind of event.
class StampStatistics {
 public:
  void Add(Timestamp t) {
    if (last_) intervals_s_.push_back(static_cast<float>(ToSeconds(t - *last_)));
    if (!first_) first_ = t;
    last_ = t;
    ++num_;
  }

  bool empty() const { return num_ == 0; }
  int num() const { return num_; }
  double Seconds() const { return first_ ? ToSeconds(*last_ - *first_) : 0; }

  void Print(const char* name) {
    std::printf("  %-14s %8d", name, num_);
    if (intervals_s_.empty()) {
      std::printf("\n");
      return;
    }
    const auto middle = intervals_s_.begin() + static_cast<std::ptrdiff_t>(intervals_s_.size() / 2);
    std::nth_element(intervals_s_.begin(), middle, intervals_s_.end());
    const double median_s = *middle;
    const auto is_gap = [&](float interval_s) { return interval_s > 2.5 * median_s; };
    std::printf("  %8.2f Hz  %d gaps, longest interval %.3f s\n",
                1 / median_s,
                static_cast<int>(std::ranges::count_if(intervals_s_, is_gap)),
                static_cast<double>(*std::ranges::max_element(intervals_s_)));
  }

 private:
  int num_ = 0;
  std::optional<Timestamp> first_, last_;
  std::vector<float> intervals_s_;  // four bytes for each event
};

void PrintTopics(const std::string& path) {
  const std::unique_ptr<MessageSource> messages = OpenMessages(path);
  if (!messages) {
    const FolderKind kind = KindOfFolder(path);
    const char* layout = kind == FolderKind::kAsl     ? "the ASL layout"
                         : kind == FolderKind::kKitti ? "the layout of KITTI's raw data"
                                                      : "the plain layout";
    if (kind != FolderKind::kOther) std::printf("kind: folder in %s\n", layout);
    return;
  }
  std::printf("kind: %s\ntopics:\n", messages->Kind().c_str());
  for (const Topic& topic : messages->topics()) {
    std::printf("  %-40s %-28s", topic.name.c_str(), topic.type.c_str());
    if (topic.num_messages > 0)
      std::printf(" %8llu", static_cast<unsigned long long>(topic.num_messages));
    std::printf("%s\n", topic.encoding == MessageEncoding::kOther ? " (cannot be decoded)" : "");
  }
}

void PrintCalibration(const Recording& recording) {
  if (recording.calibration() == nullptr) {
    std::printf("calibration: none; give one with --calibration\n");
    return;
  }
  const StereoRig& rig = recording.calibration()->rig;
  std::printf("calibration: %s\n  baseline %.4f m\n",
              recording.calibration()->source.c_str(),
              rig.baseline_m());
}

/// Of the first images that can be decoded.
std::string SizeText(const EncodedImage& image) {
  ImageReader reader;
  cv::Mat grey;
  try {
    const cv::Size size = image.Decode({}, reader, grey);
    return std::to_string(size.width) + " x " + std::to_string(size.height);
  } catch (const InputError&) {
    return {};
  }
}

/// Empty, or where reading ended.
std::string PrintContent(Recording& recording) {
  StampStatistics pairs, mono, imu;
  std::string left, right, damage;
  try {
    while (const auto event = recording.Next()) {
      if (const auto* sample = std::get_if<ImuSample>(&*event)) {
        imu.Add(sample->t);
        continue;
      }
      const auto& frame = std::get<RecordedFrame>(*event);
      (frame.HasRight() ? pairs : mono).Add(frame.t);
      if (left.empty()) left = SizeText(*frame.left);
      if (right.empty() && frame.HasRight()) right = SizeText(*frame.right);
    }
  } catch (const InputError& error) {
    damage = error.what();
  }
  std::printf("duration: %.2f s\nimages: left %s, right %s pixels\nstream:\n",
              pairs.Seconds(),
              left.c_str(),
              right.c_str());
  pairs.Print("stereo pairs");
  if (!mono.empty()) mono.Print("left alone");
  imu.Print("IMU samples");
  return damage;
}

}  // namespace

void InfoCommand(const InfoArguments& arguments) {
  RecordingOptions options;
  options.calibration = {arguments.calibration, arguments.imu_calibration};
  options.topics = ParseTopics(arguments.topics);
  options.needs_calibration = false;
  PrintTopics(arguments.recording);
  std::fflush(stdout);
  const std::unique_ptr<Recording> recording = OpenRecording(arguments.recording, options);
  std::printf("name: %s\n", recording->name().c_str());
  const std::string damage = PrintContent(*recording);
  PrintCalibration(*recording);
  for (const std::string& warning : recording->Warnings())
    std::printf("warning: %s\n", warning.c_str());
  std::fflush(stdout);
  if (!damage.empty()) throw InputError(damage);
}

}  // namespace facet
