// SPDX-License-Identifier: BSD-2-Clause
#include "facet/publish/publisher.h"

#include <algorithm>
#include <utility>

#include "facet/publish/messages.h"
#include "facet/viewer/jpeg_encoder.h"

namespace facet {

namespace {

// Images that wait for their outputs: the pipeline is at most two frames behind.
constexpr std::size_t kMaxImages = 4;
constexpr std::size_t kMaxItems = 200;  // ten seconds
constexpr Duration kImagePeriod{100'000'000};
constexpr Duration kPathPeriod{1'000'000'000};
constexpr Duration kScenePeriod{1'000'000'000};
constexpr int kJpegQuality = 70;
// A longer path has fewer poses of a second.
constexpr std::size_t kMaxPath = 2000;

bool IsDue(Timestamp t, Timestamp& next, Duration period) {
  if (t < next) return false;
  next = t + period;
  return true;
}

}  // namespace

Publisher::Publisher(const StereoRig& rig,
                     const SurfaceMapOptions& map,
                     std::vector<MessageSink> sinks)
    : rig_(rig), sinks_(std::move(sinks)), map_(map), thread_([this] { Run(); }) {}

Publisher::~Publisher() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    items_.clear();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Publisher::AddImage(Timestamp t, const cv::Mat& left) {
  images_.push_back({t, left});
  if (images_.size() > kMaxImages) images_.pop_front();
}

// The next image is decoded into the memory of one of those before, so what waits is a copy.
void Publisher::Add(const VioOutput& output) {
  Item item{output, {}};
  const auto image = std::ranges::find_if(images_, [&](const Image& i) { return i.t == output.t; });
  if (image != images_.end() && IsDue(output.t, next_image_, kImagePeriod))
    item.left = image->left.clone();
  {
    const std::lock_guard lock(mutex_);
    if (is_over_) return;
    items_.push_back(std::move(item));
    if (items_.size() > kMaxItems) {
      items_.pop_front();
      ++num_dropped_;
    }
  }
  changed_.notify_all();
}

bool Publisher::WantsSceneUpdate(Timestamp now) {
  if (has_requested_ && now - last_request_ < kScenePeriod && last_request_ <= now) return false;
  has_requested_ = true;
  last_request_ = now;
  return true;
}

void Publisher::Finish() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

std::int64_t Publisher::num_dropped() const {
  const std::lock_guard lock(mutex_);
  return num_dropped_;
}

void Publisher::Run() {
  try {
    while (true) {
      Item item;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return is_over_ || !items_.empty(); });
        if (items_.empty()) return;
        item = std::move(items_.front());
        items_.pop_front();
      }
      Publish(item);
    }
  } catch (...) {
    if (!failure_) failure_ = std::current_exception();
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    items_.clear();
  }
}

void Publisher::Publish(const Item& item) {
  const VioOutput& output = item.output;
  if (output.has_pose) PublishPose(output);
  Send(Channel::kState, "", output.t, StateMessage(output));
  if (output.has_pose) PublishPath(output);
  PublishScene(output);
  if (item.left.empty()) return;
  Send(Channel::kImage, "", output.t, ImageMessage(output.t, EncodeJpeg(item.left, kJpegQuality)));
}

// Transforms come first: whoever draws needs them.
void Publisher::PublishPose(const VioOutput& output) {
  const SE3& T_WB = output.state.T_WB;
  if (output.is_keyframe || path_.empty()) {
    Send(Channel::kTransforms,
         "camera",
         output.t,
         TransformMessage(output.t, kBodyFrame, kCameraFrame, rig_.T_BC[0]));
  }
  Send(Channel::kTransforms,
       "body",
       output.t,
       TransformMessage(output.t, kWorldFrame, kBodyFrame, T_WB));
  Send(Channel::kPose, "", output.t, PoseMessage(output.t, T_WB));
}

void Publisher::PublishPath(const VioOutput& output) {
  if (num_poses_++ % path_step_ == 0) path_.push_back({output.t, output.state.T_WB});
  if (path_.size() > kMaxPath) {
    for (std::size_t i = 0; 2 * i < path_.size(); ++i)
      path_[i] = path_[2 * i];
    path_.resize((path_.size() + 1) / 2);
    path_step_ *= 2;
  }
  if (IsDue(output.t, next_path_, kPathPeriod))
    Send(Channel::kPath, "", output.t, PathMessage(output.t, path_));
}

void Publisher::PublishScene(const VioOutput& output) {
  const Timestamp t = output.t;
  if (output.mesh) Send(Channel::kMesh, "", t, MeshSceneMessage(t, "horizon", output.mesh->mesh));
  if (!output.scene_update) return;
  Send(Channel::kPlanes, "", t, PlanesSceneMessage(t, output.scene_update->planes));
  map_.Take(output.scene_update->map_blocks);
  while (const auto part = map_.TakePart()) {
    const std::string id = "map " + std::to_string(part->index.x) + " " +
                           std::to_string(part->index.y) + " " + std::to_string(part->index.z);
    Send(Channel::kMap, id, t, MeshSceneMessage(t, id, part->mesh));
  }
}

void Publisher::Send(Channel channel, std::string slot, Timestamp t, std::string json) {
  const PublishedMessage message{channel, std::move(slot), t, std::move(json)};
  std::erase_if(sinks_, [&](const MessageSink& sink) {
    try {
      sink(message);
      return false;
    } catch (...) {
      if (!failure_) failure_ = std::current_exception();  // Finish throws it
      return true;
    }
  });
}

}  // namespace facet
