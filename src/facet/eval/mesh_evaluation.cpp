// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/mesh_evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "facet/base/check.h"
#include "facet/eval/visibility.h"
#include "facet/io/calibration_file.h"
#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/io/ply_reader.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr int kKeyframesPerMesh = 10;

struct StampedFile {
  Timestamp t;
  fs::path file;
};

// meshes/<timestamp_ns>.ply in order of time.
std::vector<StampedFile> ListMeshes(const fs::path& folder) {
  std::vector<StampedFile> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto ns = ParseInteger(entry.path().stem().string());
    if (ns && entry.path().extension() == ".ply") files.push_back({{*ns}, entry.path()});
  }
  std::ranges::sort(files, {}, &StampedFile::t);
  return files;
}

// Leaves every 10th keyframe's mesh where there are more.
std::vector<StampedFile> ThinByKeyframes(std::vector<StampedFile> files,
                                         const fs::path& keyframes) {
  if (files.empty() || !fs::exists(keyframes)) return files;
  const std::vector<StampedPose> poses = ReadTrajectory(keyframes).poses;
  std::vector<StampedFile> kept;
  std::ptrdiff_t last = std::numeric_limits<std::ptrdiff_t>::min() / 2;
  for (StampedFile& file : files) {
    const auto at = std::ranges::lower_bound(poses, file.t, {}, &StampedPose::t) - poses.begin();
    if (at - last < kKeyframesPerMesh) continue;
    last = at;
    kept.push_back(std::move(file));
  }
  return kept;
}

TriangleMesh ReadMesh(const fs::path& file, const TrajectoryAlignment& alignment) {
  TriangleMesh mesh = ReadPly(file);
  for (Vector3d& p : mesh.vertices)
    p = alignment * p;
  mesh.normals.clear();
  mesh.colours.clear();
  return mesh;
}

void Append(const TriangleMesh& part, TriangleMesh& whole) {
  const int offset = static_cast<int>(whole.vertices.size());
  whole.vertices.insert(whole.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const auto& [i, j, k] : part.faces)
    whole.faces.push_back({i + offset, j + offset, k + offset});
}

void RequireArea(const TriangleMesh& mesh, const fs::path& file) {
  constexpr double kMaxArea_m2 = 1e6;  // hours of flight in large halls have less
  const double area_m2 = TotalArea(mesh);
  if (area_m2 > kMaxArea_m2) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.3g", area_m2);
    throw InputError(file.string() + ": the mesh has an area of " + text +
                     " m2; vertices must be in metres");
  }
  if (area_m2 > 0) return;
  throw InputError(file.string() + ": an empty mesh, " + std::to_string(mesh.vertices.size()) +
                   " vertices and " + std::to_string(mesh.faces.size()) +
                   " faces without area; judge the rest with --parts trajectory");
}

class MeshJudge {
 public:
  MeshJudge(const GroundTruth& truth,
            std::span<const PosePair> pairs,
            const TrajectoryAlignment& alignment)
      : surface_(truth.surface->Get()), pairs_(pairs), alignment_(alignment) {
    if (!truth.planes_file.empty()) planes_ = ReadTruePlanes(truth.planes_file);
    Look(truth.mav0);
  }

  MeshError JudgePooled(const fs::path& result, const std::vector<StampedFile>& files) const {
    MeshUnderTest test;
    test.planes_G = planes_;
    std::vector<Vector3d> eyes;
    std::vector<int> eye_of_face;
    for (const StampedFile& file : files) {
      Append(ReadMesh(file.file, alignment_), test.mesh_G);
      eyes.push_back(EyeAt(file.t));
      eye_of_face.resize(test.mesh_G.faces.size(), static_cast<int>(eyes.size()) - 1);
    }
    RequireArea(test.mesh_G, result / "meshes");
    test.range_m = [&](const Vector3d& p_G, int face) {
      return (p_G - eyes[eye_of_face[face]]).norm();
    };
    MeshError error = EvaluateMesh(test, surface_, seen_);
    error.num_files = static_cast<int>(files.size());
    return error;
  }

