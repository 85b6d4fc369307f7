// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/rig_difference.h"

#include <array>

namespace facet {
namespace {

constexpr double kLargestLeft_px = 4, kLargestRight_px = 1;
constexpr std::array kPlaces = {0.1, 0.5, 0.9};  // shares of the image's sides
constexpr double kNearInBaselines = 10;

bool IsBeyond(double largest_px,
              const std::optional<Vector2d>& before,
              const std::optional<Vector2d>& now) {
  return before && now && !((*now - *before).norm() <= largest_px);
}

// Where the right camera sees what the left one sees there.
std::optional<Vector2d> InRight(const StereoRig& rig, const Vector3d& ray, double distance_m) {
  const SE3 T_C1C0 = rig.T_C1C0();
  const Vector3d turned = T_C1C0.q * ray;
  return rig.cameras[1].Project(distance_m > 0 ? distance_m * turned + T_C1C0.p : turned);
}

bool SeesPixelDifferently(const StereoRig& before, const StereoRig& now, const Vector2d& px) {
  const auto ray_before = before.cameras[0].Unproject(px), ray = now.cameras[0].Unproject(px);
  if (!ray_before || !ray) return false;
  if (IsBeyond(kLargestLeft_px, px, now.cameras[0].Project(*ray_before))) return true;
  const double near_m = kNearInBaselines * before.baseline_m();
  for (const double distance_m : {0.0, near_m}) {
    if (IsBeyond(kLargestRight_px,
                 InRight(before, *ray_before, distance_m),
                 InRight(now, *ray, distance_m)))
      return true;
  }
  return false;
}

}  // namespace

bool SeesDifferently(const StereoRig& before, const StereoRig& now) {
  const CameraModel& camera = before.cameras[0];
  for (const double x : kPlaces) {
    for (const double y : kPlaces) {
      if (SeesPixelDifferently(before, now, {x * camera.width(), y * camera.height()})) return true;
    }
  }
  return false;
}

}  // namespace facet
