// SPDX-License-Identifier: BSD-2-Clause
// The meshes of a result folder against the surfaces of a ground truth.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facet/eval/ground_truth.h"
#include "facet/eval/mesh_error.h"
#include "facet/eval/trajectory_error.h"

namespace facet {

struct MeshEvaluation {
  std::optional<MeshError> mesh;  ///< horizon: meshes/ of every 10th keyframe pooled, else mesh.ply
  std::optional<MeshError> map;   ///< map.ply
  std::vector<std::string> warnings;
};

/// `pairs` and `alignment` are those of the run's trajectory; they say where its cameras were and
/// where its world lies. Parts without a file are absent. Throws InputError for a damaged or empty
/// mesh. CHECKs that the truth has a surface.
MeshEvaluation EvaluateMeshes(const std::filesystem::path& result,
                              const GroundTruth& truth,
                              std::span<const PosePair> pairs,
                              const TrajectoryAlignment& alignment);

/// Whether the folder holds any mesh.
bool HasMesh(const std::filesystem::path& result);

}  // namespace facet
