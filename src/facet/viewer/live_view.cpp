// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/live_view.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "facet/io/json_file.h"
#include "facet/regularities/report/plane_ids.h"
#include "facet/viewer/jpeg_encoder.h"
#include "facet/viewer/result_view.h"
#include "facet/viewer/scene_messages.h"
#include "facet/viewer/truth_path.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kHorizon = 1;
// Images that wait for their outputs: the pipeline is at most two frames behind.
constexpr std::size_t kMaxImages = 4;
// Wide enough for the page; wider ones are halved until they fit.
constexpr int kMaxImageWidth = 800;
constexpr int kJpegQuality = 70;
constexpr std::size_t kMaxKeyframes = 20000;
// In one update, so that a large map takes several of them and not one long one.
constexpr int kMaxPartsPerUpdate = 16;
// Keyframes and images are sent at a lower rate than the board is updated.
constexpr int kImageEvery = 2, kKeyframesEvery = 10;

EstimatedPlane PlaneOf(const PlaneRecord& record) {
  EstimatedPlane plane;
  plane.id = record.id.value;
  plane.n_W = record.plane_W.n;
  plane.d_W = record.plane_W.d;
  plane.centre_W = record.centroid_W;
  plane.orientation = ToString(record.orientation);
  plane.label = ToString(record.label);
  plane.area_m2 = record.area_m2;
  plane.sigma_normal_rad = record.sigma_normal_rad;
  plane.sigma_d_m = record.sigma_d_m;
  plane.num_landmarks = record.num_landmarks;
  plane.outline_W = record.outline_W;
  return plane;
}

std::string SlotOf(const CubeIndex& part) {
  return "0/map" + std::to_string(part.x) + "," + std::to_string(part.y) + "," +
         std::to_string(part.z);
}

}  // namespace

LiveView::LiveView(LiveViewOptions options, const StereoRig& rig)
    : options_(std::move(options)), rig_(rig), map_(options_.map) {
  ViewServerOptions server = options_.server;
  server.update = [this] { Update(); };
  // A page that waits for the program connects before the server is in its place.
  const std::lock_guard update_lock(update_mutex_);
  // The files of the result are there when the run is over.
  server_ = std::make_unique<ViewServer>(server, std::vector<ViewDownload>{});
}

LiveView::~LiveView() = default;

void LiveView::AddImage(Timestamp t, const cv::Mat& left) {
  images_.push_back({t, left});
  if (images_.size() > kMaxImages) images_.pop_front();
}

void LiveView::Add(const VioOutput& output, FrameRecord record) {
  const auto image = std::ranges::find_if(images_, [&](const Image& i) { return i.t == output.t; });
  if (output.scene_update) is_request_due_ = output.scene_update->is_partial;
  const std::lock_guard lock(inbox_mutex_);
  inbox_.history.Add(std::move(record));
  for (const KeyframePose& keyframe : output.finished_keyframes)
    inbox_.keyframes.push_back({keyframe.t, keyframe.T_WB});
  if (inbox_.keyframes.size() > kMaxKeyframes)
    inbox_.keyframes.erase(inbox_.keyframes.begin(), inbox_.keyframes.begin() + kMaxKeyframes / 2);
  if (output.snapshot) inbox_.snapshot = output.snapshot;
  if (output.mesh) inbox_.mesh = output.mesh;
  if (output.scene_update) inbox_.scene_updates.push_back(output.scene_update);
  if (!output.observations || image == images_.end()) return;
  inbox_.observations = output.observations;
  inbox_.image = *image;
  inbox_.T_WB = output.state.T_WB;
}

bool LiveView::WantsSceneUpdate() {
  if (server_->num_clients() == 0) return false;
  const std::lock_guard lock(inbox_mutex_);
  if (!inbox_.scene_updates.empty() || inbox_.history.frames().empty()) return false;
  const Timestamp now = inbox_.history.frames().back().t;
  const double since_s = ToSeconds(now - last_request_);
  if (!is_request_due_ && since_s >= 0 && since_s < options_.scene_period_s) return false;
  is_request_due_ = false;
  last_request_ = now;
  return true;
}

void LiveView::Post(const std::string& slot, std::string message) {
  slots_.insert(slot);
  server_->board().Post(slot, std::move(message));
}

