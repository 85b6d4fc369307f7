// SPDX-License-Identifier: BSD-2-Clause
// A run as messages, while it goes on: for files, and for whoever listens.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/camera/stereo_rig.h"
#include "facet/io/trajectory_file.h"
#include "facet/mesh/map_follower.h"
#include "facet/pipeline/vio_output.h"
#include "facet/publish/channels.h"

namespace facet {

/// One message. `slot`: what it is about; a newer message of the same topic and slot takes its
/// place.
struct PublishedMessage {
  Channel channel = Channel::kState;
  std::string slot;
  Timestamp t;
  std::string json;
};

/// Takes messages, on the publisher's thread.
using MessageSink = std::function<void(const PublishedMessage&)>;

/// Makes the messages on a thread of its own, each once however many take them. Results are the
/// same with and without it.
class Publisher {
 public:
  /// `map` as in the pipeline.
  Publisher(const StereoRig& rig, const SurfaceMapOptions& map, std::vector<MessageSink> sinks);
  /// Drops what waits.
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  // ---- from one thread; they return at once.

  /// The image of a frame whose output will come.
  void AddImage(Timestamp t, const cv::Mat& left);

  /// The outputs in order. Where the thread is far behind, the oldest are left out.
  void Add(const VioOutput& output);

  /// Whether the pipeline should be asked for a scene update (VioPipeline::RequestSceneUpdate).
  bool WantsSceneUpdate(Timestamp now);

  /// Waits until everything is published, and ends. Throws what a sink threw first: since then it
  /// has got nothing, the others everything.
  void Finish();

  /// Outputs that were left out.
  std::int64_t num_dropped() const;

 private:
  struct Image {
    Timestamp t;
    cv::Mat left;
  };
  struct Item {
    VioOutput output;
    cv::Mat left;  ///< empty: not to be published
  };

  void Run();
  void Publish(const Item& item);
  void PublishPose(const VioOutput& output);
  void PublishPath(const VioOutput& output);
  void PublishScene(const VioOutput& output);
  void Send(Channel channel, std::string slot, Timestamp t, std::string json);

  const StereoRig rig_;
  std::vector<MessageSink> sinks_;  // the thread's only; without those that have thrown

  std::deque<Image> images_;    // caller's thread only
  Timestamp next_image_{};      // the same
  Timestamp last_request_{};    // the same
  bool has_requested_ = false;  // the same

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> items_;
  std::int64_t num_dropped_ = 0;
  bool is_over_ = false;

  // The thread's own from here on.
  MapFollower map_;
  std::vector<StampedPose> path_;
  std::size_t path_step_ = 1, num_poses_ = 0;
  Timestamp next_path_{};
  std::exception_ptr failure_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace facet
