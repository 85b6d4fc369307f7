// SPDX-License-Identifier: BSD-2-Clause
// Free places in a room: away from the path of the cameras and from what is there already.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facet/base/random.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Whether every point of the path keeps `clearance_m` from the box of this size that stands on the
/// origin of O.
bool IsClearOfPath(std::span<const Vector3d> path_W,
                   const SE3& T_WO,
                   const Vector3d& size,
                   double clearance_m);

/// The rectangle [-half_x, half_x] x [-half_y, half_y] of frame F (z up, floor at z = 0), placed in
/// the world by T_WF. Not thread-safe.
class FloorPlan {
 public:
  FloorPlan(const SE3& T_WF,
            const Vector2d& half_size,
            std::span<const Vector3d> path_W,
            double clearance_m);

  struct Thing {
    Vector3d size;         ///< width along its x, depth along its y, height
    bool at_wall = false;  ///< its back (-y) to a wall
    double gap_m = 0.02;   ///< between back and wall
  };
  /// A free place that is taken from then on: pose T_WO of the thing's foot. Empty when none was
  /// found in a number of attempts.
  std::optional<SE3> Find(const Thing& thing, Rng& rng);

  /// Takes the place at this pose for a thing of this size if it is away from the path. For groups
  /// whose things stand close to each other, placed before others.
  std::optional<SE3> TakeBox(const SE3& T_FO, const Vector3d& size);

  /// As Find, with its middle within half a metre of one of these points [W] in x and y, turned any
  /// way, and nearer to the path than other things may be.
  std::optional<SE3> FindNear(const Thing& thing, std::span<const Vector3d> points_W, Rng& rng);

  /// A place on wall 0..3, as the pose of a panel of this size (its +y into the room); nothing else
  /// hangs there.
  std::optional<SE3> FindOnWall(const Vector2d& size, double min_z, double max_z, Rng& rng);

  const SE3& T_WF() const { return T_WF_; }
  const Vector2d& half_size() const { return half_size_; }

 private:
  struct Disc {
    Vector2d center;
    double radius = 0;
  };
  struct Hung {
    int wall = 0;
    Vector2d center, half_size;
  };

  Vector2d ReachOfMiddle(const Vector3d& size) const;
  bool Take(const SE3& T_FO, const Vector3d& size, double clearance_m);

  SE3 T_WF_;
  Vector2d half_size_;
  double clearance_m_;
  std::vector<Vector3d> path_W_;
  std::vector<Disc> taken_;
  std::vector<Hung> hung_;
};

}  // namespace facet
