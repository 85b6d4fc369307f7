// SPDX-License-Identifier: BSD-2-Clause
// Meshes, frames, planes and trajectories as messages of the protocol (view_message.h).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facet/io/planes_file.h"
#include "facet/io/result_writer.h"
#include "facet/io/trajectory_file.h"
#include "facet/mesh/triangle_mesh.h"
#include "facet/viewer/view_message.h"

namespace facet {

/// Frames in a message kFrames; the last group may have fewer.
inline constexpr std::size_t kFramesPerGroup = 64;

/// kMesh or kMapPart. `error_m`: of each vertex the distance to the true surface, or empty. `key`
/// only for parts.
std::string MeshMessage(const ViewMessage::Header& header,
                        const TriangleMesh& mesh,
                        std::span<const float> error_m = {},
                        const std::optional<std::array<std::int32_t, 3>>& key = {});

/// `header.index` is the number of the group.
std::string FramesMessage(const ViewMessage::Header& header, std::span<const FrameRecord> frames);

/// kKeyframes or kTruth.
std::string PosesMessage(const ViewMessage::Header& header, std::span<const StampedPose> poses);

std::string PlanesMessage(const ViewMessage::Header& header,
                          std::span<const EstimatedPlane> planes);

std::string TextMessage(const ViewMessage::Header& header, const std::string& text);

/// Rows of three floats.
std::vector<float> FloatsOf(std::span<const Vector3d> points);

}  // namespace facet
