// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/camera_images.h"

#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "facet/io/json_file.h"
#include "facet/io/ply_reader.h"
#include "facet/viewer/jpeg_encoder.h"
#include "facet/viewer/view_message.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kJpegQuality = 75;

Json ArrayOf(const SE3& T) {
  return {T.p.x(), T.p.y(), T.p.z(), T.q.w(), T.q.x(), T.q.y(), T.q.z()};
}

}  // namespace

bool CameraImages::Has(Timestamp t) const {
  return std::ranges::binary_search(stamps, t);
}

std::string DescribeCamera(const StereoRig& rig) {
  const CameraIntrinsics& k = rig.cameras[0].intrinsics();
  return JsonText({{"T_BC0", ArrayOf(rig.T_BC[0])},
                   {"width", k.width},
                   {"height", k.height},
                   {"focal", {k.fx, k.fy}},
                   {"centre", {k.cx, k.cy}}});
}

std::vector<std::int64_t> MeshStamps(const fs::path& folder) {
  std::vector<std::int64_t> stamps;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const std::string stem = entry.path().stem().string();
    std::int64_t stamp = 0;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), stamp);
    const bool is_stamp = error == std::errc() && end == stem.data() + stem.size() && stamp >= 0;
    if (is_stamp && entry.path().extension() == ".ply") stamps.push_back(stamp);
  }
  std::ranges::sort(stamps);
  return stamps;
}

ResultMeshes::ResultMeshes(fs::path result)
    : result_(std::move(result)), stamps_(MeshStamps(result_ / "meshes")) {}

const TriangleMesh* ResultMeshes::At(Timestamp t) {
  fs::path file = result_ / "map.ply";
  if (is_horizon()) {
    const auto after = std::ranges::upper_bound(stamps_, t.ns);
    if (after == stamps_.begin()) return nullptr;
    file = result_ / "meshes" / (std::to_string(*std::prev(after)) + ".ply");
  }
  std::error_code error;
  if (!fs::exists(file, error)) return nullptr;
  if (!mesh_ || file != file_) mesh_ = ReadPly(file);
  file_ = std::move(file);
  return &*mesh_;
}

std::string CameraImageMessage(
    int source, Timestamp t, const SE3& T_WB, const CameraImages& images, ResultMeshes& meshes) {
  MeshInImage seen;
  const TriangleMesh* const mesh = meshes.At(t);
  if (mesh != nullptr) seen = SeeMesh(*mesh, images.rig.cameras[0], T_WB * images.rig.T_BC[0]);
  std::vector<float> pixels, depths;
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    for (double coordinate : seen.pixels[i])
      pixels.push_back(static_cast<float>(coordinate));
    depths.push_back(static_cast<float>(seen.depths_m[i]));
  }
  std::vector<std::uint32_t> triangles;
  for (const auto& face : seen.faces) {
    for (int corner : face)
      triangles.push_back(static_cast<std::uint32_t>(corner));
  }
  const std::string jpeg = EncodeJpeg(images.read(t), kJpegQuality);
  ViewMessage message({MessageType::kImage, source, t});
  message.Add(BlockName::kImage, std::span<const char>(jpeg), 1);
  message.Add(BlockName::kPixels, std::span<const float>(pixels), 2);
  message.Add(BlockName::kDepths, std::span<const float>(depths), 1);
  message.Add(BlockName::kTriangles, std::span<const std::uint32_t>(triangles), 3);
  message.Add(BlockName::kPlaneIds, std::span<const int>(seen.plane_ids), 1);
  message.AddText(meshes.is_horizon() ? "the horizon mesh" : "the map");
  return message.Finish();
}

}  // namespace facet
