// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/ground_truth.h"

#include <algorithm>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/io/ply_reader.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

std::vector<Timestamp> ReadFrameStamps(const fs::path& file) {
  std::vector<Timestamp> stamps;
  if (!fs::exists(file)) return stamps;
  CsvReader row(file);
  while (row.Next()) {
    if (const auto ns = ParseInteger(row.fields().front())) stamps.push_back({*ns});
  }
  std::sort(stamps.begin(), stamps.end());
  return stamps;
}

void LoadPoses(const fs::path& file, GroundTruth& truth) {
  const Trajectory trajectory = ReadTrajectory(file);
  truth.pose_file = file;
  truth.poses = trajectory.poses;
  if (trajectory.format == TrajectoryFormat::kEurocCsv) truth.states = ReadTrueStates(file);
}

fs::path FirstThatExists(const std::vector<fs::path>& candidates) {
  for (const fs::path& candidate : candidates) {
    if (fs::exists(candidate)) return candidate;
  }
  return {};
}

constexpr const char* kUsualPoseFile = "state_groundtruth_estimate0/data.csv";

fs::path Mav0Of(const fs::path& sequence) {
  const fs::path inside = sequence / "mav0";
  return fs::is_directory(inside) ? inside : sequence;
}

/// Empty where there is none.
fs::path PoseFileIn(const fs::path& mav0) {
  return FirstThatExists(
      {mav0 / kUsualPoseFile, mav0 / "mocap0" / "data.csv", mav0 / "vicon0" / "data.csv"});
}

}  // namespace

const TruthSurface& SurfaceFile::Get() {
  if (!surface_) surface_ = MakeTruthSurface(ReadPly(path_));
  return *surface_;
}

bool HasGroundTruth(const fs::path& sequence) {
  return !PoseFileIn(Mav0Of(sequence)).empty();
}

GroundTruth LoadGroundTruth(const std::filesystem::path& sequence_or_file) {
  GroundTruth truth;
  truth.path = sequence_or_file;
  if (!fs::is_directory(sequence_or_file)) {
    LoadPoses(sequence_or_file, truth);
    return truth;
  }
  truth.mav0 = Mav0Of(sequence_or_file);
  const fs::path file = PoseFileIn(truth.mav0);
  if (file.empty()) {
    throw InputError(
        (truth.mav0 / kUsualPoseFile).string() +
        ": there is no such file (and no mocap0 or vicon0); the sequence has no ground "
        "truth");
  }
  LoadPoses(file, truth);
  truth.frames = ReadFrameStamps(truth.mav0 / "cam0" / "data.csv");
  const fs::path extra = fs::absolute(truth.mav0 / ".." / "truth").lexically_normal();
  const fs::path surface =
      FirstThatExists({extra / "mesh.ply", truth.mav0 / "pointcloud0" / "data.ply"});
  if (!surface.empty()) truth.surface = std::make_shared<SurfaceFile>(surface);
  truth.planes_file = FirstThatExists({extra / "planes.csv"});
  if (fs::exists(extra / "cam0" / "sensor.yaml")) truth.calibration = extra;
  return truth;
}

}  // namespace facet
