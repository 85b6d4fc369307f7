// SPDX-License-Identifier: BSD-2-Clause
// Small scenes of flat patches for the tests of this module: noisy meshes as one keyframe shows
// them, and a stand-in for the estimator that believes what it is told.
#pragma once

#include <map>
#include <vector>

#include "facet/base/random.h"
#include "facet/map/map_snapshot.h"
#include "facet/map/plane_assignments.h"
#include "facet/mesh/search_mesh.h"
#include "facet/regularities/detect/surface_face.h"
#include "facet/regularities/track/landmark_count.h"

namespace facet::testing {

/// A rectangle: the middle and the vectors from there to the middles of two sides.
struct Patch {
  Vector3d centre_W;
  Vector3d half_a_W, half_b_W;
  double step_m = 0.25;  ///< between vertices
  int first_id = -1;     ///< of its vertices; negative: 10000 times its place in the scene

  Plane ToPlane() const {
    const Vector3d n = half_a_W.cross(half_b_W).normalized();
    return {n, n.dot(centre_W)};
  }
};

/// An upright patch. Azimuth is that of its normal [rad].
Patch MakeWall(const Vector3d& centre_W, double azimuth, double width_m, double height_m);

/// A level patch.
Patch MakeFloor(const Vector3d& centre_W, double size_x_m, double size_y_m);

/// The patch turned by an angle about an axis through its middle [rad].
Patch Turned(Patch patch, const Vector3d& axis_W, double angle);

struct TestView {
  Vector3d camera_W = Vector3d::Zero();
  double sigma_depth_m = 0.01;  ///< noise along the rays, and what the mesh says about it
  double pixel_noise = 1;       ///< noise across the rays, as a share of what is assumed
  double time_s = 0;
  std::uint64_t seed = 1;
  double baseline_m = 0.11;  ///< of the stereo pair
};

/// The patches as jittered grids of triangles that face the camera, with the same ids in every
/// view. Ids must ascend.
SearchMesh MakeMesh(const std::vector<Patch>& patches, const TestView& view);

SurfaceFaces MakeFaces(const std::vector<Patch>& patches, const TestView& view);

/// After a keyframe with as many landmarks on the plane.
LandmarkCount CountOf(int num, int first_id = 0);

/// 0, 1, ... for all faces.
std::vector<int> AllOf(const SurfaceFaces& faces);

/// Takes planes and memberships as they are handed over and never changes a value.
class BelievingEstimator {
 public:
  void Apply(const PlaneAssignments& assignments);

  /// The landmarks are the vertices of the mesh; the newest pose is its camera's.
  MapSnapshot Snapshot(const SearchMesh& mesh) const;

  /// 1-sigma of the newest position [m].
  double sigma_p_m = 0.003;
  /// Of a plane's normal [rad] and offset [m].
  double sigma_normal = 0.002, sigma_offset_m = 0.003;
  bool planes_are_settled = true;
  std::map<PlaneId, Plane> planes;
  std::map<LandmarkId, std::vector<PlaneId>> memberships;

 private:
  std::map<PlaneId, Vector3d> anchors_;
};

}  // namespace facet::testing
