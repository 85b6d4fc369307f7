// SPDX-License-Identifier: BSD-2-Clause
#include "facet/live/live_vio.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "facet/base/check.h"
#include "facet/pipeline/threaded_vio.h"
#include "facet/pipeline/vio_pipeline.h"

namespace facet {

namespace {

using Clock = std::chrono::steady_clock;

struct WaitingFrame {
  StereoFrame frame;
  Clock::time_point arrival;
};

/// A frame and the samples that lead to it.
struct Work {
  WaitingFrame frame;
  std::vector<ImuSample> imu;
};

/// What waits for the estimator. Thread-safe.
class LiveQueue {
 public:
  LiveQueue(const LiveOptions& options, Duration time_offset)
      : options_(options), time_offset_(time_offset) {}

  void Add(const ImuSample& sample) {
    const std::lock_guard lock(mutex_);
    ++counts_.imu;
    if (is_closed_) {
      ++counts_.dropped_imu;
      return;
    }
    imu_.push_back(sample);
    if (imu_.size() > options_.max_waiting_imu) {
      imu_.pop_front();
      ++counts_.dropped_imu;
    }
    if (!frames_.empty()) changed_.notify_all();
  }

  void Add(const StereoFrame& frame) {
    const std::lock_guard lock(mutex_);
    ++counts_.frames;
    if (is_closed_) {
      ++counts_.dropped_frames;
      return;
    }
    frames_.push_back({frame, Clock::now()});
    if (frames_.size() > options_.max_waiting_frames) {
      frames_.pop_front();
      ++counts_.dropped_frames;
    }
    changed_.notify_all();
  }

  /// Waits for a frame and its samples. False: there will be none.
  bool Take(Work& work) {
    std::unique_lock lock(mutex_);
    const auto patience = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(options_.max_imu_wait_s));
    while (true) {
      changed_.wait(lock, [this] { return is_closed_ || !frames_.empty(); });
      if (frames_.empty()) return false;
      const auto deadline = frames_.front().arrival + patience;
      if (HasImu(frames_.front()) || is_closed_ || Clock::now() >= deadline) break;
      changed_.wait_until(lock, deadline);
    }
    counts_.late_imu_frames += HasImu(frames_.front()) ? 0 : 1;
    work.frame = std::move(frames_.front());
    frames_.pop_front();
    TakeImu(work);
    return true;
  }

  /// A pose is known. `arrival`: of its frame.
  void AddDone(Clock::time_point arrival) {
    const std::lock_guard lock(mutex_);
    ++counts_.done_frames;
    counts_.latency_s = std::chrono::duration<double>(Clock::now() - arrival).count();
    counts_.max_latency_s = std::max(counts_.max_latency_s, counts_.latency_s);
  }

  /// Nothing is taken in any more; what waits goes on to be worked on, unless `drop`.
  void Close(bool drop) {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
    if (drop) {
      counts_.dropped_frames += static_cast<std::int64_t>(frames_.size());
      frames_.clear();
    }
    changed_.notify_all();
  }

  void Fail() {
    Close(true);
    const std::lock_guard lock(mutex_);
    counts_.has_failed = true;
  }

  LiveCounts counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
  }

 private:
  Timestamp EndOf(const WaitingFrame& waiting) const { return waiting.frame.t + time_offset_; }

  bool HasImu(const WaitingFrame& waiting) const {
    return !imu_.empty() && imu_.back().t > EndOf(waiting);
  }

  // Those up to the frame and one more, whatever has come since: what a frame is given depends on
  // the recording and not on the speed of the machine.
  void TakeImu(Work& work) {
    const Timestamp end = EndOf(work.frame);
    work.imu.clear();
    while (!imu_.empty()) {
      work.imu.push_back(imu_.front());
      imu_.pop_front();
      if (work.imu.back().t > end) break;
    }
  }

  const LiveOptions options_;
  const Duration time_offset_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_closed_ = false;
  std::deque<WaitingFrame> frames_;
  std::deque<ImuSample> imu_;
  LiveCounts counts_;
};

/// VioPipeline or ThreadedVio, with the same functions.
class Vio {
 public:
  Vio(const StereoRig& rig,
      const ImuNoise& noise,
      const VioOptions& options,
      bool two_threads,
      PoseObserver on_pose)
      : on_pose_(std::move(on_pose)) {
    if (two_threads) {
      two_ = std::make_unique<ThreadedVio>(rig, noise, options, on_pose_);
    } else {
      one_ = std::make_unique<VioPipeline>(rig, noise, options);
    }
  }

