// SPDX-License-Identifier: BSD-2-Clause
// What is published of a run, under which names: for Foxglove and whatever reads its messages.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace facet {

enum class Channel : std::size_t {
  kState,
  kPose,
  kTransforms,
  kPath,
  kMesh,
  kMap,
  kPlanes,
  kImage
};

struct ChannelNames {
  std::string_view topic, schema;
};

/// In the order of Channel; the index is the number of the channel.
inline constexpr std::array<ChannelNames, 8> kChannels = {
    {{"/facet/state", "facet.State"},
     {"/facet/pose", "foxglove.PoseInFrame"},
     {"/tf", "foxglove.FrameTransform"},
     {"/facet/path", "foxglove.PosesInFrame"},
     {"/facet/mesh", "foxglove.SceneUpdate"},
     {"/facet/map", "foxglove.SceneUpdate"},
     {"/facet/planes", "foxglove.SceneUpdate"},
     {"/facet/image", "foxglove.CompressedImage"}}};

/// The JSON schema of that name, as it was published; empty for a name that is not in kChannels.
std::string_view SchemaText(std::string_view name);

}  // namespace facet
