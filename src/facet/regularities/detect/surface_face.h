// SPDX-License-Identifier: BSD-2-Clause
// The faces of the mesh as the search for planes sees them.
#pragma once

#include <array>
#include <vector>

#include "facet/geometry/angles.h"
#include "facet/map/map_snapshot.h"
#include "facet/mesh/far_surfaces.h"
#include "facet/mesh/search_mesh.h"

namespace facet {

/// How flat real surfaces are up to kFarDistance_m, 1-sigma [m].
inline constexpr double kSurfaceFlatness_m = 0.005;

/// Largest angle between the normals of a face and of the plane that it lies on [rad]: faces of
/// neighbouring corners with 1 cm of error lean that much.
inline constexpr double kMaxFaceAngle = 25 * kDegree;

/// From here on, up to kFarDistance_m, a surface counts with its size. Nearer, it counts with the
/// size of what fills the same part of the view at this distance: a pallet at half a metre is as
/// good a plane as a table at two; and farther, of what does so at kFarDistance_m [m].
inline constexpr double kFullSizeDistance_m = 1.5;

/// What is left of the errors of disparities that all points of a view have in common, 1-sigma: see
/// CommonErrorOf.
inline constexpr double kCommonDisparity_px = 0.05;

/// A vertex of the mesh with what is known of its distance from the camera.
struct FacePoint {
  Vector3d p_W = Vector3d::Zero();
  Vector3d ray_W = Vector3d::UnitZ();  ///< unit, from the newest camera
  double sigma_along_m = 0;            ///< 1-sigma along the ray
  double sigma_across_m = 0;           ///< and across it
  double length_scale = 1;             ///< of its distance (far_surfaces.h)

  /// Returns the variance of the point along a unit normal [m^2].
  double VarianceAlong(const Vector3d& n_W) const {
    const double c = n_W.dot(ray_W);
    return c * c * sigma_along_m * sigma_along_m + (1 - c * c) * sigma_across_m * sigma_across_m;
  }
  double SigmaAlong(const Vector3d& n_W) const { return std::sqrt(VarianceAlong(n_W)); }

  /// How flat the surface that it lies on is, 1-sigma [m].
  double Flatness_m() const { return length_scale * kSurfaceFlatness_m; }

  /// Variance of its distance from the plane of a surface that it lies on [m^2].
  double VarianceFromSurface(const Vector3d& n_W) const {
    return VarianceAlong(n_W) + Flatness_m() * Flatness_m();
  }
};

/// Where the points are seen from, and how exactly.
struct FaceCamera {
  Vector3d p_W = Vector3d::Zero();
  double sigma_direction = 0;      ///< of a vertex's direction, 1-sigma [rad]
  double sigma_inverse_depth = 0;  ///< common to all vertices, 1-sigma [1/m]
};

FacePoint MakeFacePoint(const Vector3d& p_W, double sigma_depth_m, const FaceCamera& camera);

struct SurfaceFace {
  std::array<int, 3> corners{};  ///< into SurfaceFaces::points
  Vector3d centre_W = Vector3d::Zero();
  Vector3d n_W = Vector3d::UnitZ();  ///< unit, towards the camera that saw it
  double area_m2 = 0;                ///< 0 if a corner is not finite
  double search_area_m2 = 0;         ///< what it counts for (kFullSizeDistance_m)
  double length_scale = 1;           ///< of its centre's distance (far_surfaces.h)
  bool may_vote = false;
  bool in_view = false;  ///< seen by the newest keyframe
};

/// Indices as in the snapshot's mesh.
struct SurfaceFaces {
  std::vector<FacePoint> points;
  std::vector<SurfaceFace> faces;
  FaceCamera camera;
};

/// For each vertex its place in `map.landmarks`, -1: a support point, or forgotten.
std::vector<int> LandmarksOfVertices(const SearchMesh& mesh, const MapSnapshot& map);

/// `faces` is filled anew; it keeps its storage.
void FillSurfaceFaces(const SearchMesh& mesh, SurfaceFaces& faces);

}  // namespace facet
