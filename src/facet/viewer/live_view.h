// SPDX-License-Identifier: BSD-2-Clause
// A run while it goes on, for browsers. The estimator's thread leaves here what there is, which
// costs it some pointers; everything else happens on the server's thread, and only while somebody
// looks.
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/camera/stereo_rig.h"
#include "facet/geometry/delaunay.h"
#include "facet/mesh/map_follower.h"
#include "facet/pipeline/vio_output.h"
#include "facet/viewer/camera_images.h"
#include "facet/viewer/frame_history.h"
#include "facet/viewer/view_server.h"

namespace facet {

struct LiveViewOptions {
  std::string name;                ///< of the recording
  SurfaceMapOptions map;           ///< as in the pipeline
  std::filesystem::path result;    ///< where the result will be
  ViewServerOptions server;        ///< its `update` is not used
  double scene_period_s = 2;       ///< between updates of map and planes
  double truth_period_s = 2;       ///< between updates of the true trajectory
  std::vector<StampedPose> truth;  ///< for the page only; empty: not known
};

/// Results are the same with and without it.
class LiveView {
 public:
  /// Serves from now on. Throws ConfigError like ViewServer.
  LiveView(LiveViewOptions options, const StereoRig& rig);
  ~LiveView();

  // ---- called by the run, from one thread; they return at once.

  /// The image of a frame whose output will come.
  void AddImage(Timestamp t, const cv::Mat& left);

  /// The outputs in order, and what is kept of them.
  void Add(const VioOutput& output, FrameRecord record);

  /// Whether the pipeline should be asked for a scene update (VioPipeline::RequestSceneUpdate).
  bool WantsSceneUpdate();

  // ---- called after the run.

  /// From now on the result is shown as its files say. `code`, `message`: how the run ended.
  /// `images`: of the recording, for the rig of the run; may be null.
  void ShowResult(int code,
                  const std::string& message,
                  std::shared_ptr<CameraImages> images = nullptr);

  /// Waits until the clients have it, but not long for slow ones: before the program ends.
  void WaitUntilSent() { server_->WaitUntilSent(std::chrono::seconds(3)); }

  const ViewServer& server() const { return *server_; }

  /// What other sessions of the server have may be sent. From any thread.
  void Announce() { server_->Announce(); }

 private:
  struct Image {
    Timestamp t;
    cv::Mat left;
  };
  /// What the run has left since the last update; newer things replace older ones but for those
  /// that build on each other.
  struct Inbox {
    FrameHistory history;
    std::vector<StampedPose> keyframes;
    std::shared_ptr<const MapSnapshot> snapshot;
    std::shared_ptr<const MeshSnapshot> mesh;
    std::shared_ptr<const FrameObservations> observations;
    std::vector<std::shared_ptr<const SceneUpdate>> scene_updates;
    Image image;  // of the observations
    SE3 T_WB;     // at that image
  };

  void Update();
  void PostHello(int history);
  void PostFrames();
  void PostMesh(const std::shared_ptr<const MeshSnapshot>& mesh);
  void PostSnapshot(const std::shared_ptr<const MapSnapshot>& snapshot);
  void PostTruth();
  void PostKeyframes(const std::vector<StampedPose>& keyframes);
  void TakeScene(const std::vector<std::shared_ptr<const SceneUpdate>>& updates);
  void PostMapParts();
  void PostImage(const Image& image, const FrameObservations& observations, const SE3& T_WB);
  void Post(const std::string& slot, std::string message);

  const LiveViewOptions options_;
  const StereoRig rig_;

  std::mutex inbox_mutex_;
  Inbox inbox_;
  std::deque<Image> images_;    // run's thread only
  Timestamp last_request_{};    // run's thread only
  bool is_request_due_ = true;  // at once: there was none, or it did not get all; run's thread only

  // Held for a whole update; the rest belongs to whoever holds it.
  std::mutex update_mutex_;
  bool is_over_ = false;
  std::set<std::string> slots_;
  std::size_t num_frames_posted_ = 0;
  Timestamp truth_posted_{};
  int history_posted_ = -1;
  int num_updates_ = 0;
  std::shared_ptr<const MeshSnapshot> mesh_posted_;
  std::shared_ptr<const MapSnapshot> snapshot_posted_;
  Timestamp image_posted_{};
  MapFollower map_;
  std::vector<PlaneRecord> planes_;
  Delaunay delaunay_;

  std::unique_ptr<ViewServer> server_;  // last: its thread uses the others
};

}  // namespace facet
