// SPDX-License-Identifier: BSD-2-Clause
// The true surfaces of a simulated sequence, seen along the rays of pixels.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>

#include "facet/base/types.h"
#include "facet/camera/stereo_rig.h"
#include "facet/geometry/se3.h"

namespace facet {

/// What a track's patch lies on.
enum class Ground { kFlat, kCurved, kCrease, kDepthEdge };
constexpr std::array<const char*, 4> kGroundNames = {"flat", "curved", "crease", "depth edge"};

/// A point of the true surfaces.
struct ScenePoint {
  Vector3d p_W = Vector3d::Zero();
  Vector3d n_W = Vector3d::UnitZ();  ///< unit, either side
  Ground ground = Ground::kFlat;
  int plane = -1;  ///< row of planes.csv
};

/// Thread-safe (immutable).
class TrueScene {
 public:
  /// Reads truth/mesh.ply. Throws InputError.
  explicit TrueScene(const std::filesystem::path& sequence);
  ~TrueScene();

  /// Where the ray of a left pixel meets the nearest surface.
  std::optional<ScenePoint> Find(const StereoRig& rig, const SE3& T_WB, const Vector2d& px) const;

 private:
  struct Surfaces;
  std::unique_ptr<Surfaces> surfaces_;
};

}  // namespace facet
