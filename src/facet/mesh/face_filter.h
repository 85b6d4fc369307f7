// SPDX-License-Identifier: BSD-2-Clause
// Which triangles of the image are surfaces (paper II-A.1; docs/mesh.md shows what each test
// removes). A triangle in the image is one in space whether there is a surface or not.
#pragma once

#include <array>

#include "facet/base/types.h"
#include "facet/mesh/mesh_options.h"

namespace facet {

/// Why a face is not part of the mesh: the first test that it fails, in their order.
enum class FaceDefect {
  kNone,       ///< it is part of the mesh
  kNotFinite,  ///< a NaN, or a vertex that is on the camera
  kUncertain,  ///< a vertex's depth is not known well enough
  kTooLarge,   ///< longest side, absolute or relative to the depth
  kNarrow,     ///< side ratio or smallest angle
  kElongated,  ///< extends further in depth than across
  kGrazing,    ///< seen at too flat an angle
};

/// A face in the frame of the camera that looks at it.
struct CameraFace {
  std::array<Vector3d, 3> p_C;
  std::array<double, 3> sigma_depth_m{};
};

/// Judges faces by one set of limits.
class FaceFilter {
 public:
  explicit FaceFilter(const FaceLimits& limits);

  /// Every test; sees the face as the camera does.
  FaceDefect Judge(const CameraFace& face) const;

  /// The tests that do not depend on the view (size and shape), for faces of older views whose
  /// vertices moved. Points in any frame.
  FaceDefect JudgeShape(const std::array<Vector3d, 3>& p) const;

 private:
  /// The squared sides of a triangle.
  struct Sides {
    double shortest2 = 0, middle2 = 0, longest2 = 0;
  };
  static Sides SidesOf(const std::array<Vector3d, 3>& p);
  FaceDefect JudgeSides(const Sides& sides, double max_side_m) const;
  /// LengthScale where limits grow with the distance, otherwise 1.
  double ScaleAt(double distance_m) const;
  bool IsNarrow(const Sides& sides) const;
  /// `distance`: of each vertex from the camera.
  bool IsElongated(const CameraFace& face, const std::array<double, 3>& distance) const;
  bool IsGrazing(const CameraFace& face) const;

  FaceLimits limits_;
  double cos2_min_angle_;
  double cos2_max_grazing_;
};

}  // namespace facet
