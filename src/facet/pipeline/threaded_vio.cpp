// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/threaded_vio.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "facet/pipeline/back_stage.h"
#include "facet/pipeline/front_stage.h"

namespace facet {

struct ThreadedVio::Impl {
  Impl(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
      : front(rig, options), back(rig, noise, options), worker([this] { Work(); }) {}

  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stop = true;
    }
    changed.notify_all();
    worker.join();
  }

  // The back stage's thread: packets in, outputs and feedback out, in order.
  void Work() {
    while (true) {
      FrontPacket packet;
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [this] { return stop || !packets.empty(); });
        if (packets.empty()) return;
        packet = std::move(packets.front());
        packets.pop_front();
      }
      try {
        VioOutput output = back.Process(packet);
        const std::lock_guard lock(mutex);
        outputs.push_back(std::move(output));
        if (back.feedback()) feedback.push_back(*back.feedback());
        ++num_done;
      } catch (...) {
        // A programmer's error or no memory: the caller's thread has to hear of it.
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
        stop = true;
      }
      changed.notify_all();
      if (failure) return;
    }
  }

  // Waits until `count` frames have passed the back stage and takes what they left.
  std::vector<VioOutput> Collect(std::int64_t count) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return num_done >= count || failure; });
    if (failure) std::rethrow_exception(failure);
    for (Feedback& f : feedback)
      front.AddFeedback(std::move(f));
    feedback.clear();
    return std::exchange(outputs, {});
  }

  FrontStage front;  // caller's thread
  BackStage back;    // worker's thread
  std::int64_t num_sent = 0;
  int num_refused_imu = 0;

  std::mutex mutex;
  std::condition_variable changed;
  bool stop = false;
  std::deque<FrontPacket> packets;
  std::vector<VioOutput> outputs;
  std::vector<Feedback> feedback;
  std::int64_t num_done = 0;
  std::exception_ptr failure;  // set once, by the worker

  std::thread worker;  // last: starts when everything above exists
};

ThreadedVio::ThreadedVio(const StereoRig& rig, const ImuNoise& noise, const VioOptions& options)
    : impl_(std::make_unique<Impl>(rig, noise, options)) {}

ThreadedVio::~ThreadedVio() = default;

void ThreadedVio::AddImu(const ImuSample& sample) {
  if (impl_->front.AddImu(sample) != ImuBuffer::AddResult::kAdded) ++impl_->num_refused_imu;
}

std::vector<VioOutput> ThreadedVio::AddStereo(const StereoFrame& frame) {
  // The front stage may use feedback of frames kLag back, so those must be done.
  std::vector<VioOutput> ready = impl_->Collect(impl_->num_sent - FrontStage::kLag + 1);
  FrontPacket packet = impl_->front.Process(frame);
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->packets.push_back(std::move(packet));
    ++impl_->num_sent;
  }
  impl_->changed.notify_all();
  return ready;
}

std::vector<VioOutput> ThreadedVio::Finish() {
  return impl_->Collect(impl_->num_sent);
}

std::vector<KeyframePose> ThreadedVio::WindowKeyframes() const {
  return impl_->back.WindowKeyframes();
}

std::optional<TriangleMesh> ThreadedVio::Map() const {
  return impl_->back.Map();
}

MapMemory ThreadedVio::map_memory() const {
  return impl_->back.map_memory();
}

std::vector<PlaneRecord> ThreadedVio::Planes() const {
  return impl_->back.Planes();
}

int ThreadedVio::num_refused_imu() const {
  return impl_->num_refused_imu;
}

}  // namespace facet
