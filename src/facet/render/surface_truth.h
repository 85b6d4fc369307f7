// SPDX-License-Identifier: BSD-2-Clause
// Which surfaces the cameras saw.
#pragma once

#include <span>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/render/image_renderer.h"
#include "facet/render/ray_scene.h"
#include "facet/render/simulator_options.h"

namespace facet {

/// What the cameras saw of one part of the scene.
struct PartSeen {
  double area_m2 = 0;
  double seconds = 0;  ///< how long at least a thousandth of the left image showed it
};

struct SurfaceTruth {
  std::vector<Vector3d> points_W;  ///< on surfaces, each seen from at least one pose
  std::vector<PartSeen> parts;     ///< by SceneMesh::parts
};

/// `T_WB`: poses of the images, `interval_s` apart. Points are spread evenly over all triangles and
/// kept if some camera sees them. The result does not depend on the number of threads.
SurfaceTruth FindSeenSurfaces(const SceneMesh& mesh,
                              const RayScene& rays,
                              const StereoRig& rig,
                              std::span<const SE3> T_WB,
                              double interval_s,
                              const TruthOptions& options,
                              std::uint64_t seed,
                              int num_threads);

}  // namespace facet
