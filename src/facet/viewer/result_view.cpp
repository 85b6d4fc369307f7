// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/result_view.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "facet/io/errors.h"
#include "facet/io/frame_records.h"
#include "facet/io/glb_writer.h"
#include "facet/io/json_file.h"
#include "facet/io/ply_reader.h"
#include "facet/io/vertex_sigmas.h"
#include "facet/viewer/scene_messages.h"
#include "facet/viewer/truth_path.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kMap = 0, kHorizon = 1;  // index of kMesh

/// Not a pipe, to which somebody else may never write.
bool IsFile(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error);
}

bool Exists(const fs::path& file) {
  std::error_code error;
  return fs::exists(file, error);
}

std::string ReadBytes(const fs::path& file) {
  if (Exists(file) && !IsFile(file)) throw InputError(file.string() + ": is no file");
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  if (!stream) throw InputError(file.string() + ": cannot be read");
  return bytes.str();
}

std::string NameOf(const fs::path& folder) {
  const fs::path clean = fs::absolute(folder).lexically_normal();
  return (clean.has_filename() ? clean : clean.parent_path()).filename().string();
}

std::vector<float> ErrorsOf(const TriangleMesh& mesh, GroundTruth& truth, const SE3& T_GW) {
  std::vector<float> errors_m;
  if (!truth.surface) return errors_m;
  const TruthSurface& surface = truth.surface->Get();
  for (const Vector3d& p_W : mesh.vertices)
    errors_m.push_back(static_cast<float>(surface.Closest(T_GW * p_W).distance));
  return errors_m;
}

/// A run that found nothing leaves files without a vertex, which the reader refuses, as it does
/// what is there and no file.
bool HasVertices(const fs::path& file) {
  if (!IsFile(file)) return Exists(file);
  std::ifstream stream(file);
  std::string line;
  constexpr int kHeaderLines = 20;
  for (int i = 0; i < kHeaderLines && std::getline(stream, line); ++i) {
    if (line.starts_with("element vertex")) return line != "element vertex 0";
  }
  return fs::exists(file);
}

/// Whether a trajectory has more than its header.
bool HasPose(const fs::path& file) {
  if (!IsFile(file)) return Exists(file);
  std::ifstream stream(file);
  std::string line;
  while (std::getline(stream, line)) {
    if (!line.empty() && line[0] != '#') return true;
  }
  return false;
}

}  // namespace

std::vector<ViewDownload> PlainDownloads(const fs::path& folder, int source) {
  const std::string prefix = source == 0 ? "a/" : "b/";
  std::vector<ViewDownload> downloads;
  for (const char* name : {"map.ply",
                           "mesh.ply",
                           "landmarks.ply",
                           "trajectory.tum",
                           "keyframes.tum",
                           "states.csv",
                           "planes.csv",
                           "timing.csv",
                           "summary.json",
                           "config.yaml",
                           "calibration.yaml"}) {
    const fs::path file = folder / name;
    downloads.push_back(
        {prefix + name, "application/octet-stream", [file] { return ReadBytes(file); }});
  }
  for (const std::string stem : {"map", "mesh"}) {
    const fs::path file = folder / (stem + ".ply");
    downloads.push_back({prefix + stem + ".glb", "model/gltf-binary", [file] {
                           return GlbBytes(HasVertices(file) ? ReadPly(file) : TriangleMesh());
                         }});
  }
  return downloads;
}

ResultView::ResultView(const std::vector<fs::path>& results,
                       GroundTruth* truth,
                       const std::string& camera,
                       std::shared_ptr<const CameraImages> images)
    : images_(std::move(images)) {
  messages_.push_back({"hello", ""});  // first, when what follows is known
  Json hello = {{"mode", "finished"}, {"stages", kStageNames}, {"sources", Json::array()}};
  for (std::size_t i = 0; i < results.size(); ++i) {
    const fs::path& folder = results[i];
    if (!fs::is_directory(folder))
      throw InputError(folder.string() + ": is not a result folder of 'facet run'");
    const int source = static_cast<int>(i);
    Json description = {{"name", NameOf(folder)}, {"downloads", Json::array()}};
    if (!camera.empty()) description["camera"] = ParseJson(camera);
    if (images_) description["camera"] = ParseJson(DescribeCamera(images_->rig));
    for (const char* name : {"summary", "evaluation"}) {
      const fs::path file = folder / (std::string(name) + ".json");
      if (fs::exists(file)) description[name] = ReadJsonObject(file);
    }
    for (ViewDownload& download : PlainDownloads(folder, source)) {
      fs::path file = folder / fs::path(download.name).filename();
      if (file.extension() == ".glb") file.replace_extension(".ply");
      if (!fs::exists(file)) continue;
      description["downloads"].push_back(download.name);
      downloads_.push_back(std::move(download));
    }
    AddResult(folder, source, truth, description);
    AddMeshes(folder, source, description);
    hello["sources"].push_back(std::move(description));
  }
  messages_.front().bytes = TextMessage({MessageType::kHello}, JsonText(hello));
}

