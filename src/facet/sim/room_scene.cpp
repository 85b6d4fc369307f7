// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/room_scene.h"

#include <limits>
#include <numbers>

#include "facet/base/check.h"
#include "facet/geometry/so3.h"

namespace facet {

namespace {

/// A box whose third axis is vertical.
struct Cuboid {
  Vector3d center_W = Vector3d::Zero();
  Matrix3d R_WX = Matrix3d::Identity();  // columns: directions of the edges
  Vector3d half_size = Vector3d::Zero();

  double DistanceTo(const Vector3d& p_W) const {
    const Vector3d p = R_WX.transpose() * (p_W - center_W);
    return (p.cwiseAbs() - half_size).cwiseMax(0.0).norm();
  }

  /// Side k / 2 in the positive (k odd) or negative direction; n_W points to the outside.
  Surface Side(int k) const {
    const int axis = k / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    Surface side;
    side.n_W = R_WX.col(axis) * (k % 2 ? 1.0 : -1.0);
    side.center_W = center_W + half_size(axis) * side.n_W;
    side.u_W = R_WX.col(u);
    side.v_W = R_WX.col(v);
    side.half_u = half_size(u);
    side.half_v = half_size(v);
    return side;
  }
};

Matrix3d Yaw(double angle) {
  return ExpSO3(Vector3d(0, 0, angle)).toRotationMatrix();
}

Cuboid RoomAround(std::span<const Vector3d> path_W, const RoomOptions& options, Rng& rng) {
  Cuboid room;
  room.R_WX = Yaw(rng.Uniform(0, 2 * std::numbers::pi));
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::max());
  Vector3d high = -low;
  for (const Vector3d& p_W : path_W) {
    const Vector3d p = room.R_WX.transpose() * p_W;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const auto margin = [&] { return rng.Uniform(options.min_margin_m, options.max_margin_m); };
  low.x() -= margin();
  low.y() -= margin();
  low.z() -= rng.Uniform(0.6, 1.5);
  high.x() += margin();
  high.y() += margin();
  high.z() += rng.Uniform(1.0, 3.0);
  room.center_W = room.R_WX * (0.5 * (low + high));
  room.half_size = 0.5 * (high - low);
  return room;
}

/// A cuboid of the given size at a random place and heading on the floor, `height` above it.
std::optional<Cuboid> Place(const Cuboid& room,
                            std::span<const Vector3d> path_W,
                            const Vector3d& half_size,
                            double height,
                            double clearance_m,
                            Rng& rng) {
  constexpr int kAttempts = 100;
  const double radius = half_size.head<2>().norm();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < 2; ++k) {
      const double reach = std::max(0.0, room.half_size(k) - radius);
      p(k) = rng.Uniform(-reach, reach);
    }
    p.z() = -room.half_size.z() + height + half_size.z();
    Cuboid cuboid;
    cuboid.center_W = room.center_W + room.R_WX * p;
    cuboid.R_WX = Yaw(rng.Uniform(0, 2 * std::numbers::pi));
    cuboid.half_size = half_size;
    bool is_free = true;
    for (const Vector3d& p_W : path_W) {
      is_free = is_free && cuboid.DistanceTo(p_W) > clearance_m;
    }
    if (is_free) return cuboid;
  }
  return std::nullopt;
}

/// Ray parameter of the intersection; infinite if there is none in front.
double Intersect(const Surface& surface, const Vector3d& origin_W, const Vector3d& direction_W) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double slope = surface.n_W.dot(direction_W);
  if (std::abs(slope) < 1e-12) return kNone;
  const double t = surface.n_W.dot(surface.center_W - origin_W) / slope;
  if (!(t > 1e-9)) return kNone;
  const Vector3d p = origin_W + t * direction_W - surface.center_W;
  const bool inside = std::abs(p.dot(surface.u_W)) <= surface.half_u &&
                      std::abs(p.dot(surface.v_W)) <= surface.half_v;
  return inside ? t : kNone;
}

}  // namespace

RoomScene::RoomScene(std::span<const Vector3d> path_W, const RoomOptions& options, Rng& rng) {
  FACET_CHECK(!path_W.empty()) << "no path";
  const Cuboid room = RoomAround(path_W, options, rng);
  for (const int k : {4, 5, 0, 1, 2, 3}) {
    Surface wall = room.Side(k);
    wall.n_W = -wall.n_W;
    AddSurface(wall);
  }
  for (int i = 0; i < options.num_boxes; ++i) {
    const double x = rng.Uniform(0.2, 0.6), y = rng.Uniform(0.2, 0.6), z = rng.Uniform(0.15, 0.7);
    const auto box = Place(room, path_W, Vector3d(x, y, z), 0, options.clearance_m, rng);
    if (!box) continue;
    for (const int k : {0, 1, 2, 3, 5})
      AddSurface(box->Side(k));  // not the bottom
  }
  for (int i = 0; i < options.num_boards; ++i) {
    const double x = rng.Uniform(0.4, 1.0), z = rng.Uniform(0.3, 0.8);
    const double height = rng.Uniform(0, 0.6);
    const auto board = Place(room, path_W, Vector3d(x, 0, z), height, options.clearance_m, rng);
    if (board) AddSurface(board->Side(3));
  }
}

void RoomScene::AddSurface(Surface surface) {
  surface.id = PlaneId{static_cast<std::int64_t>(surfaces_.size())};
  surfaces_.push_back(surface);
}

std::optional<RayHit> RoomScene::CastRay(const Vector3d& origin_W,
                                         const Vector3d& direction_W) const {
  double nearest = std::numeric_limits<double>::infinity();
  RayHit hit;
  for (const Surface& surface : surfaces_) {
    const double distance = Intersect(surface, origin_W, direction_W);
    if (distance >= nearest) continue;
    nearest = distance;
    hit = {distance, origin_W + distance * direction_W, surface.id};
  }
  if (!hit.surface.IsValid()) return std::nullopt;
  return hit;
}

bool RoomScene::IsVisible(const Vector3d& from_W, const Vector3d& p_W) const {
  const std::optional<RayHit> hit = CastRay(from_W, p_W - from_W);
  return !hit || hit->distance > 1 - 1e-6;
}

}  // namespace facet