void LiveView::Update() {
  const std::lock_guard update_lock(update_mutex_);
  if (is_over_) return;
  std::vector<std::shared_ptr<const SceneUpdate>> scene_updates;
  std::vector<StampedPose> keyframes;
  std::shared_ptr<const MapSnapshot> snapshot;
  std::shared_ptr<const MeshSnapshot> mesh;
  std::shared_ptr<const FrameObservations> observations;
  Image image;
  SE3 T_WB;
  {
    const std::lock_guard lock(inbox_mutex_);
    scene_updates = std::exchange(inbox_.scene_updates, {});
    if (num_updates_ % kKeyframesEvery == 0) keyframes = inbox_.keyframes;
    snapshot = inbox_.snapshot;
    mesh = inbox_.mesh;
    observations = inbox_.observations;
    image = inbox_.image;
    T_WB = inbox_.T_WB;
  }
  PostFrames();
  PostTruth();
  PostSnapshot(snapshot);
  PostMesh(mesh);
  if (!keyframes.empty()) PostKeyframes(keyframes);
  TakeScene(scene_updates);
  PostMapParts();
  if (observations && num_updates_ % kImageEvery == 0) PostImage(image, *observations, T_WB);
  ++num_updates_;
}

void LiveView::PostHello(int history) {
  if (history == history_posted_) return;
  history_posted_ = history;
  num_frames_posted_ = 0;
  const Json source = {{"name", options_.name},
                       {"downloads", Json::array()},
                       {"camera", ParseJson(DescribeCamera(rig_))}};
  const Json hello = {{"mode", "live"},
                      {"stages", kStageNames},
                      {"history", history},
                      {"sources", Json::array({source})}};
  slots_.insert("hello");
  server_->board().PostFirst("hello", TextMessage({MessageType::kHello}, JsonText(hello)));
}

void LiveView::PostFrames() {
  std::vector<FrameRecord> fresh;  // from the beginning of a group on
  std::size_t begin = 0;
  int history = 0;
  {
    const std::lock_guard lock(inbox_mutex_);
    const std::vector<FrameRecord>& frames = inbox_.history.frames();
    history = inbox_.history.num_thinned();
    const std::size_t num_posted = history == history_posted_ ? num_frames_posted_ : 0;
    begin = num_posted / kFramesPerGroup * kFramesPerGroup;
    if (num_posted < frames.size())
      fresh.assign(frames.begin() + static_cast<std::ptrdiff_t>(begin), frames.end());
  }
  PostHello(history);
  // A history that was thinned has fewer groups than before.
  for (std::size_t k = (begin + fresh.size() + kFramesPerGroup - 1) / kFramesPerGroup;
       !fresh.empty() && slots_.erase("0/frames" + std::to_string(k)) > 0;
       ++k) {
    server_->board().Remove("0/frames" + std::to_string(k));
  }
  for (std::size_t at = 0; at < fresh.size(); at += kFramesPerGroup) {
    const auto group =
        std::span(fresh).subspan(at).first(std::min(kFramesPerGroup, fresh.size() - at));
    const auto index = static_cast<std::uint32_t>((begin + at) / kFramesPerGroup);
    Post("0/frames" + std::to_string(index),
         FramesMessage({MessageType::kFrames, 0, group[0].t, index}, group));
    num_frames_posted_ = begin + at + group.size();
  }
}

void LiveView::PostMesh(const std::shared_ptr<const MeshSnapshot>& mesh) {
  if (!mesh || mesh == mesh_posted_) return;
  mesh_posted_ = mesh;
  Post("0/horizon", MeshMessage({MessageType::kMesh, 0, mesh->t, kHorizon}, MeshWithSigmas(*mesh)));
}

void LiveView::PostSnapshot(const std::shared_ptr<const MapSnapshot>& snapshot) {
  if (!snapshot || snapshot == snapshot_posted_) return;
  snapshot_posted_ = snapshot;
  std::vector<Vector3d> points;
  std::vector<float> sigmas;
  for (const LandmarkEstimate& landmark : snapshot->landmarks) {
    points.push_back(landmark.p_W);
    sigmas.push_back(static_cast<float>(landmark.sigma_depth_m));
  }
  const std::vector<float> floats = FloatsOf(points);
  ViewMessage message({MessageType::kPoints, 0, snapshot->latest.t});
  message.Add(BlockName::kPositions, std::span<const float>(floats), 3);
  message.Add(BlockName::kSigma, std::span<const float>(sigmas), 1);
  Post("0/points", message.Finish());
}

// The alignment changes with every pose; the whole path goes with it.
void LiveView::PostTruth() {
  if (options_.truth.empty()) return;
  std::vector<StampedPose> poses;
  std::vector<Timestamp> stamps;
  {
    const std::lock_guard lock(inbox_mutex_);
    const std::vector<FrameRecord>& frames = inbox_.history.frames();
    if (frames.empty()) return;
    if (ToSeconds(frames.back().t - truth_posted_) < options_.truth_period_s) return;
    for (const FrameRecord& frame : frames) {
      stamps.push_back(frame.t);
      if (frame.has_pose) poses.push_back({frame.t, frame.state.T_WB});
    }
  }
  truth_posted_ = stamps.back();
  const auto path = FindTruthPath(poses, stamps, options_.truth);
  if (path) Post("0/truth", PosesMessage({MessageType::kTruth}, path->poses_W));
}

