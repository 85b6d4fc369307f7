// SPDX-License-Identifier: BSD-2-Clause
#include "run_sequence.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <iterator>
#include <optional>
#include <thread>
#include <utility>

#include "process_usage.h"
#include "run_recorder.h"
#include "start_trouble.h"
#include "step_reader.h"
#include "warning_log.h"

#include "facet/base/check.h"
#include "facet/io/errors.h"
#include "facet/pipeline/refusal.h"
#include "facet/recording/decode_ahead.h"
#include "facet/recording/frame_decoder.h"
#include "facet/recording/image_turner.h"

namespace facet {
namespace {

using Clock = std::chrono::steady_clock;

double MsBetween(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - start).count();
}

double MsSince(Clock::time_point start) {
  return MsBetween(start, Clock::now());
}

/// Images of one camera that cannot be read.
struct UnusableImages {
  int num = 0;
  std::string first;  ///< what is wrong with the first one

  void Add(const std::string& problem) {
    if (num++ == 0) first = problem;
  }
};

/// What went wrong with the input, for the warnings of the run.
struct InputProblems {
  UnusableImages left, right;
  int num_turned = 0;       // right images
  Duration largest_turned;  // difference of the stamps
  int num_refused_imu = 0;
  int num_stray_imu = 0;
  ImuScreenCounts imu_screen;
};

class SequenceRunner {
 public:
  SequenceRunner(Recording& recording,
                 const VioFunctions& vio,
                 const RunRange& range,
                 const RunObserver& observer)
      : recording_(recording),
        vio_(vio),
        observer_(observer),
        range_(range),
        steps_(recording, range),
        decoder_(recording.calibration()->rig),
        turner_(recording.calibration()->rig.cameras[1]) {
    if (!steps_.FindFirst(step_)) steps_.ThrowNoPair();
    start_ = Clock::now();  // finding where to start is not what the run takes
    if (range.num_decoders > 0 && !range.realtime) {
      decode_ahead_.emplace(recording.calibration()->rig, range.num_decoders);
      decode_ahead_->Add(step_.frame);
    }
    RunRecord& record = run_.record;
    record.is_realtime = range.realtime;
    record.sequence = recording.name();
    record.calibration = recording.calibration()->source;
    record.first_pair = step_.frame.t;
    num_expected_ = steps_.NumFramesFrom(step_.frame.t);
  }

  SequenceRun Run() {
    const double cpu_start_s = ProcessCpuSeconds();
    bool has_step = true;
    while (has_step && run_.end == RunEnd::kComplete) {
      if (range_.realtime) DropLateFrames();
      TakeStep();
      const bool goes_on = ProcessFrame();
      if (!goes_on) Stop();
      has_step = next_ || (goes_on && NextStep(step_));
      if (next_) step_ = std::move(*std::exchange(next_, std::nullopt));
    }
    Deliver(vio_.finish());
    if (!refusal_.empty() && run_.end == RunEnd::kComplete) Stop();
    RequireImages();
    run_.record.num_frames = num_frames_;
    run_.record.duration_s = ToSeconds(frame_.t - run_.record.first_pair);
    run_.record.wall_s = 1e-3 * MsSince(start_);
    run_.record.cpu_s = ProcessCpuSeconds() - cpu_start_s;
    TakeResult(vio_.result());
    run_.record.peak_rss_mb = PeakRssMb();
    run_.record.warnings = recording_.Warnings();
    std::ranges::move(vio_warnings_.Texts(run_.record.first_pair),
                      std::back_inserter(run_.record.warnings));
    SummarizeProblems();
    if (run_.end == RunEnd::kComplete) JudgeDamage();
    if (run_.end == RunEnd::kComplete) JudgeTracking();
    if (!run_.message.empty()) run_.record.warnings.push_back(run_.message);
    recorder_.MoveInto(run_.record);
    return std::move(run_);
  }

 private:
  /// When the frame arrives in a run at recorded speed.
  Clock::time_point ArrivalOf(Timestamp t) const {
    return start_ + std::chrono::nanoseconds((t - run_.record.first_pair).ns);
  }

  /// Passes over frames that have a newer one that has arrived, too; counts them as dropped.
  void DropLateFrames() {
    const auto now = Clock::now();
    RunStep next;
    while (steps_.Next(next)) {
      if (ArrivalOf(next.frame.t) > now) {
        next_ = std::move(next);
        return;
      }
      ++run_.record.num_dropped;
      TakeStep();
      step_ = std::move(next);
    }
  }