// For each frame whose image there is a download; the page asks for those that it shows.
void ResultView::AddImages(const fs::path& folder,
                           int source,
                           std::span<const FrameRecord> frames,
                           Json& description) {
  if (!images_) return;
  const auto meshes = std::make_shared<ResultMeshes>(folder);  // server's thread only
  int num_images = 0;
  for (const FrameRecord& frame : frames) {
    if (!frame.has_pose || !images_->Has(frame.t)) continue;
    const std::string name =
        (source == 0 ? "a/image-" : "b/image-") + std::to_string(frame.t.ns) + ".facet";
    downloads_.push_back({name,
                          "application/octet-stream",
                          [images = images_, meshes, source, t = frame.t, T_WB = frame.state.T_WB] {
                            return CameraImageMessage(source, t, T_WB, *images, *meshes);
                          }});
    ++num_images;
  }
  description["images"] = num_images;
}

void ResultView::AddResult(const fs::path& folder,
                           int source,
                           GroundTruth* truth,
                           Json& description) {
  const std::string s = std::to_string(source) + "/";
  const std::vector<FrameRecord> frames = ReadFrameRecords(folder);
  AddImages(folder, source, frames, description);
  for (std::size_t begin = 0; begin < frames.size(); begin += kFramesPerGroup) {
    const auto group =
        std::span(frames).subspan(begin).first(std::min(kFramesPerGroup, frames.size() - begin));
    const auto index = static_cast<std::uint32_t>(begin / kFramesPerGroup);
    messages_.push_back({s + "frames" + std::to_string(index),
                         FramesMessage({MessageType::kFrames, source, group[0].t, index}, group)});
  }
  if (fs::exists(folder / "planes.csv")) {
    messages_.push_back({s + "planes",
                         PlanesMessage({MessageType::kPlanes, source},
                                       ReadEstimatedPlanes(folder / "planes.csv"))});
  }
  if (HasPose(folder / "keyframes.tum")) {
    messages_.push_back({s + "keyframes",
                         PosesMessage({MessageType::kKeyframes, source},
                                      ReadTrajectory(folder / "keyframes.tum").poses)});
  }
  std::vector<StampedPose> poses;
  std::vector<Timestamp> stamps;
  for (const FrameRecord& f : frames) {
    stamps.push_back(f.t);
    if (f.has_pose) poses.push_back({f.t, f.state.T_WB});
  }
  std::optional<TruthPath> path;
  if (truth != nullptr) path = FindTruthPath(poses, stamps, truth->poses);
  if (path) {
    messages_.push_back({s + "truth", PosesMessage({MessageType::kTruth, source}, path->poses_W)});
  }
  const auto add_mesh = [&](const char* name, int index) {
    if (!HasVertices(folder / name)) return;
    TriangleMesh mesh = ReadPly(folder / name);
    ReadVertexSigmas(folder / name, mesh);
    std::vector<float> errors_m;
    if (path) errors_m = ErrorsOf(mesh, *truth, path->T_GW);
    const Timestamp t = frames.empty() ? Timestamp{} : frames.back().t;
    messages_.push_back(
        {s + name,
         MeshMessage(
             {MessageType::kMesh, source, t, static_cast<std::uint32_t>(index)}, mesh, errors_m)});
  };
  add_mesh("map.ply", kMap);
  add_mesh("mesh.ply", kHorizon);
  if (HasVertices(folder / "landmarks.ply")) {
    ViewMessage message({MessageType::kPoints, source});
    const std::vector<float> floats = FloatsOf(ReadPly(folder / "landmarks.ply").vertices);
    message.Add(BlockName::kPositions, std::span<const float>(floats), 3);
    messages_.push_back({s + "points", message.Finish()});
  }
}

void ResultView::AddMeshes(const fs::path& folder, int source, Json& description) {
  const fs::path meshes = folder / "meshes";
  description["horizon"] = Json::array();
  for (std::int64_t stamp : MeshStamps(meshes)) {
    const std::string name =
        (source == 0 ? "a/horizon-" : "b/horizon-") + std::to_string(stamp) + ".facet";
    const fs::path file = meshes / (std::to_string(stamp) + ".ply");
    downloads_.push_back(
        {name, "application/octet-stream", [file, source, stamp] {
           TriangleMesh mesh = ReadPly(file);
           ReadVertexSigmas(file, mesh);
           return MeshMessage({MessageType::kMesh, source, Timestamp{stamp}, kHorizon}, mesh);
         }});
    description["horizon"].push_back({{"stamp_ns", std::to_string(stamp)}, {"name", name}});
  }
}

void ResultView::PostTo(ViewBoard& board) const {
  board.PostFirst(messages_.front().slot, messages_.front().bytes);
  for (const Message& message : std::span(messages_).subspan(1))
    board.Post(message.slot, message.bytes);
}

}  // namespace facet
