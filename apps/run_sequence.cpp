// SPDX-License-Identifier: BSD-2-Clause
#include "run_sequence.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <thread>

#include "run_recorder.h"
#include "start_trouble.h"
#include <sys/resource.h>

#include "facet/base/check.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

using Clock = std::chrono::steady_clock;

// A frame this close to the border of the chosen part belongs to it: EuRoC's stamps jitter by 256
// ns.
constexpr double kStampJitterS = 1e-3;

double MsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double ProcessCpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double PeakRssMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024e-6;  // from KiB
}

/// Indices of the frames in the range; the first one is a stereo pair.
struct FrameInterval {
  std::size_t begin = 0, end = 0;
};

FrameInterval SelectFrames(const std::vector<FrameEntry>& frames, const RunRange& range) {
  const auto seconds = [&](const FrameEntry& f) { return ToSeconds(f.t - frames.front().t); };
  const double start_s = range.start_s - kStampJitterS;
  const double end_s = range.start_s + range.duration_s + kStampJitterS;
  FrameInterval part;
  while (part.begin < frames.size() &&
         (seconds(frames[part.begin]) < start_s || !frames[part.begin].HasRight())) {
    ++part.begin;
  }
  part.end = part.begin;
  while (part.end < frames.size() && seconds(frames[part.end]) <= end_s)
    ++part.end;
  if (part.begin == part.end) {
    char text[120];
    std::snprintf(text,
                  sizeof(text),
                  "--start %g --duration %g: no stereo pair there, the sequence lasts %.1f s",
                  range.start_s,
                  range.duration_s,
                  seconds(frames.back()));
    throw ConfigError(text);
  }
  return part;
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
  int num_refused_imu = 0;
  ImuScreenCounts imu_screen;
};

class SequenceRunner {
 public:
  SequenceRunner(AslDataset& dataset,
                 const VioFunctions& vio,
                 const RunRange& range,
                 const RunObserver& observer)
      : dataset_(dataset),
        vio_(vio),
        observer_(observer),
        range_(range),
        part_(SelectFrames(dataset.frames(), range)),
        start_(Clock::now()) {
    RunRecord& record = run_.record;
    record.sequence = dataset.name();
    record.calibration = dataset.calibration_source();
    record.warnings = dataset.warnings();
    record.first_pair = Stamp(part_.begin);
    record.num_frames = static_cast<int>(part_.end - part_.begin);
    record.duration_s = ToSeconds(Stamp(part_.end - 1) - Stamp(part_.begin));
  }

  SequenceRun Run() {
    const double cpu_start_s = ProcessCpuSeconds();
    SkipEarlyImu();
    for (std::size_t i = part_.begin; i < part_.end && run_.end == RunEnd::kComplete; ++i) {
      if (range_.realtime) i = DropLateFrames(i);
      if (!ProcessFrame(i)) StopAt(i);
    }
    Deliver(vio_.finish(), run_.record.num_frames);
    if (!refusal_.empty() && run_.end == RunEnd::kComplete) StopAt(part_.end - 1);
    RequireImages();
    run_.record.wall_s = 1e-3 * MsSince(start_);
    run_.record.cpu_s = ProcessCpuSeconds() - cpu_start_s;
    TakeResult(vio_.result());
    run_.record.peak_rss_mb = PeakRssMb();
    SummarizeProblems();
    if (run_.end == RunEnd::kComplete) JudgeTracking();
    if (!run_.message.empty()) run_.record.warnings.push_back(run_.message);
    recorder_.MoveInto(run_.record);
    return std::move(run_);
  }

 private:
  Timestamp Stamp(std::size_t i) const { return dataset_.frames()[i].t; }

  /// When the frame arrives in a run at recorded speed.
  Clock::time_point ArrivalOf(std::size_t i) const {
    return start_ + std::chrono::nanoseconds((Stamp(i) - Stamp(part_.begin)).ns);
  }

  /// Steps over the samples from before the run; the last one at or before its first frame stays.
  void SkipEarlyImu() {
    const auto& imu = dataset_.imu();
    const Timestamp first =
        Stamp(part_.begin) + dataset_.rig().time_offset - FromSeconds(range_.imu_history_s);
    while (next_imu_ + 1 < imu.size() && imu[next_imu_ + 1].t <= first)
      ++next_imu_;
  }

  void FeedImu(Timestamp image_stamp) {
    const auto& imu = dataset_.imu();
    const Timestamp until = image_stamp + dataset_.rig().time_offset;
    while (next_imu_ < imu.size() && (next_imu_ == 0 || imu[next_imu_ - 1].t <= until)) {
      vio_.add_imu(imu[next_imu_++]);
    }
  }

  /// The newest frame that has arrived, or `i` itself; counts the ones before it as dropped.
  std::size_t DropLateFrames(std::size_t i) {
    const auto now = Clock::now();
    for (; i + 1 < part_.end && ArrivalOf(i + 1) <= now; ++i)
      ++run_.record.num_dropped;
    return i;
  }

