// SPDX-License-Identifier: BSD-2-Clause
// A closed room of flat surfaces around a trajectory: six walls, boxes on the floor, upright
// boards.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "facet/base/random.h"
#include "facet/base/types.h"

namespace facet {

struct RoomOptions {
  double min_margin_m = 1.5;  ///< from the trajectory to each side wall
  double max_margin_m = 4.0;
  int num_boxes = 4;         ///< standing on the floor, turned at random
  int num_boards = 3;        ///< thin upright rectangles, turned at random
  double clearance_m = 0.6;  ///< boxes and boards keep this distance from the trajectory
};

/// A rectangle in space, seen from both sides. Its plane is n_W . p_W = d_W.
struct Surface {
  PlaneId id;
  Vector3d center_W = Vector3d::Zero();
  Vector3d n_W = Vector3d::UnitZ();  ///< unit, towards the room
  Vector3d u_W = Vector3d::UnitX();  ///< unit, along the first side
  Vector3d v_W = Vector3d::UnitY();  ///< unit, along the second side
  double half_u = 0, half_v = 0;     ///< half side lengths [m]

  double d_W() const { return n_W.dot(center_W); }
};

struct RayHit {
  double distance = 0;  ///< in lengths of the direction
  Vector3d p_W = Vector3d::Zero();
  PlaneId surface;
};

/// Thread-safe (immutable).
class RoomScene {
 public:
  /// A room around the points `path_W`, different for each state of `rng`. Boxes and boards for
  /// which no free place is found are left out.
  RoomScene(std::span<const Vector3d> path_W, const RoomOptions& options, Rng& rng);

  /// Surfaces made elsewhere; surfaces[i].id must be PlaneId{i}.
  explicit RoomScene(std::vector<Surface> surfaces) : surfaces_(std::move(surfaces)) {}

  /// surfaces()[i].id == PlaneId{i}; in a room made here the first six are floor, ceiling and
  /// walls.
  const std::vector<Surface>& surfaces() const { return surfaces_; }

  /// Nearest surface along a ray; empty only outside the room.
  std::optional<RayHit> CastRay(const Vector3d& origin_W, const Vector3d& direction_W) const;

  /// Whether nothing lies between a point of view and a point on a surface.
  bool IsVisible(const Vector3d& from_W, const Vector3d& p_W) const;

 private:
  void AddSurface(Surface surface);

  std::vector<Surface> surfaces_;
};

}  // namespace facet