  /// With threads that decode, reads on so that they have something to do.
  bool NextStep(RunStep& step) {
    if (!decode_ahead_) return steps_.Next(step);
    RunStep next;
    while (decode_ahead_->num_under_way() < decode_ahead_->capacity() && steps_.Next(next)) {
      decode_ahead_->Add(next.frame);
      steps_ahead_.push_back(std::move(next));
    }
    if (steps_ahead_.empty()) return false;
    step = std::move(steps_ahead_.front());
    steps_ahead_.pop_front();
    return true;
  }

  /// Its frame is the one to process, its IMU samples wait until a frame is fed.
  void TakeStep() {
    ++num_frames_;
    std::ranges::copy(step_.imu, std::back_inserter(unfed_imu_));
    std::ranges::copy(step_.imu, std::back_inserter(recent_imu_));
    frame_ = std::move(step_.frame);
    constexpr Duration kRecent{200000000};
    while (recent_imu_.size() > 1 && recent_imu_.back().t - recent_imu_.front().t > kRecent)
      recent_imu_.pop_front();
  }

  void FeedImu() {
    for (const ImuSample& sample : unfed_imu_)
      vio_.add_imu(sample);
    unfed_imu_.clear();
  }

  /// False when the observer wants to stop. A frame with an unusable left image is passed over.
  bool ProcessFrame() {
    const auto wall_start = Clock::now();
    PendingFrame frame{wall_start, {}};
    if (!Decode(frame.cost.decode_ms)) return true;
    const double decode_wall_ms = MsSince(wall_start);
    if (range_.realtime) {
      frame.arrival = ArrivalOf(frame_.t);
      std::this_thread::sleep_until(frame.arrival);
    }

    const auto vio_start = Clock::now();
    FeedImu();
    images_.t = frame_.t;
    start_trouble_.AddImages(images_);
    const std::vector<VioOutput> outputs = vio_.add_stereo(images_);
    frame.cost.wall_ms = decode_wall_ms + MsSince(vio_start);
    pending_.push_back(frame);
    return Deliver(outputs);
  }

  /// Records the outputs of the longest pending frames; false when the observer wants to stop.
  bool Deliver(const std::vector<VioOutput>& outputs) {
    bool goes_on = true;
    for (const VioOutput& output : outputs) {
      FACET_CHECK(!pending_.empty()) << "more outputs than frames";
      PendingFrame frame = pending_.front();
      pending_.pop_front();
      frame.cost.latency_ms = MsSince(frame.arrival);
      frame.cost.pose_latency_ms = vio_.when_posed
                                       ? MsBetween(frame.arrival, vio_.when_posed(output.t))
                                       : frame.cost.latency_ms;
      recorder_.Add(output, frame.cost);
      start_trouble_.AddOutput(output);
      if (!output.warning.empty()) vio_warnings_.Add(output.t, output.warning);
      if (refusal_.empty()) refusal_ = output.refusal;
      goes_on = observer_(Progress(), output) && goes_on && refusal_.empty();
    }
    return goes_on;
  }

  RunProgress Progress() const {
    return {num_frames_,
            std::max(num_expected_, num_frames_),
            run_.record.num_dropped,
            problems_.left.num,
            run_.record.first_pair,
            &recorder_.frames().back()};
  }

  /// False when the left image is unusable. Says how much processor time was spent, by whichever
  /// thread.
  bool Decode(double& cpu_ms) {
    if (decode_ahead_) {
      decode_ahead_->Take(decoded_);
    } else {
      decoder_.Decode(frame_, decoded_);
    }
    if (!decoded_.left_problem.empty()) {
      problems_.left.Add(decoded_.left_problem);
      return false;
    }
    if (!decoded_.right_problem.empty()) problems_.right.Add(decoded_.right_problem);
    // The images before these are decoded into.
    std::swap(images_.left, decoded_.left);
    std::swap(images_.right, decoded_.right);
    const double start_ms = ThreadCpuMs();
    TurnRightImage();
    cpu_ms = decoded_.cpu_ms + ThreadCpuMs() - start_ms;
    return true;
  }

