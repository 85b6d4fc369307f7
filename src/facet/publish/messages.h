// SPDX-License-Identifier: BSD-2-Clause
// Results as JSON texts that follow the schemas of kChannels. What is not finite is written as
// zero, for JSON has no word for it.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "facet/io/trajectory_file.h"
#include "facet/map/plane_record.h"
#include "facet/mesh/triangle_mesh.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

// Names of coordinate frames, those of `facet convert` and of REP 105.
inline constexpr std::string_view kWorldFrame = "odom";
inline constexpr std::string_view kBodyFrame = "imu0";
inline constexpr std::string_view kCameraFrame = "cam0";

/// facet.State of a frame, with or without a pose (then zeros, and the identity).
std::string StateMessage(const VioOutput& output);

/// foxglove.PoseInFrame, the body in the world.
std::string PoseMessage(Timestamp t, const SE3& T_WB);

/// foxglove.FrameTransform: `T` maps points from `child` to `parent`.
std::string TransformMessage(Timestamp t,
                             std::string_view parent,
                             std::string_view child,
                             const SE3& T);

/// foxglove.PosesInFrame, in the world.
std::string PathMessage(Timestamp t, std::span<const StampedPose> poses);

/// foxglove.SceneUpdate with the mesh as one entity, which replaces an earlier one of the same id;
/// an empty mesh takes it away.
std::string MeshSceneMessage(Timestamp t, std::string_view id, const TriangleMesh& mesh);

/// foxglove.SceneUpdate with an outline and a label for each plane, in place of all earlier ones.
std::string PlanesSceneMessage(Timestamp t, std::span<const PlaneRecord> planes);

/// foxglove.CompressedImage of the left camera.
std::string ImageMessage(Timestamp t, std::string_view jpeg);

}  // namespace facet