  /// False when the observer wants to stop. A frame with an unusable left image is passed over.
  bool ProcessFrame(std::size_t i) {
    const auto wall_start = Clock::now();
    const double decode_start_ms = ThreadCpuMs();
    if (!Decode(i)) return true;
    PendingFrame frame{wall_start, {}};
    frame.cost.decode_ms = ThreadCpuMs() - decode_start_ms;
    const double decode_wall_ms = MsSince(wall_start);
    if (range_.realtime) {
      frame.arrival = ArrivalOf(i);
      std::this_thread::sleep_until(frame.arrival);
    }

    const auto vio_start = Clock::now();
    FeedImu(Stamp(i));
    images_.t = Stamp(i);
    start_trouble_.AddImages(images_);
    const std::vector<VioOutput> outputs = vio_.add_stereo(images_);
    frame.cost.wall_ms = decode_wall_ms + MsSince(vio_start);
    pending_.push_back(frame);
    return Deliver(outputs, static_cast<int>(i + 1 - part_.begin));
  }

  /// Records the outputs of the longest pending frames; false when the observer wants to stop.
  bool Deliver(const std::vector<VioOutput>& outputs, int num_fed) {
    bool goes_on = true;
    for (const VioOutput& output : outputs) {
      FACET_CHECK(!pending_.empty()) << "more outputs than frames";
      PendingFrame frame = pending_.front();
      pending_.pop_front();
      frame.cost.latency_ms = MsSince(frame.arrival);
      recorder_.Add(output, frame.cost);
      start_trouble_.AddOutput(output);
      if (!output.warning.empty()) run_.record.warnings.push_back(output.warning);
      if (refusal_.empty()) refusal_ = output.refusal;
      goes_on = observer_(num_fed, run_.record.num_frames, output) && goes_on && refusal_.empty();
    }
    return goes_on;
  }

  /// False when the left image is unusable.
  bool Decode(std::size_t i) {
    try {
      const std::string problem = dataset_.ReadPair(i, images_.left, images_.right);
      if (!problem.empty()) problems_.right.Add(problem);
      return true;
    } catch (const InputError& error) {
      problems_.left.Add(error.what());
      return false;
    }
  }

  void TakeResult(RunResult result) {
    RunRecord& record = run_.record;
    recorder_.Finish(result.window_keyframes);
    record.map = std::move(result.map);
    record.map_memory_mb = result.map_memory.used_mb;
    record.map_is_full = result.map_memory.is_full;
    record.planes = std::move(result.planes);
    record.estimated_calibration = std::move(result.calibration);
    problems_.num_refused_imu = result.num_refused_imu;
    problems_.imu_screen = result.imu_screen;
  }

  void StopAt(std::size_t i) {
    run_.end = refusal_.empty() ? RunEnd::kStopped : RunEnd::kRefused;
    const std::string after = std::to_string(i + 1 - part_.begin) + " of " +
                              std::to_string(run_.record.num_frames) + " frames";
    run_.message = refusal_.empty()
                       ? "stopped after " + after
                       : run_.record.calibration +
                             ": the calibration cannot be right: " + refusal_ + " (stopped after " +
                             after + "; check_calibration=false goes on with it)";
    run_.record.num_frames = static_cast<int>(i + 1 - part_.begin);
    run_.record.duration_s = ToSeconds(Stamp(i) - Stamp(part_.begin));
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
    if (recorder_.num_resets() > 0) {
      warnings.push_back(
          "the estimator was lost and started over " + std::to_string(recorder_.num_resets()) +
          " times: a new segment begins there (`segment` in states.csv), and it is as "
          "uncertain as its sigmas say");
    }
    if (recorder_.num_imu_gaps() > 0) {
      warnings.push_back("the IMU has " + std::to_string(recorder_.num_imu_gaps()) +
                         " holes; poses in them are marked 'no IMU' or have larger sigmas");
    }
    if (problems_.num_refused_imu > 0) {
      warnings.push_back(std::to_string(problems_.num_refused_imu) +
                         " IMU samples were refused (not finite or not in order)");
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
    if (recorder_.num_repeated_images() > 0) {
      warnings.push_back(std::to_string(recorder_.num_repeated_images()) + of_all +
                         " left images repeat the one before although the camera moves; they were "
                         "not used");
    }
    if (recorder_.num_blank_images() > 0) {
      warnings.push_back(std::to_string(recorder_.num_blank_images()) + of_all +
                         " left images have one grey value everywhere, most of them black ones "
                         "(lens covered, exposure?)");
    }
    if (run_.record.num_dropped > 0) {
      warnings.push_back(std::to_string(run_.record.num_dropped) + " frames arrived while busy");
    }
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

  AslDataset& dataset_;
  const VioFunctions& vio_;
  const RunObserver& observer_;
  const RunRange range_;
  const FrameInterval part_;
  const Clock::time_point start_;
  SequenceRun run_;
  RunRecorder recorder_;
  StartTrouble start_trouble_;
  StereoFrame images_;
  std::deque<PendingFrame> pending_;
  std::size_t next_imu_ = 0;
  InputProblems problems_;
  std::string refusal_;  // of the calibration
};

}  // namespace

SequenceRun RunSequence(AslDataset& dataset,
                        const VioFunctions& vio,
                        const RunRange& range,
                        const RunObserver& observer) {
  return SequenceRunner(dataset, vio, range, observer).Run();
}

}  // namespace facet