  MeshError JudgeFinal(const fs::path& file) const {
    MeshUnderTest test;
    test.planes_G = planes_;
    test.mesh_G = ReadMesh(file, alignment_);
    RequireArea(test.mesh_G, file);
    const Vector3d eye = EyeAt(pairs_.back().t);
    test.range_m = [&](const Vector3d& p_G, int) { return (p_G - eye).norm(); };
    return EvaluateMesh(test, surface_, seen_);
  }

  MeshError JudgeMap(const fs::path& file) const {
    MeshUnderTest test;
    test.planes_G = planes_;
    test.mesh_G = ReadMesh(file, alignment_);
    test.wants_doubled_area = true;
    RequireArea(test.mesh_G, file);
    test.range_m = [this](const Vector3d& p_G, int) {
      double squared = std::numeric_limits<double>::max();
      for (const Vector3d& eye : eyes_)
        squared = std::min(squared, (p_G - eye).squaredNorm());
      return std::sqrt(squared);
    };
    return EvaluateMesh(test, surface_, seen_);
  }

  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void Look(const fs::path& mav0) {
    std::vector<SE3> poses;
    for (const PosePair& pair : pairs_)
      poses.push_back(pair.T_GB);
    try {
      const Calibration calibration = FindCalibration(mav0, {});
      T_BC_ = calibration.rig.T_BC[0];
      seen_.points = SeenPoints(surface_, calibration.rig, poses);
      VisibilityOptions near;
      near.max_distance_m = kNearRange;
      seen_.near_points = SeenPoints(surface_, calibration.rig, poses, near);
    } catch (const InputError& error) {
      warnings_.push_back(std::string(error.what()) +
                          "; without cameras nobody knows what they saw: no completeness");
    }
    constexpr double kStep = 0.2;  // [m]
    for (const SE3& T_GB : poses) {
      const Vector3d eye = T_GB * T_BC_.p;
      if (eyes_.empty() || (eye - eyes_.back()).norm() > kStep) eyes_.push_back(eye);
    }
  }

  // The left camera's place at the pose nearest in time.
  Vector3d EyeAt(Timestamp t) const {
    const auto nearest = std::ranges::min_element(
        pairs_, {}, [t](const PosePair& pair) { return std::llabs(pair.t.ns - t.ns); });
    return nearest->T_GB * T_BC_.p;
  }

  const TruthSurface& surface_;
  std::span<const PosePair> pairs_;
  TrajectoryAlignment alignment_;
  std::vector<TruePlane> planes_;
  SE3 T_BC_;  // left camera
  std::vector<Vector3d> eyes_;
  SeenTruth seen_;
  std::vector<std::string> warnings_;
};

}  // namespace

bool HasMesh(const std::filesystem::path& result) {
  return fs::is_directory(result) &&
         (fs::exists(result / "mesh.ply") || fs::exists(result / "map.ply") ||
          !ListMeshes(result / "meshes").empty());
}

MeshEvaluation EvaluateMeshes(const std::filesystem::path& result,
                              const GroundTruth& truth,
                              std::span<const PosePair> pairs,
                              const TrajectoryAlignment& alignment) {
  FACET_CHECK(truth.surface != nullptr) << "no true surface";
  const MeshJudge judge(truth, pairs, alignment);
  MeshEvaluation evaluation;
  const auto pooled = ThinByKeyframes(ListMeshes(result / "meshes"), result / "keyframes.tum");
  if (!pooled.empty()) {
    evaluation.mesh = judge.JudgePooled(result, pooled);
  } else if (fs::exists(result / "mesh.ply")) {
    evaluation.mesh = judge.JudgeFinal(result / "mesh.ply");
  }
  if (fs::exists(result / "map.ply")) evaluation.map = judge.JudgeMap(result / "map.ply");
  evaluation.warnings = judge.warnings();
  if (evaluation.mesh && evaluation.mesh->icp.is_suspicious) {
    evaluation.warnings.push_back(result.string() +
                                  ": ICP moved the mesh by more than 0.3 m or 5 deg; the figures "
                                  "after ICP may belong to another place");
  }
  return evaluation;
}

}  // namespace facet
