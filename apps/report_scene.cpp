// SPDX-License-Identifier: BSD-2-Clause
#include "report_scene.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "recorded_images.h"

#include "facet/io/errors.h"
#include "facet/io/frame_records.h"
#include "facet/viewer/mesh_in_image.h"
#include "facet/viewer/result_view.h"
#include "facet/viewer/standalone_page.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

std::string Describe(const MeshInImage& seen, bool is_horizon) {
  return std::to_string(seen.faces.size()) + " faces of the " +
         (is_horizon ? "horizon mesh" : "map") + " that the camera sees, coloured by plane.";
}

/// Some moments of a run, spread over it.
void AddImages(const CameraImages& images, const ReportRun& run, ReportSection& section) {
  const fs::path folder = run.evaluation.result;
  const std::vector<FrameRecord> frames = ReadFrameRecords(folder);
  std::vector<FrameRecord> known;
  for (const FrameRecord& frame : frames) {
    if (frame.has_pose && images.Has(frame.t)) known.push_back(frame);
  }
  ResultMeshes meshes(folder);
  constexpr std::size_t kNumImages = 4;
  for (std::size_t i = 1; i <= kNumImages && known.size() > kNumImages; ++i) {
    const FrameRecord& frame = known[i * (known.size() - 1) / kNumImages];
    const TriangleMesh* const mesh = meshes.At(frame.t);
    if (mesh == nullptr) continue;
    const SE3 T_WC = frame.state.T_WB * images.rig.T_BC[0];
    const MeshInImage seen = SeeMesh(*mesh, images.rig.cameras[0], T_WC);
    char title[100];
    std::snprintf(
        title, sizeof(title), "%.1f s after the first image", ToSeconds(frame.t - frames[0].t));
    section.images.push_back({"camera_" + std::to_string(i),
                              run.name + ", " + title,
                              Describe(seen, meshes.is_horizon()),
                              MeshImageSvg(images.read(frame.t), seen)});
  }
}

}  // namespace

void AddScene(GroundTruth truth, ReportSection& section) {
  std::vector<std::filesystem::path> results;
  for (const ReportRun& run : section.runs) {
    const std::filesystem::path folder = run.evaluation.result;
    if (std::filesystem::exists(folder / "map.ply")) results.push_back(folder);
  }
  if (results.empty()) return;
  if (results.size() > 2) results = {results.front(), results.back()};
  try {
    std::string page = StandalonePage(ResultView(results, &truth));
    constexpr std::size_t kLargest = 64 << 20;
    if (page.size() <= kLargest) section.scene_page = std::move(page);
  } catch (const InputError& error) {
    // The figures are still worth a report.
    std::fprintf(stderr, "facet: warning: the report has no 3D view: %s\n", error.what());
  }
}

void AddCameraImages(const GroundTruth& truth, ReportSection& section) {
  const auto run =
      std::ranges::find_if(section.runs.rbegin(), section.runs.rend(), [](const ReportRun& r) {
        return fs::is_directory(r.evaluation.result);
      });
  if (run == section.runs.rend() || truth.mav0.empty()) return;
  try {
    AddImages(*OpenRecordedImages(truth.path), *run, section);
  } catch (const InputError&) {
    section.images.clear();  // a truth that has no images, or no longer
  }
}

}  // namespace facet
