// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

namespace facet {
namespace {

constexpr double kSpacing = 0.04;    // of the points that hide others [m]
constexpr int kCellPx = 4;           // of the depth image
constexpr double kTolerance = 0.08;  // two spacings [m]
constexpr double kNearest = 0.05;    // [m]

std::vector<SE3> ThinViews(std::span<const SE3> T_GB, const VisibilityOptions& options) {
  std::vector<SE3> views;
  for (const SE3& view : T_GB) {
    if (!views.empty() && (view.p - views.back().p).norm() < options.min_step_m &&
        view.q.angularDistance(views.back().q) < options.min_turn_rad) {
      continue;
    }
    views.push_back(view);
  }
  return views;
}

// One point per cell of a grid, so that their spacing is known.
std::vector<Vector3d> ThinCloud(const std::vector<Vector3d>& points) {
  std::unordered_map<std::int64_t, Vector3d> cells;
  const auto cell = [](double x) { return static_cast<std::int64_t>(std::floor(x / kSpacing)); };
  constexpr std::int64_t kOffset = 1 << 20, kSide = 1 << 21;
  std::vector<Vector3d> thin;
  for (const Vector3d& p : points) {
    const std::int64_t key =
        ((cell(p.x()) + kOffset) * kSide + cell(p.y()) + kOffset) * kSide + cell(p.z()) + kOffset;
    if (cells.emplace(key, p).second) thin.push_back(p);
  }
  return thin;
}

// Cosine of the largest angle from the axis of a ray inside the image, with a margin; what is
// outside need not be projected.
double LeastCosine(const CameraModel& camera) {
  constexpr double kMargin = 0.05;
  double cosine = 1;
  for (double x : {0.0, 0.5, 1.0}) {
    for (double y : {0.0, 0.5, 1.0}) {
      const auto ray = camera.Unproject({x * (camera.width() - 1), y * (camera.height() - 1)});
      if (!ray) return std::cos(camera.max_angle());
      cosine = std::min(cosine, ray->z());
    }
  }
  return cosine - kMargin;
}

// A coarse image of the distances of the nearest points.
class DepthImage {
 public:
  explicit DepthImage(const CameraModel& camera)
      : camera_(camera),
        columns_(camera.width() / kCellPx + 1),
        rows_(camera.height() / kCellPx + 1),
        depth_(static_cast<std::size_t>(columns_) * rows_, std::numeric_limits<float>::max()) {}

  void Draw(const Vector3d& p_C) {
    Matrix<2, 3> J;
    const auto px = camera_.Project(p_C, &J);
    if (!px) return;
    const double px_per_m = J.norm() / std::sqrt(2.0);
    const double radius = std::max(0.5, 0.75 * kSpacing * px_per_m / kCellPx);
    const double x = px->x() / kCellPx, y = px->y() / kCellPx;
    const auto first = [](double v) { return std::max(0, static_cast<int>(std::ceil(v))); };
    const int x1 = std::min(columns_ - 1, static_cast<int>(std::floor(x + radius)));
    const int y1 = std::min(rows_ - 1, static_cast<int>(std::floor(y + radius)));
    for (int r = first(y - radius); r <= y1; ++r) {
      for (int c = first(x - radius); c <= x1; ++c) {
        float& depth = depth_[static_cast<std::size_t>(r) * columns_ + c];
        depth = std::min(depth, static_cast<float>(p_C.norm()));
      }
    }
  }

  bool Hides(const Vector2d& px, double distance_m) const {
    const int c = static_cast<int>(std::lround(px.x() / kCellPx));
    const int r = static_cast<int>(std::lround(px.y() / kCellPx));
    const int column = std::clamp(c, 0, columns_ - 1), row = std::clamp(r, 0, rows_ - 1);
    return static_cast<double>(depth_[static_cast<std::size_t>(row) * columns_ + column]) +
               kTolerance <
           distance_m;
  }

 private:
  const CameraModel& camera_;
  int columns_, rows_;
  std::vector<float> depth_;
};

bool HiddenByTriangle(const TriangleIndex& triangles, const Vector3d& eye, const Vector3d& point) {
  const Vector3d ray = point - eye;
  bool hidden = false;
  const double end = 1 - std::min(0.5, 0.01 / ray.norm());
  triangles.VisitLine(eye, ray, 0, end, [&](int, double) {
    hidden = true;
    return false;
  });
  return hidden;
}

class Observer {
 public:
  Observer(const TruthSurface& surface, const StereoRig& rig, const VisibilityOptions& options)
      : surface_(surface), rig_(rig), options_(options), seen_(surface.points().size(), 0) {
    if (surface.triangles() == nullptr) occluders_ = ThinCloud(surface.points());
    for (int camera : {0, 1})
      least_cosine_[camera] = LeastCosine(rig.cameras[camera]);
  }

  void Look(const SE3& T_GB) {
    for (int camera : {0, 1}) {
      camera_ = camera;
      T_GC_ = T_GB * rig_.T_BC[camera];
      T_CG_ = T_GC_.Inverse();
      R_CG_ = T_CG_.R();
      if (surface_.triangles() != nullptr) {
        MarkSeen(nullptr);
        continue;
      }
      DepthImage image(rig_.cameras[camera]);
      for (const Vector3d& p_G : occluders_) {
        if (const auto p_C = InFront(p_G)) image.Draw(*p_C);
      }
      MarkSeen(&image);
    }
  }

  std::vector<char> TakeSeen() { return std::move(seen_); }

 private:
  // Returns the point in the camera's frame; nothing if it is too far away or clearly outside the
  // image.
  std::optional<Vector3d> InFront(const Vector3d& p_G) const {
    const Vector3d r = p_G - T_GC_.p;
    if (r.squaredNorm() > options_.max_distance_m * options_.max_distance_m) return std::nullopt;
    const Vector3d p_C = R_CG_ * p_G + T_CG_.p;
    const double distance_m = p_C.norm();
    if (distance_m < kNearest || p_C.z() < least_cosine_[camera_] * distance_m) return std::nullopt;
    return p_C;
  }

  void MarkSeen(const DepthImage* image) {
    const CameraModel& camera = rig_.cameras[camera_];
    const std::vector<Vector3d>& points = surface_.points();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (seen_[i]) continue;
      const auto p_C = InFront(points[i]);
      if (!p_C) continue;
      const auto px = camera.Project(*p_C);
      if (!px || !camera.IsInside(*px, 0)) continue;
      const bool hidden = image != nullptr
                              ? image->Hides(*px, p_C->norm())
                              : HiddenByTriangle(*surface_.triangles(), T_GC_.p, points[i]);
      seen_[i] = hidden ? 0 : 1;
    }
  }

  const TruthSurface& surface_;
  const StereoRig& rig_;
  VisibilityOptions options_;
  std::vector<Vector3d> occluders_;
  std::vector<char> seen_;
  std::array<double, 2> least_cosine_{};
  int camera_ = 0;  // the one that looks, and its pose
  SE3 T_GC_, T_CG_;
  Matrix3d R_CG_ = Matrix3d::Identity();
};

}  // namespace

std::vector<char> SeenPoints(const TruthSurface& surface,
                             const StereoRig& rig,
                             std::span<const SE3> T_GB,
                             const VisibilityOptions& options) {
  Observer observer(surface, rig, options);
  for (const SE3& view : ThinViews(T_GB, options))
    observer.Look(view);
  return observer.TakeSeen();
}

}  // namespace facet
