// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/floor_plan.h"

#include <algorithm>
#include <numbers>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr int kAttempts = 60;
constexpr double kQuarterTurn = std::numbers::pi / 2;

Quaterniond Yaw(double angle) {
  return ExpSO3(Vector3d(0, 0, angle));
}

}  // namespace

bool IsClearOfPath(std::span<const Vector3d> path_W,
                   const SE3& T_WO,
                   const Vector3d& size,
                   double clearance_m) {
  const SE3 T_OW = T_WO.Inverse();
  const Vector3d half = 0.5 * size;
  return std::none_of(path_W.begin(), path_W.end(), [&](const Vector3d& p_W) {
    const Vector3d p = T_OW * p_W - Vector3d(0, 0, half.z());
    return (p.cwiseAbs() - half).cwiseMax(0.0).norm() < clearance_m;
  });
}

FloorPlan::FloorPlan(const SE3& T_WF,
                     const Vector2d& half_size,
                     std::span<const Vector3d> path_W,
                     double clearance_m)
    : T_WF_(T_WF),
      half_size_(half_size),
      clearance_m_(clearance_m),
      path_W_(path_W.begin(), path_W.end()) {}

// How far from the middle of the floor a thing of this size may stand, turned any way.
Vector2d FloorPlan::ReachOfMiddle(const Vector3d& size) const {
  const double radius = 0.5 * size.head<2>().norm();
  return (half_size_.array() - radius - 0.1).matrix();
}

std::optional<SE3> FloorPlan::Find(const Thing& thing, Rng& rng) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    SE3 T_FO;
    if (thing.at_wall) {
      const int wall = rng.Index(4);  // its inner normal is +y turned by `wall` quarters
      const double reach = half_size_(wall % 2) - thing.size.x() / 2 - 0.1;
      const double depth = half_size_(1 - wall % 2) - thing.gap_m - thing.size.y() / 2;
      const Quaterniond q = Yaw(kQuarterTurn * wall);
      T_FO = SE3(q, q * Vector3d(rng.Uniform(-reach, reach), -depth, 0));
    } else {
      const Vector2d reach = ReachOfMiddle(thing.size);
      const double x = rng.Uniform(-reach.x(), reach.x()), y = rng.Uniform(-reach.y(), reach.y());
      T_FO = SE3(Yaw(rng.Uniform(0, 4 * kQuarterTurn)), {x, y, 0});
    }
    if (Take(T_FO, thing.size, clearance_m_)) return T_WF_ * T_FO;
  }
  return std::nullopt;
}

std::optional<SE3> FloorPlan::FindNear(const Thing& thing,
                                       std::span<const Vector3d> points_W,
                                       Rng& rng) {
  constexpr double kReach = 0.5, kClearance = 0.33;
  const Vector2d reach = ReachOfMiddle(thing.size);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Vector3d& p_W =
        points_W[static_cast<std::size_t>(rng.Index(static_cast<int>(points_W.size())))];
    const Vector3d p_F = T_WF_.Inverse() * p_W;
    const double x = p_F.x() + rng.Uniform(-kReach, kReach);
    const double y = p_F.y() + rng.Uniform(-kReach, kReach);
    const SE3 T_FO(Yaw(rng.Uniform(0, 4 * kQuarterTurn)), {x, y, 0});
    const bool is_inside = (Vector2d(x, y).cwiseAbs() - reach).maxCoeff() < 0;
    if (is_inside && Take(T_FO, thing.size, kClearance)) return T_WF_ * T_FO;
  }
  return std::nullopt;
}

std::optional<SE3> FloorPlan::TakeBox(const SE3& T_FO, const Vector3d& size) {
  const SE3 T_WO = T_WF_ * T_FO;
  if (!IsClearOfPath(path_W_, T_WO, size, clearance_m_)) return std::nullopt;
  taken_.push_back({T_FO.p.head<2>(), 0.5 * size.head<2>().norm()});
  return T_WO;
}

// Whether the place is free; then it is no longer.
bool FloorPlan::Take(const SE3& T_FO, const Vector3d& size, double clearance_m) {
  const Vector2d center = T_FO.p.head<2>();
  const double radius = 0.5 * size.head<2>().norm();
  const bool is_taken = std::any_of(taken_.begin(), taken_.end(), [&](const Disc& disc) {
    return (disc.center - center).norm() < disc.radius + radius + 0.02;
  });
  if (is_taken || !IsClearOfPath(path_W_, T_WF_ * T_FO, size, clearance_m)) return false;
  taken_.push_back({center, radius});
  return true;
}

std::optional<SE3> FloorPlan::FindOnWall(const Vector2d& size,
                                         double min_z,
                                         double max_z,
                                         Rng& rng) {
  constexpr double kProud = 0.006;  // in front of the wall
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const int wall = rng.Index(4);
    const double reach = half_size_(wall % 2) - size.x() / 2 - 0.05;
    const Vector2d at(rng.Uniform(-reach, reach), rng.Uniform(min_z, max_z));
    const bool is_taken = std::any_of(hung_.begin(), hung_.end(), [&](const Hung& hung) {
      const Vector2d gap = (hung.center - at).cwiseAbs() - hung.half_size - 0.5 * size;
      return hung.wall == wall && gap.maxCoeff() < 0.03;
    });
    if (is_taken) continue;
    hung_.push_back({wall, at, 0.5 * size});
    const Quaterniond q = Yaw(kQuarterTurn * wall);
    const double depth = half_size_(1 - wall % 2) - kProud;
    return T_WF_ * SE3(q, q * Vector3d(at.x(), -depth, at.y()));
  }
  return std::nullopt;
}

}  // namespace facet
