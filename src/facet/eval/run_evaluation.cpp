// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/run_evaluation.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>

#include <nlohmann/json.hpp>

#include "facet/eval/evaluation_json.h"
#include "facet/eval/mesh_evaluation.h"
#include "facet/eval/quaternion_order.h"
#include "facet/eval/time_alignment.h"
#include "facet/io/calibration_file.h"
#include "facet/io/errors.h"
#include "facet/io/json_file.h"
#include "facet/io/text_file.h"

namespace facet {

namespace {

namespace fs = std::filesystem;

// A pose belongs to a frame when their stamps differ by less than this.
constexpr Duration kSameFrame{1'000'000};

// Stereo frames of the run as `facet run` counted them; empty without a readable summary.
std::optional<int> FramesOfSummary(const fs::path& file) {
  const nlohmann::ordered_json summary = ReadJsonFile(file);
  if (!summary.is_object() || !summary.contains("frames")) return std::nullopt;
  const auto& frames = summary["frames"];
  if (!frames.is_number_integer() || frames.get<int>() <= 0) return std::nullopt;
  return frames.get<int>();
}

// Whether `facet run` was lost in between and went on.
bool IsInSegments(const fs::path& result) {
  const nlohmann::ordered_json summary = ReadJsonFile(result / "summary.json");
  return summary.is_object() && summary.contains("segments") && summary["segments"].size() > 1;
}

std::size_t CountFramesWithPose(std::span<const Timestamp> frames,
                                std::span<const StampedPose> poses) {
  return static_cast<std::size_t>(std::ranges::count_if(frames, [&](Timestamp t) {
    const auto pose = std::ranges::lower_bound(poses, t - kSameFrame, {}, &StampedPose::t);
    return pose != poses.end() && pose->t <= t + kSameFrame;
  }));
}

std::optional<double> Coverage(const fs::path& result,
                               std::span<const StampedPose> poses,
                               const GroundTruth& truth) {
  if (const auto frames = FramesOfSummary(result / "summary.json")) {
    return static_cast<double>(poses.size()) / *frames;
  }
  if (truth.frames.empty()) return std::nullopt;
  return static_cast<double>(CountFramesWithPose(truth.frames, poses)) /
         static_cast<double>(truth.frames.size());
}

fs::path TrajectoryFile(const fs::path& result) {
  if (!fs::exists(result)) throw InputError(result.string() + ": there is no such file or folder");
  if (!fs::is_directory(result)) return result;
  fs::path file = result / "trajectory.tum";
  if (!fs::exists(file)) {
    throw InputError(file.string() + ": there is no such file; is '" + result.string() +
                     "' a result folder of 'facet run'?");
  }
  return file;
}

// A run that ended early may have too few keyframes; the rest of the evaluation stands without
// them.
void EvaluateKeyframes(const fs::path& result,
                       const GroundTruth& truth,
                       const EvaluationOptions& options,
                       RunEvaluation& evaluation) {
  const fs::path file = result / "keyframes.tum";
  if (!fs::is_directory(result) || !fs::exists(file)) return;
  try {
    const std::vector<StampedPose> keyframes =
        ShiftInTime(ReadTrajectory(file).poses, evaluation.time_offset.value_or(Duration{}));
    const std::string problem = WhatIsWrong(keyframes, truth.poses);
    if (!problem.empty()) throw InputError(file.string() + ": " + problem);
    evaluation.keyframes = EvaluateTrajectory(keyframes, truth.poses, options.trajectory);
  } catch (const InputError& error) {
    evaluation.warnings.push_back(std::string(error.what()) + "; keyframes are not judged");
  }
}

// Each segment of a run that was lost in between is aligned for itself: across a break only the
// stated uncertainty counts.
void EvaluateSegments(const std::vector<EstimatedState>& states,
                      const GroundTruth& truth,
                      const EvaluationOptions& options,
                      RunEvaluation& evaluation) {
  std::map<int, std::vector<StampedPose>> poses_of;
  for (const EstimatedState& s : states)
    poses_of[s.segment].push_back({s.state.t, s.state.T_WB});
  if (poses_of.size() < 2) return;
  for (const auto& [segment, poses] : poses_of) {
    const std::string problem = WhatIsWrong(poses, truth.poses);
    if (problem.empty()) {
      evaluation.segments.push_back(
          {segment, EvaluateTrajectory(poses, truth.poses, options.trajectory)});
    } else {
      evaluation.warnings.push_back("segment " + std::to_string(segment) + ": " + problem +
                                    "; it is not judged");
    }
  }
}

void CheckQuaternions(const fs::path& truth, RunEvaluation& evaluation) {
  const auto swapped = FindSwappedQuaternions(evaluation.pairs);
  if (!swapped) return;
  char degrees[120];
  std::snprintf(degrees,
                sizeof(degrees),
                "%.0f deg in the median, but by %.1f deg",
                swapped->as_read_deg,
                swapped->reordered_deg);
  evaluation.warnings.push_back(
      evaluation.result.string() + ": the orientations are off by " + degrees +
      " with the quaternion's columns in another order: here or in " + truth.string() +
      " they are not as expected (TUM: qx qy qz qw, EuRoC csv: qw,qx,qy,qz); only what is said of "
      "positions holds");
}

void RequirePart(bool is_wanted, bool is_there, const fs::path& where, const std::string& what) {
  if (is_wanted && !is_there)
    throw InputError(where.string() + ": there is no " + what + ", which was to be judged");
}

void RequireParts(const fs::path& result,
                  const GroundTruth& truth,
                  const EvaluationOptions& options) {
  RequirePart(options.judge_mesh,
              truth.surface != nullptr,
              truth.path,
              "true surface (truth/mesh.ply or mav0/pointcloud0/data.ply)");
  RequirePart(options.judge_mesh,
              fs::is_directory(result) && HasMesh(result),
              result,
              "mesh (mesh.ply, map.ply or meshes/)");
  RequirePart(options.judge_planes,
              !truth.planes_file.empty(),
              truth.path,
              "list of true planes (truth/planes.csv)");
  RequirePart(
      options.judge_planes, fs::exists(result / "planes.csv"), result, "planes.csv with planes");
  RequirePart(options.judge_consistency,
              !truth.states.empty(),
              truth.path,
              "truth with velocities and biases");
  RequirePart(options.judge_consistency,
              fs::exists(result / "states.csv"),
              result,
              "states.csv with uncertainties");
}

// Planes, mesh and consistency: each where the result and the truth have it.
void EvaluateParts(const fs::path& result,
                   const GroundTruth& truth,
                   const EvaluationOptions& options,
                   RunEvaluation& evaluation) {
  if (!fs::is_directory(result)) return;
  if (options.judge_mesh && truth.surface && HasMesh(result)) {
    MeshEvaluation meshes =
        EvaluateMeshes(result, truth, evaluation.pairs, evaluation.causal.alignment);
    evaluation.mesh = std::move(meshes.mesh);
    evaluation.map = std::move(meshes.map);
    std::ranges::move(meshes.warnings, std::back_inserter(evaluation.warnings));
  }
  const fs::path planes = result / "planes.csv";
  if (options.judge_planes && !truth.planes_file.empty() && fs::exists(planes)) {
    std::vector<Vector3d> path_G;
    for (const PosePair& pair : evaluation.pairs)
      path_G.push_back(pair.T_GB.p);
    const auto evaluate = [&,
                           estimated = ReadEstimatedPlanes(planes),
                           all = ReadTruePlanes(truth.planes_file)](const auto& limits) {
      return EvaluatePlanes(estimated, all, evaluation.causal.alignment, limits, path_G);
    };
    evaluation.planes = evaluate(PlaneErrorOptions());
    evaluation.close_planes = evaluate(kClosePlanes);
    evaluation.close_planes_by_distance = evaluate(kClosePlanesByDistance);
  }
}

// What a run has learnt of the calibration, where the exact one is known.
void EvaluateCalibration(const fs::path& result,
                         const GroundTruth& truth,
                         RunEvaluation& evaluation) {
  const fs::path file = result / "calibration.yaml";
  if (truth.calibration.empty() || !fs::is_directory(result) || !fs::exists(file)) return;
  const StereoRig estimate = ReadKalibrCalibration(file, {}).rig;
  const StereoRig exact = ReadEurocCalibration(truth.calibration, {}).rig;
  for (std::size_t c = 0; c < 2; ++c) {
    const CameraIntrinsics &a = estimate.cameras[c].intrinsics(),
                           &b = exact.cameras[c].intrinsics();
    if (a.distortion == b.distortion && a.width == b.width && a.height == b.height) continue;
    evaluation.warnings.push_back(file.string() + ": camera " + std::to_string(c) +
                                  " has another model of distortion or size of the image than " +
                                  truth.calibration.string() + "; the calibration is not judged");
    return;
  }
  evaluation.calibration = CompareCalibrations(estimate, exact);
}

// What states.csv says beyond the trajectory.
void EvaluateStates(const fs::path& result,
                    const GroundTruth& truth,
                    const EvaluationOptions& options,
                    RunEvaluation& evaluation) {
  const fs::path file = result / "states.csv";
  if (!fs::is_directory(result) || !fs::exists(file)) return;
  if (!options.judge_consistency && !IsInSegments(result)) return;
  std::vector<EstimatedState> states = ReadStates(file);
  for (EstimatedState& s : states)
    s.state.t = s.state.t + evaluation.time_offset.value_or(Duration{});
  EvaluateSegments(states, truth, options, evaluation);
  if (options.judge_consistency && !truth.states.empty())
    evaluation.consistency = EvaluateConsistency(states, truth.states);
}

}  // namespace

RunEvaluation EvaluateRun(const std::filesystem::path& result,
                          const GroundTruth& truth,
                          const EvaluationOptions& options) {
  Trajectory trajectory = ReadTrajectory(TrajectoryFile(result));
  RunEvaluation evaluation;
  evaluation.result = result;
  evaluation.alignment = options.trajectory.alignment;
  evaluation.warnings = trajectory.warnings;
  evaluation.coverage = Coverage(result, trajectory.poses, truth);
  if (options.align_time) {
    evaluation.time_offset =
        EstimateTimeOffset(trajectory.poses, truth.poses, options.trajectory.alignment);
    trajectory.poses = ShiftInTime(trajectory.poses, *evaluation.time_offset);
  }
  const std::string problem = WhatIsWrong(trajectory.poses, truth.poses);
  if (!problem.empty()) {
    throw InputError(result.string() + ": " + problem + " (truth: " + truth.pose_file.string() +
                     ")");
  }
  if (options.parts_must_exist) RequireParts(result, truth, options);
  evaluation.causal = EvaluateTrajectory(trajectory.poses, truth.poses, options.trajectory);
  evaluation.pairs = Associate(trajectory.poses, truth.poses).pairs;
  CheckQuaternions(truth.pose_file, evaluation);
  EvaluateKeyframes(result, truth, options, evaluation);
  EvaluateParts(result, truth, options, evaluation);
  EvaluateStates(result, truth, options, evaluation);
  if (options.judge_consistency) EvaluateCalibration(result, truth, evaluation);
  return evaluation;
}

std::filesystem::path EvaluationFile(const std::filesystem::path& result) {
  if (fs::is_directory(result)) return result / "evaluation.json";
  return result.string() + ".evaluation.json";
}

void WriteEvaluation(const RunEvaluation& evaluation) {
  ReplaceTextFile(EvaluationFile(evaluation.result), JsonText(ToJson(evaluation), 2) + '\n');
}

}  // namespace facet
