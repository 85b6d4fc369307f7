// SPDX-License-Identifier: BSD-2-Clause
#include "facet/check/check_recording.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "facet/check/detector.h"
#include "facet/io/errors.h"
#include "facet/recording/frame_decoder.h"

namespace facet {
namespace {

// Of a longer recording, stretches of this length are looked at, evenly spread.
constexpr int kMostFrames = 2400;
constexpr double kStretch_s = 2;
// Right images cost as much as left ones and are needed for the geometry only.
constexpr double kBetweenRight_s = 0.5;
constexpr double kStampShare = 0.007;
// Of the images that were looked at.
constexpr double kDamagedShare = 0.02;

/// Which frames are decoded.
class Schedule {
 public:
  /// `num_frames`: about how many there are.
  explicit Schedule(int num_frames)
      : share_(num_frames > kMostFrames ? static_cast<double>(kMostFrames) / num_frames : 1) {}

  bool IsLookedAt(double t_s) const {
    const double period_s = kStretch_s / share_;
    return t_s - period_s * std::floor(t_s / period_s) <= kStretch_s;
  }

 private:
  double share_;
};

class Examination {
 public:
  Examination(Recording& recording, const std::function<void(int, int)>& progress)
      : recording_(recording),
        progress_(progress),
        detectors_(MakeDetectors(recording.calibration())) {
    if (recording.calibration() != nullptr) {
      decoder_.emplace(recording.calibration()->rig);
      offset_ = recording.calibration()->rig.time_offset;
    }
  }

  CheckReport Run() {
    try {
      while (const auto event = recording_.Next()) {
        if (const auto* sample = std::get_if<ImuSample>(&*event)) {
          TakeImu(*sample);
        } else {
          TakeFrame(std::get<RecordedFrame>(*event));
        }
      }
    } catch (const InputError& error) {
      report_.Add({"damaged",
                   Sureness::kCertain,
                   std::string("the recording cannot be read to its end: ") + error.what(),
                   "copy it again, or use it up to there"});
    }
    Finish();
    return std::move(report_);
  }

 private:
  void TakeImu(ImuSample sample) {
    sample.t = sample.t - offset_;
    ++report_.num_imu;
    for (const auto& detector : detectors_)
      detector->OnImu(sample);
  }

  void TakeFrame(const RecordedFrame& frame) {
    if (report_.num_frames++ == 0) {
      report_.first_frame = frame.t;
      constexpr Timestamp kEnd{std::numeric_limits<std::int64_t>::max()};
      num_expected_ = recording_.NumFrames(frame.t, kEnd);
      schedule_ = Schedule(num_expected_);
    }
    report_.duration_s = ToSeconds(frame.t - report_.first_frame);
    if (progress_) progress_(report_.num_frames, std::max(num_expected_, report_.num_frames));
    for (const auto& detector : detectors_)
      detector->OnFrame(frame);
    const bool is_looked_at = schedule_.IsLookedAt(report_.duration_s) && Look(frame);
    follows_ = is_looked_at;
  }

  /// False if the left image cannot be used.
  bool Look(const RecordedFrame& frame) {
    RecordedFrame wanted = frame;
    const bool is_right_due =
        !last_right_ || ToSeconds(frame.t - *last_right_) > kBetweenRight_s - 0.001;
    if (!is_right_due) wanted.right = nullptr;
    ImagePair pair;
    pair.t = frame.t;
    pair.follows = follows_;
    try {
      const std::string problem = Decode(wanted, pair);
      if (!problem.empty()) NoteDamage(problem);
    } catch (const InputError& error) {
      NoteDamage(error.what());
      return false;
    }
    if (!pair.right.empty()) last_right_ = frame.t;
    ++report_.num_looked_at;
    for (const auto& detector : detectors_)
      detector->OnImages(pair);
    return true;
  }

  std::string Decode(const RecordedFrame& frame, ImagePair& pair) {
    if (decoder_) return decoder_->Decode(frame, pair.left, pair.right);
    frame.left->Decode({}, reader_, pair.left);
    if (frame.HasRight()) frame.right->Decode({}, reader_, pair.right);
    return {};
  }

  void NoteDamage(const std::string& problem) {
    if (num_damaged_++ == 0) first_damage_ = problem;
  }

  void Finish() {
    if (recording_.calibration() == nullptr) {
      report_.Add({"no_calibration",
                   Sureness::kCertain,
                   "the recording has no calibration and none was given",
                   "give one with --calibration; without it only streams and images were checked"});
    }
    FinishStamps("images", recording_.ImagesLeftOut(), report_.num_frames);
    FinishStamps("IMU samples", recording_.ImuLeftOut(), report_.num_imu);
    if (num_damaged_ > kDamagedShare * (report_.num_looked_at + num_damaged_)) {
      report_.Add(
          {"damaged",
           Sureness::kCertain,
           Text("%d images cannot be used; the first: %s", num_damaged_, first_damage_.c_str()),
           "copy the recording again"});
    }
    for (const auto& detector : detectors_)
      detector->Finish(report_);
    report_.notes = recording_.Warnings();
  }

  void FinishStamps(const char* what, const StampCounts& left_out, int num_used) {
    const int least = std::max(1, static_cast<int>(kStampShare * num_used));
    if (left_out.num_backward >= least) {
      report_.Add({"stamps_backward",
                   Sureness::kCertain,
                   Text("stamps of %d %s run backwards; %d are in order",
                        left_out.num_backward,
                        what,
                        num_used),
                   "sort the lines by their stamps; look for several publishers on one topic, or "
                   "for a clock that is set while recording"});
    }
    if (left_out.num_repeated >= least) {
      report_.Add({"stamps_repeated",
                   Sureness::kCertain,
                   Text("%d %s have the stamp of the one before", left_out.num_repeated, what),
                   "stamp at the sensor with full resolution; look for two publishers on one "
                   "topic"});
    }
  }

  Recording& recording_;
  const std::function<void(int, int)>& progress_;
  std::vector<std::unique_ptr<Detector>> detectors_;
  std::optional<FrameDecoder> decoder_;
  ImageReader reader_;
  Duration offset_;
  Schedule schedule_{0};
  CheckReport report_;
  int num_expected_ = 0, num_damaged_ = 0;
  std::string first_damage_;
  bool follows_ = false;
  std::optional<Timestamp> last_right_;
};

}  // namespace

CheckReport CheckRecording(Recording& recording, const std::function<void(int, int)>& progress) {
  return Examination(recording, progress).Run();
}

}  // namespace facet
