// SPDX-License-Identifier: BSD-2-Clause
// A mesh over the image of a camera that looks at it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/camera/camera_model.h"
#include "facet/geometry/se3.h"
#include "facet/mesh/triangle_mesh.h"

namespace facet {

/// The faces that a camera sees from their front, and that no other face hides.
struct MeshInImage {
  std::vector<Vector2d> pixels;
  std::vector<double> depths_m;  ///< of each pixel, along the optical axis
  std::vector<std::array<int, 3>> faces;
  std::vector<int> plane_ids;  ///< one per face; -1: on no plane
};

/// `T_WC`: where the camera is in the frame of the mesh. Only corners of faces have pixels.
MeshInImage SeeMesh(const TriangleMesh& mesh, const CameraModel& camera, const SE3& T_WC);

/// A grey 8-bit image with the mesh's edges over it, coloured by plane, as one SVG element that
/// needs nothing else. Pixels of the mesh are those of the image.
std::string MeshImageSvg(const cv::Mat& grey, const MeshInImage& mesh);

}  // namespace facet
