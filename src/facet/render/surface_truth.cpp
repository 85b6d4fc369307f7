// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/surface_truth.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "facet/base/random.h"
#include "facet/render/parallel_for.h"

namespace facet {
namespace {

/// One camera at one moment; from whom points may be seen.
struct Viewpoint {
  SE3 T_CW;
  Vector3d p_WC;
  const CameraModel* camera = nullptr;
};

std::vector<Viewpoint> ListViewpoints(const StereoRig& rig,
                                      std::span<const SE3> T_WB,
                                      double interval_s) {
  constexpr double kApart_s = 0.25;  // denser ones see hardly more
  const auto step =
      static_cast<std::size_t>(std::max(1L, std::lround(kApart_s / std::max(1e-6, interval_s))));
  std::vector<Viewpoint> views;
  for (std::size_t i = 0; i < T_WB.size(); i += step) {
    for (std::size_t c = 0; c < 2; ++c) {
      const SE3 T_WC = T_WB[i] * rig.T_BC[c];
      views.push_back({T_WC.Inverse(), T_WC.p, &rig.cameras[c]});
    }
  }
  return views;
}

bool IsSeen(const Viewpoint& view, const RayScene& rays, const Vector3d& p_W, const Vector3d& n_W) {
  constexpr double kMinCosine = 0.05;  // a surface seen edge-on is not seen
  const Vector3d p_C = view.T_CW * p_W;
  if (p_C.norm() < kMinDistance_m) return false;
  const Vector3d to_view = view.p_WC - p_W;
  if (std::abs(n_W.dot(to_view)) < kMinCosine * to_view.norm()) return false;
  const auto px = view.camera->Project(p_C);
  return px && view.camera->IsInside(*px, 0) && !rays.IsBlocked(p_W, view.p_WC);
}

struct SamplePlan {
  double per_m2 = 0;
  std::vector<int> triangles;  // the triangle of each sample
};

SamplePlan PlanSamples(const SceneMesh& mesh, const TruthOptions& options, Rng& rng) {
  double area = 0;
  for (const ScenePart& part : mesh.parts)
    area += part.area_m2;
  SamplePlan plan;
  plan.per_m2 = std::min(options.points_per_m2, options.max_points / std::max(1e-9, area));
  double due = rng.Uniform();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    due += plan.per_m2 * mesh.TriangleArea(t);
    for (; due >= 1; due -= 1)
      plan.triangles.push_back(static_cast<int>(t));
  }
  return plan;
}

/// How long each part was in view: a coarse grid of rays in each left image.
void CountTime(const SceneMesh& mesh,
               const RayScene& rays,
               const StereoRig& rig,
               std::span<const SE3> T_WB,
               double interval_s,
               int num_threads,
               std::vector<PartSeen>& parts) {
  constexpr int kStepPx = 16;
  constexpr double kMinShare = 1e-3;
  const CameraModel& camera = rig.cameras[0];
  std::vector<Vector3d> rays_C;
  for (int y = kStepPx / 2; y < camera.height(); y += kStepPx) {
    for (int x = kStepPx / 2; x < camera.width(); x += kStepPx) {
      if (const auto ray = camera.Unproject(Vector2d(x, y))) rays_C.push_back(*ray);
    }
  }
  const double min_hits = std::max(1.0, kMinShare * static_cast<double>(rays_C.size()));
  std::vector<std::atomic<int>> frames(mesh.parts.size());
  ParallelFor(static_cast<int>(T_WB.size()), num_threads, [&](int i) {
    const SE3 T_WC = T_WB[static_cast<std::size_t>(i)] * rig.T_BC[0];
    std::vector<int> hits(mesh.parts.size(), 0);
    for (const Vector3d& ray_C : rays_C) {
      const auto hit = rays.Cast(T_WC.p, T_WC.q * ray_C);
      if (hit) ++hits[mesh.triangles[hit->triangle].part];
    }
    for (std::size_t k = 0; k < hits.size(); ++k) {
      if (hits[k] >= min_hits) ++frames[k];
    }
  });
  for (std::size_t k = 0; k < parts.size(); ++k)
    parts[k].seconds = frames[k] * interval_s;
}

}  // namespace

SurfaceTruth FindSeenSurfaces(const SceneMesh& mesh,
                              const RayScene& rays,
                              const StereoRig& rig,
                              std::span<const SE3> T_WB,
                              double interval_s,
                              const TruthOptions& options,
                              std::uint64_t seed,
                              int num_threads) {
  Rng rng(seed);
  const SamplePlan plan = PlanSamples(mesh, options, rng);
  const std::vector<Viewpoint> views = ListViewpoints(rig, T_WB, interval_s);
  const std::size_t num_samples = plan.triangles.size();
  std::vector<Vector3d> points_W(num_samples);
  std::vector<char> is_seen(num_samples, 0);
  constexpr int kBlock = 4096;
  const int num_blocks = static_cast<int>((num_samples + kBlock - 1) / kBlock);
  ParallelFor(num_blocks, num_threads, [&](int block) {
    Rng point_rng(seed + 0x51ULL + static_cast<std::uint64_t>(block));
    std::size_t last_view = 0;  // the view that saw the previous point sees the next one, too
    const std::size_t begin = static_cast<std::size_t>(block) * kBlock;
    for (std::size_t i = begin; i < std::min(num_samples, begin + kBlock); ++i) {
      const auto t = static_cast<std::size_t>(plan.triangles[i]);
      const Vector3d a = mesh.corner(t, 0).cast<double>();
      const Vector3d ab = mesh.corner(t, 1).cast<double>() - a;
      const Vector3d ac = mesh.corner(t, 2).cast<double>() - a;
      double u = point_rng.Uniform(), v = point_rng.Uniform();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      points_W[i] = a + u * ab + v * ac;
      const Vector3d n_W = ab.cross(ac).normalized();
      for (std::size_t k = 0; k < views.size() && !is_seen[i]; ++k) {
        const std::size_t view = (last_view + k) % views.size();
        if (!IsSeen(views[view], rays, points_W[i], n_W)) continue;
        is_seen[i] = 1;
        last_view = view;
      }
    }
  });
  SurfaceTruth truth;
  truth.parts.resize(mesh.parts.size());
  for (std::size_t i = 0; i < num_samples; ++i) {
    if (!is_seen[i]) continue;
    truth.points_W.push_back(points_W[i]);
    truth.parts[mesh.triangles[static_cast<std::size_t>(plan.triangles[i])].part].area_m2 +=
        1 / plan.per_m2;
  }
  CountTime(mesh, rays, rig, T_WB, interval_s, num_threads, truth.parts);
  return truth;
}

}  // namespace facet
