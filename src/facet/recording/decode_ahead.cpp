// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/decode_ahead.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "facet/base/check.h"

namespace facet {

namespace {

// A keyframe takes several times as long as the frames between.
constexpr int kFramesInReserve = 4;

struct Job {
  RecordedFrame frame;
  DecodedFrame decoded;
  std::exception_ptr failure;  // no memory: Take throws it on the caller's thread
  bool has_begun = false, is_done = false;
};

bool IsOwnedAlone(const cv::Mat& image) {
  return image.u != nullptr && image.u->refcount == 1;
}

}  // namespace

class DecodeAhead::Pool {
 public:
  Pool(const StereoRig& rig, int num_threads) : rig_(rig), decoder_(rig) {
    for (int i = 0; i < num_threads; ++i)
      threads_.emplace_back([this] { Run(); });
  }

  ~Pool() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_)
      thread.join();
  }

  void Add(const RecordedFrame& frame) {
    auto job = std::make_unique<Job>();
    job->frame = frame;
    if (!spare_.empty()) {
      job->decoded = std::move(spare_.back());
      spare_.pop_back();
    }
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
    }
    changed_.notify_all();
  }

  void Take(DecodedFrame& frame) {
    std::unique_lock lock(mutex_);
    while (!jobs_.front()->is_done) {
      if (Job* job = NextJob()) {
        DecodeUnlocked(decoder_, *job, lock);
      } else {
        changed_.wait(lock, [&] { return jobs_.front()->is_done; });
      }
    }
    const std::unique_ptr<Job> job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    if (job->failure) std::rethrow_exception(job->failure);
    std::swap(frame, job->decoded);
    Keep(std::move(job->decoded));
  }

 private:
  void Run() {
    FrameDecoder decoder(rig_);
    std::unique_lock lock(mutex_);
    while (true) {
      Job* job = nullptr;
      changed_.wait(lock, [&] { return stop_ || (job = NextJob()) != nullptr; });
      if (stop_) return;
      DecodeUnlocked(decoder, *job, lock);
      changed_.notify_all();
    }
  }

  // The oldest job that nobody has begun with; null: none.
  Job* NextJob() {
    const auto next =
        std::find_if(jobs_.begin(), jobs_.end(), [](const auto& job) { return !job->has_begun; });
    return next == jobs_.end() ? nullptr : next->get();
  }

  // A job stays where it is until it is done.
  static void DecodeUnlocked(FrameDecoder& decoder, Job& job, std::unique_lock<std::mutex>& lock) {
    job.has_begun = true;
    lock.unlock();
    try {
      decoder.Decode(job.frame, job.decoded);
    } catch (...) {  // kept for Take: nothing may leave a thread
      job.failure = std::current_exception();
    }
    lock.lock();
    job.is_done = true;
  }

  // Only the caller's thread knows who else holds the pixels.
  void Keep(DecodedFrame&& used) {
    for (cv::Mat* image : {&used.left, &used.right}) {
      if (!IsOwnedAlone(*image)) image->release();
    }
    if (!used.left.empty() || !used.right.empty()) spare_.push_back(std::move(used));
  }

  const StereoRig rig_;
  FrameDecoder decoder_;             // of the caller's thread
  std::vector<DecodedFrame> spare_;  // images to decode into; of the caller's thread
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stop_ = false;
  std::deque<std::unique_ptr<Job>> jobs_;
  std::vector<std::thread> threads_;  // last: they use everything above
};

DecodeAhead::DecodeAhead(const StereoRig& rig, int num_threads)
    : capacity_(num_threads + kFramesInReserve), pool_(std::make_unique<Pool>(rig, num_threads)) {
  FACET_CHECK(num_threads >= 1) << num_threads << " threads";
}

DecodeAhead::~DecodeAhead() = default;

void DecodeAhead::Add(const RecordedFrame& frame) {
  FACET_CHECK(num_under_way_ < capacity_) << "too many frames";
  ++num_under_way_;
  pool_->Add(frame);
}

void DecodeAhead::Take(DecodedFrame& frame) {
  FACET_CHECK(num_under_way_ > 0) << "no frame";
  --num_under_way_;
  pool_->Take(frame);
}

}  // namespace facet