void LiveView::PostKeyframes(const std::vector<StampedPose>& keyframes) {
  Post("0/keyframes", PosesMessage({MessageType::kKeyframes}, keyframes));
}

void LiveView::TakeScene(const std::vector<std::shared_ptr<const SceneUpdate>>& updates) {
  for (const auto& update : updates)
    map_.Take(update->map_blocks);
  if (updates.empty()) return;
  planes_ = updates.back()->planes;
  std::vector<EstimatedPlane> planes;
  for (const PlaneRecord& record : planes_)
    planes.push_back(PlaneOf(record));
  Post("0/planes", PlanesMessage({MessageType::kPlanes}, planes));
}

void LiveView::PostMapParts() {
  const Timestamp t = snapshot_posted_ ? snapshot_posted_->latest.t : Timestamp{};
  for (int i = 0; i < kMaxPartsPerUpdate && map_.has_changed(); ++i) {
    auto [part, mesh] = *map_.TakePart();
    const std::string slot = SlotOf(part);
    if (mesh.faces.empty() && !slots_.contains(slot)) continue;
    UseCurrentPlaneIds(planes_, mesh.plane_ids);
    Post(slot,
         MeshMessage({MessageType::kMapPart, 0, t}, mesh, {}, std::array{part.x, part.y, part.z}));
  }
}

void LiveView::PostImage(const Image& image,
                         const FrameObservations& observations,
                         const SE3& T_WB) {
  if (image.left.empty() || image.left.type() != CV_8UC1 || image.t == image_posted_) return;
  image_posted_ = image.t;
  cv::Mat small = image.left;
  double scale = 1;
  while (small.cols > kMaxImageWidth) {
    cv::Mat half;
    cv::resize(small, half, {}, 0.5, 0.5, cv::INTER_AREA);
    small = half;
    scale *= 0.5;
  }
  std::unordered_map<LandmarkId, Vector3d> landmarks;
  if (snapshot_posted_) {
    for (const LandmarkEstimate& landmark : snapshot_posted_->landmarks)
      landmarks.emplace(landmark.id, landmark.p_W);
  }
  const SE3 T_C0W = (T_WB * rig_.T_BC[0]).Inverse();
  std::vector<float> pixels, depths, ids;
  std::vector<GridPoint> grid;
  constexpr double kGridPerPixel = 1024;
  for (const FeatureObservation& feature : observations.features) {
    const Vector2d px = scale * feature.px_left;
    if (!(px.cwiseAbs().maxCoeff() < 1e4)) continue;
    pixels.insert(pixels.end(), {static_cast<float>(px.x()), static_cast<float>(px.y())});
    const auto known = landmarks.find(feature.landmark);
    const double depth = known == landmarks.end() ? 0 : (T_C0W * known->second).z();
    depths.push_back(static_cast<float>(std::max(depth, 0.0)));
    ids.push_back(static_cast<float>(feature.landmark.value & 0xffffff));
    grid.push_back({static_cast<std::int32_t>(std::lround(kGridPerPixel * px.x())),
                    static_cast<std::int32_t>(std::lround(kGridPerPixel * px.y()))});
  }
  std::vector<std::uint32_t> triangles;
  for (const auto& triangle : delaunay_.Triangulate(grid)) {
    for (int corner : triangle)
      triangles.push_back(static_cast<std::uint32_t>(corner));
  }
  const std::string jpeg = EncodeJpeg(small, kJpegQuality);
  ViewMessage message({MessageType::kImage, 0, image.t});
  message.Add(BlockName::kImage, std::span<const char>(jpeg), 1);
  message.Add(BlockName::kPixels, std::span<const float>(pixels), 2);
  message.Add(BlockName::kDepths, std::span<const float>(depths), 1);
  message.Add(BlockName::kIds, std::span<const float>(ids), 1);
  message.Add(BlockName::kTriangles, std::span<const std::uint32_t>(triangles), 3);
  Post("0/image", message.Finish());
}

void LiveView::ShowResult(int code,
                          const std::string& message,
                          std::shared_ptr<CameraImages> images) {
  if (images) images->rig = rig_;
  const std::lock_guard update_lock(update_mutex_);
  is_over_ = true;
  for (const std::string& slot : slots_) {
    if (slot != "0/image") server_->board().Remove(slot);
  }
  GroundTruth truth;  // poses only: distances of a whole map to a laser scan would take a while
  truth.poses = options_.truth;
  const ResultView result({options_.result},
                          truth.poses.empty() ? nullptr : &truth,
                          DescribeCamera(rig_),
                          std::move(images));
  server_->SetDownloads(result.Downloads());
  result.PostTo(server_->board());
  const Json ended = {{"code", code}, {"message", message}};
  server_->board().Post("ended", TextMessage({MessageType::kEnded}, JsonText(ended)));
  server_->Announce();
}

}  // namespace facet
