// SPDX-License-Identifier: BSD-2-Clause
// The left images of the recording of a result, with its meshes over them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/camera/stereo_rig.h"
#include "facet/mesh/triangle_mesh.h"
#include "facet/viewer/mesh_in_image.h"

namespace facet {

/// Where images come from.
struct CameraImages {
  StereoRig rig;
  std::vector<Timestamp> stamps;           ///< of left images, in order
  std::function<cv::Mat(Timestamp)> read;  ///< grey, 8 bits; throws InputError

  bool Has(Timestamp t) const;
};

/// JSON about the left camera: CameraShape in viewer/src/model.ts.
std::string DescribeCamera(const StereoRig& rig);

/// The stamps of the meshes that a run has written on the way (meshes/<stamp>.ply), in order.
std::vector<std::int64_t> MeshStamps(const std::filesystem::path& folder);

/// The meshes of a result, by moment. Not thread-safe.
class ResultMeshes {
 public:
  explicit ResultMeshes(std::filesystem::path result);

  /// The horizon mesh that was the newest at a moment, or where the run has not written any the
  /// map; null if there is neither. Valid until the next call. Throws InputError.
  const TriangleMesh* At(Timestamp t);

  bool is_horizon() const { return !stamps_.empty(); }  ///< otherwise the map

 private:
  std::filesystem::path result_;
  std::vector<std::int64_t> stamps_;
  std::filesystem::path file_;  // of the mesh
  std::optional<TriangleMesh> mesh_;
};

/// kImage: the image of a moment, and the mesh as a camera at that pose sees it.
std::string CameraImageMessage(
    int source, Timestamp t, const SE3& T_WB, const CameraImages& images, ResultMeshes& meshes);

}  // namespace facet