  void AddImu(const ImuSample& sample) { two_ ? two_->AddImu(sample) : one_->AddImu(sample); }
  std::vector<VioOutput> AddStereo(const StereoFrame& frame) {
    if (two_) return two_->AddStereo(frame);
    std::vector<VioOutput> outputs;
    outputs.push_back(one_->AddStereo(frame, on_pose_));
    return outputs;
  }
  void RequestSceneUpdate() { two_ ? two_->RequestSceneUpdate() : one_->RequestSceneUpdate(); }
  std::vector<VioOutput> Finish() { return two_ ? two_->Finish() : std::vector<VioOutput>(); }
  RunResult Result() const { return two_ ? two_->Result() : one_->Result(); }

 private:
  PoseObserver on_pose_;
  std::unique_ptr<VioPipeline> one_;
  std::unique_ptr<ThreadedVio> two_;
};

}  // namespace

class LiveVio::Impl {
 public:
  Impl(const StereoRig& rig,
       const ImuNoise& noise,
       const VioOptions& options,
       const LiveOptions& live,
       PoseObserver on_pose,
       std::function<void(const VioOutput&)> on_output)
      : predictor_(noise, options.estimator.imu, live.prediction),
        queue_(live, rig.time_offset),
        on_pose_(std::move(on_pose)),
        on_output_(std::move(on_output)),
        vio_(rig,
             noise,
             options,
             live.two_threads,
             [this](const VioOutput& output) { TakePose(output); }),
        thread_([this] { Run(); }) {}

  ~Impl() {
    queue_.Close(true);
    if (thread_.joinable()) thread_.join();
  }

  StatePredictor& predictor() { return predictor_; }
  LiveQueue& queue() { return queue_; }
  void RequestSceneUpdate() { vio_.RequestSceneUpdate(); }

  RunResult Finish() {
    queue_.Close(false);
    if (thread_.joinable()) thread_.join();
    if (failure_) std::rethrow_exception(failure_);
    return vio_.Result();
  }

 private:
  void Run() {
    try {
      for (Work work; queue_.Take(work);) {
        for (const ImuSample& sample : work.imu)
          vio_.AddImu(sample);
        {
          const std::lock_guard lock(arrivals_mutex_);
          arrivals_.push_back(work.frame.arrival);
        }
        Deliver(vio_.AddStereo(work.frame.frame));
      }
      Deliver(vio_.Finish());
    } catch (...) {
      failure_ = std::current_exception();  // Finish throws it
      queue_.Fail();
    }
  }

  // Frame by frame in their order, by whichever thread estimates.
  void TakePose(const VioOutput& output) {
    predictor_.AddFrame(output.causal, output.has_pose, output.status, output.segment);
    Clock::time_point arrival;
    {
      const std::lock_guard lock(arrivals_mutex_);
      FACET_CHECK(!arrivals_.empty()) << "more poses than frames";
      arrival = arrivals_.front();
      arrivals_.pop_front();
    }
    queue_.AddDone(arrival);
    if (on_pose_) on_pose_(output);
  }

  void Deliver(const std::vector<VioOutput>& outputs) {
    if (!on_output_) return;
    for (const VioOutput& output : outputs)
      on_output_(output);
  }

  StatePredictor predictor_;
  LiveQueue queue_;
  const PoseObserver on_pose_;
  const std::function<void(const VioOutput&)> on_output_;
  std::mutex arrivals_mutex_;
  std::deque<Clock::time_point> arrivals_;  // of the frames that the estimator works on
  std::exception_ptr failure_;
  Vio vio_;
  std::thread thread_;  // last: it uses the others
};

LiveVio::LiveVio(const StereoRig& rig,
                 const ImuNoise& noise,
                 const VioOptions& options,
                 const LiveOptions& live,
                 PoseObserver on_pose,
                 std::function<void(const VioOutput&)> on_output)
    : impl_(std::make_unique<Impl>(
          rig, noise, options, live, std::move(on_pose), std::move(on_output))) {
  FACET_CHECK(live.max_waiting_frames > 0) << "a queue of no frames drops all of them";
}

LiveVio::~LiveVio() = default;

void LiveVio::AddImu(const ImuSample& sample) {
  impl_->predictor().AddImu(sample);
  impl_->queue().Add(sample);
}

void LiveVio::AddStereo(const StereoFrame& frame) {
  impl_->queue().Add(frame);
}

std::optional<PredictedState> LiveVio::PredictAt(Timestamp t) const {
  return impl_->predictor().PredictAt(t);
}

void LiveVio::RequestSceneUpdate() {
  impl_->RequestSceneUpdate();
}

LiveCounts LiveVio::counts() const {
  return impl_->queue().counts();
}

RunResult LiveVio::Finish() {
  return impl_->Finish();
}

}  // namespace facet
