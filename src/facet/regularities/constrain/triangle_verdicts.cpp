// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/constrain/triangle_verdicts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "facet/geometry/angles.h"
#include "facet/mesh/triangle_stars.h"
#include "facet/regularities/detect/near_points.h"
#include "facet/regularities/track/solved_plane.h"

namespace facet {

namespace {

using Triangle = std::array<int, 3>;
using Planes = std::uint64_t;  // one bit for each of the first 64; the estimator keeps 40

constexpr std::size_t kMaxPlanes = 64;
// A triangle with one or two corners on a plane is no surface when another corner is farther from
// the plane than the first, one between several planes when it passes farther than the second from
// all; both times the length scale (far_surfaces.h).
constexpr double kMinGap_m = 0.06, kMaxCut_m = 0.03;

template <class Function>
void ForEachPlane(Planes planes, const Function& function) {
  for (; planes != 0; planes &= planes - 1)
    function(std::countr_zero(planes));
}

class Judge {
 public:
  Judge(std::span<const FacePoint> points,
        std::span<const Triangle> triangles,
        std::vector<SolvedPlane> planes,
        const RegularityOptions& options)
      : points_(points), triangles_(triangles), planes_(std::move(planes)), options_(options) {
    if (planes_.size() > kMaxPlanes) planes_.erase(planes_.begin() + kMaxPlanes, planes_.end());
    FindPointsOnPlanes();
    stars_.Build(points_.size(), triangles_.size(), [this](std::size_t i) -> const Triangle& {
      return triangles_[i];
    });
  }

  TriangleVerdict Of(const Triangle& t) const {
    const Planes common = on_[t[0]] & on_[t[1]] & on_[t[2]];
    if (common != 0) return {PlaneOf(t, common), false};
    return {-1, IsBridge(t)};
  }

 private:
  double Distance(int plane, int point) const {
    return planes_[plane].plane_W().SignedDistance(points_[point].p_W);
  }

  Vector3d NormalOf(const Triangle& t) const {
    const Vector3d& a = points_[t[0]].p_W;
    return (points_[t[1]].p_W - a).cross(points_[t[2]].p_W - a).normalized();
  }

  double ScaleOf(const Triangle& t) const {
    return std::max(
        {points_[t[0]].length_scale, points_[t[1]].length_scale, points_[t[2]].length_scale});
  }

  // By the gates with which faces are assigned to planes, and near their extents.
  void FindPointsOnPlanes() {
    on_.assign(points_.size(), 0);
    const NearPoints near(points_.size(),
                          [&](std::size_t i) -> const Vector3d& { return points_[i].p_W; });
    const double max_distance_m = options_.detection.max_distance_m;
    double max_scale = 1;
    for (const FacePoint& point : points_)
      max_scale = std::max(max_scale, point.length_scale);
    for (std::size_t k = 0; k < planes_.size(); ++k) {
      const Plane& plane = planes_[k].plane_W();
      near.ForEachNear(plane, max_scale * max_distance_m, [&](std::size_t i) {
        const FacePoint& point = points_[i];
        if (plane.n.dot(point.ray_W) > 0) return;  // from behind it is another surface
        const double distance_m = plane.SignedDistance(point.p_W);
        if (std::abs(distance_m) > point.length_scale * max_distance_m) return;  // the widest gate
        const double variance =
            point.VarianceFromSurface(plane.n) + planes_[k].uncertainty.VarianceAt(point.p_W);
        if (!(distance_m * distance_m < SquaredGate(variance, max_distance_m, point.length_scale)))
          return;
        const double growth_m = point.length_scale * kPlaneGrowth_m;
        if (planes_[k].tracked->extent.IsNear(point.p_W, growth_m)) on_[i] |= Planes{1} << k;
      });
    }
  }

  // The nearest of `planes` that the triangle may belong to.
  int PlaneOf(const Triangle& t, Planes planes) const {
    const Vector3d n = NormalOf(t);
    double least_m = std::numeric_limits<double>::infinity();
    int id = -1;
    ForEachPlane(planes, [&](int k) {
      const TrackedPlane& plane = *planes_[k].tracked;
      double worst_m = 0;
      for (const int corner : t)
        worst_m = std::max(worst_m, std::abs(Distance(k, corner)));
      if (worst_m >= least_m || !(std::abs(plane.estimate.plane_W.n.dot(n)) >= min_cosine_)) return;
      least_m = worst_m;
      id = static_cast<int>(plane.id.value);
    });
    return id;
  }