  /// A right image of another moment becomes that of the moment of the left one, as far as the
  /// gyroscope knows how the camera turned in between.
  void TurnRightImage() {
    constexpr double kNoticed_px = 0.1;
    if (images_.right.empty() || frame_.t_right == frame_.t) return;
    const StereoRig& rig = recording_.calibration()->rig;
    const Quaterniond R_Bleft_Bright =
        RotationBetween(recent_imu_, frame_.t + rig.time_offset, frame_.t_right + rig.time_offset);
    const double angle = R_Bleft_Bright.angularDistance(Quaterniond::Identity());
    if (!(angle * rig.cameras[1].mean_focal_px() >= kNoticed_px)) return;
    const Quaterniond& R_BC = rig.T_BC[1].q;
    turner_.Turn((R_BC.conjugate() * R_Bleft_Bright.conjugate() * R_BC).toRotationMatrix(),
                 images_.right);
    ++problems_.num_turned;
    const Duration difference = std::max(frame_.t_right - frame_.t, frame_.t - frame_.t_right);
    problems_.largest_turned = std::max(problems_.largest_turned, difference);
  }

  void TakeResult(RunResult result) {
    RunRecord& record = run_.record;
    recorder_.Finish(result.window_keyframes);
    record.map = std::move(result.map);
    record.map_memory_mb = result.map_memory.used_mb;
    record.map_is_full = result.map_memory.is_full;
    record.planes = std::move(result.planes);
    record.loops = std::move(result.loops);
    record.estimated_calibration = std::move(result.calibration);
    problems_.num_refused_imu = result.num_refused_imu;
    problems_.num_stray_imu = result.num_stray_imu;
    problems_.imu_screen = result.imu_screen;
  }

  void Stop() {
    run_.end = refusal_.empty() ? RunEnd::kStopped : RunEnd::kRefused;
    const std::string after = std::to_string(num_frames_) + " of " +
                              std::to_string(std::max(num_expected_, num_frames_)) + " frames";
    const bool is_calibration = refusal_.starts_with(kWrongCalibration);
    run_.message = refusal_.empty()
                       ? "stopped after " + after
                       : (is_calibration ? run_.record.calibration : run_.record.sequence) + ": " +
                             refusal_ + " (stopped after " + after +
                             "; check_calibration=false goes on with it)";
  }

  /// Unusable images are like missing ones, unless there is nothing else.
  void RequireImages() const {
    if (run_.end != RunEnd::kComplete || !recorder_.frames().empty()) return;
    throw InputError(problems_.left.first + " (like all " + std::to_string(problems_.left.num) +
                     " left images that were read)");
  }

