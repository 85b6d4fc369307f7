// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/threaded_vio.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "facet/pipeline/process_frame.h"
#include "facet/pipeline/vio_stages.h"

namespace facet {

// A thread that runs the back halves of frames, in order.
class ThreadedVio::Worker {
 public:
  Worker() : thread_([this] { Run(); }) {}

  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  void Add(BackHalf back_half) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(back_half));
      ++num_added_;
    }
    changed_.notify_all();
  }

  // Waits until all frames but the newest `num_left` are done and returns those that are new.
  // Throws what the work threw: a programmer's error, or no memory.
  std::vector<ProcessedFrame> Collect(std::int64_t num_left) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return num_done_ >= num_added_ - num_left || failure_; });
    if (failure_) std::rethrow_exception(failure_);
    return std::exchange(done_, {});
  }

 private:
  void Run() {
    while (std::optional<BackHalf> back_half = Next()) {
      try {
        ProcessedFrame processed = (*back_half)();
        const std::lock_guard lock(mutex_);
        done_.push_back(std::move(processed));
        ++num_done_;
      } catch (...) {
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
        stop_ = true;
      }
      changed_.notify_all();
    }
  }

  // Waits for work; empty: there will be none.
  std::optional<BackHalf> Next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stop_ || !waiting_.empty(); });
    if (waiting_.empty() || failure_) return std::nullopt;
    BackHalf next = std::move(waiting_.front());
    waiting_.pop_front();
    return next;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stop_ = false;
  std::deque<BackHalf> waiting_;
  std::vector<ProcessedFrame> done_;
  std::int64_t num_added_ = 0, num_done_ = 0;
  std::exception_ptr failure_;
  std::thread thread_;  // last: starts when everything above exists
};

ThreadedVio::ThreadedVio(const StereoRig& rig,
                         const ImuNoise& noise,
                         const VioOptions& options,
                         PoseObserver on_pose)
    : stages_(std::make_unique<VioStages>(rig, noise, options)),
      on_pose_(std::move(on_pose)),
      worker_(std::make_unique<Worker>()) {}

ThreadedVio::~ThreadedVio() = default;

void ThreadedVio::AddImu(const ImuSample& sample) {
  stages_->front.AddImu(sample);
}

std::vector<VioOutput> ThreadedVio::AddStereo(const StereoFrame& frame) {
  auto& [front, pose, scene, loops] = *stages_;
  // The front stage may use feedback of frames kLag back, so those must be done.
  std::vector<VioOutput> ready = TakeDone(FrontStage::kLag - 1);
  worker_->Add(ProcessFrame(front, pose, scene, loops, frame, on_pose_));
  return ready;
}

std::vector<VioOutput> ThreadedVio::Finish() {
  return TakeDone(0);
}

std::vector<VioOutput> ThreadedVio::TakeDone(std::int64_t num_left) {
  std::vector<VioOutput> outputs;
  for (ProcessedFrame& processed : worker_->Collect(num_left)) {
    if (processed.feedback) stages_->front.AddFeedback(std::move(*processed.feedback));
    outputs.push_back(std::move(processed.output));
  }
  return outputs;
}

void ThreadedVio::RequestSceneUpdate() {
  stages_->scene.RequestUpdate();
}

RunResult ThreadedVio::Result() const {
  return stages_->Result();
}

RunResult ThreadedVio::TakeResult() {
  return stages_->TakeResult();
}

}  // namespace facet