  bool IsBridge(const Triangle& t) const {
    if (on_[t[0]] != 0 && on_[t[1]] != 0 && on_[t[2]] != 0) return CutsACorner(t);
    const int plane = MostShared(t);
    if (plane < 0) return false;
    double gap_m = 0;
    for (const int corner : t)
      gap_m = std::max(gap_m, std::abs(Distance(plane, corner)));
    return gap_m > ScaleOf(t) * kMinGap_m && !IsContinued(t, plane);
  }

  // The plane on which most of the corners lie, -1: none has any.
  int MostShared(const Triangle& t) const {
    int most = 0, plane = -1;
    ForEachPlane(on_[t[0]] | on_[t[1]] | on_[t[2]], [&](int k) {
      int count = 0;
      for (const int corner : t)
        count += IsOn(corner, k) ? 1 : 0;
      if (count <= most) return;
      most = count;
      plane = k;
    });
    return plane;
  }

  // All corners lie on planes, but not on the same: how far from them it passes.
  bool CutsACorner(const Triangle& t) const {
    const Vector3d &a = points_[t[0]].p_W, &b = points_[t[1]].p_W, &c = points_[t[2]].p_W;
    const Planes planes = on_[t[0]] | on_[t[1]] | on_[t[2]];
    for (const Vector3d& p : {Vector3d((a + b + c) / 3),
                              Vector3d((a + b) / 2),
                              Vector3d((b + c) / 2),
                              Vector3d((c + a) / 2)}) {
      double least_m = std::numeric_limits<double>::infinity();
      ForEachPlane(planes, [&](int k) {
        least_m = std::min(least_m, std::abs(planes_[k].plane_W().SignedDistance(p)));
      });
      if (least_m > ScaleOf(t) * kMaxCut_m) return true;
    }
    return false;
  }

  bool IsOn(int corner, int plane) const { return (on_[corner] >> plane & 1U) != 0; }

  // Whether a triangle beside it that does not touch the plane lies in the same surface: it has the
  // two corners that are off the plane.
  bool IsContinued(const Triangle& t, int plane) const {
    const auto is_on = [&](int corner) { return IsOn(corner, plane); };
    Triangle off{};
    const auto end = std::remove_copy_if(t.begin(), t.end(), off.begin(), is_on);
    if (end - off.begin() != 2) return false;
    for (const int i : stars_.Around(off[0])) {
      const Triangle& other = triangles_[i];
      if (std::find(other.begin(), other.end(), off[1]) != other.end() &&
          std::none_of(other.begin(), other.end(), is_on) &&
          std::abs(NormalOf(other).dot(NormalOf(t))) > same_surface_cosine_) {
        return true;
      }
    }
    return false;
  }

  std::span<const FacePoint> points_;
  std::span<const Triangle> triangles_;
  std::vector<SolvedPlane> planes_;
  const RegularityOptions& options_;
  const double min_cosine_ = std::cos(kMaxFaceAngle);
  const double same_surface_cosine_ = std::cos(15 * kDegree);
  std::vector<Planes> on_;  // by point: planes that have it within the gate, near their extents
  TriangleStars stars_;
};

}  // namespace

std::vector<TriangleVerdict> JudgeTriangles(std::span<const FacePoint> points,
                                            std::span<const std::array<int, 3>> triangles,
                                            const std::vector<TrackedPlane>& planes,
                                            const SE3& T_WB,
                                            const RegularityOptions& options) {
  std::vector<TriangleVerdict> out(triangles.size());
  std::vector<SolvedPlane> solved = SolvedPlanes(planes, T_WB);
  if (solved.empty()) return out;
  const Judge judge(points, triangles, std::move(solved), options);
  std::transform(triangles.begin(), triangles.end(), out.begin(), [&](const Triangle& t) {
    return judge.Of(t);
  });
  return out;
}

}  // namespace facet