  void SummarizeProblems() {
    std::vector<std::string>& warnings = run_.record.warnings;
    const std::string of_all = " of " + std::to_string(run_.record.num_frames);
    run_.record.num_damaged = problems_.left.num;
    if (problems_.left.num > 0) {
      warnings.push_back(std::to_string(problems_.left.num) + of_all +
                         " left images are unusable, their frames were skipped; the first: " +
                         problems_.left.first);
    }
    if (problems_.right.num > 0) {
      warnings.push_back(std::to_string(problems_.right.num) + of_all +
                         " right images are unusable, their frames were used with the left image "
                         "only; the first: " +
                         problems_.right.first);
    }
    if (problems_.num_turned > 0) {
      char text[240];
      std::snprintf(text,
                    sizeof(text),
                    "%d%s right images have other stamps than their left ones (up to %.2f ms) and "
                    "were turned by the gyroscope to the moment of these; trigger the cameras "
                    "together",
                    problems_.num_turned,
                    of_all.c_str(),
                    1e3 * ToSeconds(problems_.largest_turned));
      warnings.emplace_back(text);
    }
    const auto when_last = [&](const Occurrences& what) {
      return what.WhenLast(run_.record.first_pair);
    };
    if (const Occurrences& resets = recorder_.resets(); resets.num > 0) {
      warnings.push_back("the estimator was lost and started over " + std::to_string(resets.num) +
                         " times" + when_last(resets) +
                         ": a new segment begins there (`segment` in states.csv), and it is as "
                         "uncertain as its sigmas say");
    }
    if (const Occurrences& gaps = recorder_.imu_gaps(); gaps.num > 0) {
      warnings.push_back("the IMU has " + std::to_string(gaps.num) + " holes" + when_last(gaps) +
                         "; poses in them are marked 'no IMU' or have larger sigmas");
    }
    if (problems_.num_refused_imu > 0) {
      warnings.push_back(std::to_string(problems_.num_refused_imu) +
                         " IMU samples were refused (not finite or not in order)");
    }
    if (problems_.num_stray_imu > 0) {
      warnings.push_back(std::to_string(problems_.num_stray_imu) +
                         " IMU samples have stamps far ahead of the ones around them and were left "
                         "out (clock, driver?)");
    }
    if (problems_.imu_screen.num_cut > 0) {
      warnings.push_back(std::to_string(problems_.imu_screen.num_cut) +
                         " IMU samples were cut out because the ones before and after them "
                         "contradict them (a glitch of the bus?)");
    }
    if (problems_.imu_screen.num_saturated > 0) {
      warnings.push_back(std::to_string(problems_.imu_screen.num_saturated) +
                         " IMU samples are at the end of the sensor's range; the estimate trusts "
                         "them less");
    }
    if (problems_.imu_screen.num_repeated > 0) {
      warnings.push_back(std::to_string(problems_.imu_screen.num_repeated) +
                         " IMU samples repeat the one before digit by digit; the estimate trusts "
                         "them less");
    }
    if (const Occurrences& repeated = recorder_.repeated_images(); repeated.num > 0) {
      warnings.push_back(std::to_string(repeated.num) + of_all +
                         " left images repeat an earlier one although the camera moves; they were "
                         "not used (driver, buffers?)" +
                         when_last(repeated));
    }
    if (const Occurrences& blank = recorder_.blank_images(); blank.num > 0) {
      warnings.push_back(std::to_string(blank.num) + of_all +
                         " left images have one grey value everywhere, most of them black ones "
                         "(lens covered, exposure?)" +
                         when_last(blank));
    }
    constexpr int kMostToKeep = 4;  // a moment says nothing of a recording
    if (const Occurrences& few = recorder_.few_landmarks(); few.num > kMostToKeep) {
      warnings.push_back(
          std::to_string(few.num) + of_all +
          " frames saw few landmarks, and the estimate is worse there (images out of "
          "focus, blurred, dark, without texture?)" +
          when_last(few));
    }
    if (run_.record.num_dropped > 0) {
      warnings.push_back(std::to_string(run_.record.num_dropped) + " frames arrived while busy");
    }
  }

  void JudgeDamage() {
    if (steps_.damage().empty()) return;
    run_.end = RunEnd::kDamaged;
    run_.message = steps_.damage() + "; the results up to there were written";
  }

  void JudgeTracking() {
    const std::vector<FrameRecord>& frames = recorder_.frames();
    const std::string reason = frames.back().reason;
    if (!recorder_.last_good()) {
      run_.end = RunEnd::kNotStarted;
      run_.message = "the estimator could not start: " + start_trouble_.Explain();
    } else if (!frames.back().has_pose) {
      run_.end = RunEnd::kLost;
      run_.message = "the estimator was lost at " + FormatSeconds(*recorder_.last_good()) +
                     " s and did not recover: " + reason + "; the results up to there were written";
    }
  }

  /// Fed, its output not seen yet.
  struct PendingFrame {
    Clock::time_point arrival;
    FrameCost cost;
  };

  Recording& recording_;
  const VioFunctions& vio_;
  const RunObserver& observer_;
  const RunRange range_;
  StepReader steps_;
  FrameDecoder decoder_;
  std::optional<DecodeAhead> decode_ahead_;
  std::deque<RunStep> steps_ahead_;  // those whose frames are decoded, but the newest taken one
  ImageTurner turner_;
  std::deque<ImuSample> recent_imu_;  // of the last moments before the frame in work, and one more
  Clock::time_point start_;
  SequenceRun run_;
  RunRecorder recorder_;
  StartTrouble start_trouble_;
  RunStep step_;                 // the newest one that was read, until it is taken
  std::optional<RunStep> next_;  // the one behind it, at recorded speed
  RecordedFrame frame_;          // the one in work
  DecodedFrame decoded_;
  StereoFrame images_;
  std::vector<ImuSample> unfed_imu_;
  std::deque<PendingFrame> pending_;
  int num_frames_ = 0, num_expected_ = 0;
  WarningLog vio_warnings_;
  InputProblems problems_;
  std::string refusal_;  // of the calibration
};

}  // namespace

SequenceRun RunSequence(Recording& recording,
                        const VioFunctions& vio,
                        const RunRange& range,
                        const RunObserver& observer) {
  return SequenceRunner(recording, vio, range, observer).Run();
}

}  // namespace facet
