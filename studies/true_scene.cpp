// SPDX-License-Identifier: BSD-2-Clause
#include "true_scene.h"

#include <cmath>
#include <numbers>

#include "facet/io/ply_reader.h"
#include "facet/mesh/triangle_index.h"

namespace facet {
namespace {

struct Hit {
  Vector3d p_W, n_W;
  int face;
};

}  // namespace

struct TrueScene::Surfaces {
  explicit Surfaces(TriangleMesh read) : mesh(std::move(read)), index(mesh) {}

  std::optional<Hit> Cast(const StereoRig& rig, const SE3& T_WC, const Vector2d& px) const {
    const auto ray = rig.cameras[0].Unproject(px);
    if (!ray) return std::nullopt;
    constexpr double kFar_m = 100;
    const Vector3d direction = T_WC.q * *ray;
    double nearest = kFar_m;
    int face = -1;
    index.VisitLine(T_WC.p, direction, 1e-3, nearest, [&](int f, double t) {
      if (t < nearest) nearest = t, face = f;
      return true;
    });
    if (face < 0) return std::nullopt;
    return Hit{T_WC.p + nearest * direction, FaceNormal(mesh, face), face};
  }

  /// Looks at the border of the patch.
  Ground Judge(const StereoRig& rig, const SE3& T_WC, const Vector2d& px, const Hit& hit) const {
    constexpr double kRadius_px = 5, kDepthStep = 0.02;
    const double fold_cosine = std::cos(20 * std::numbers::pi / 180);
    Ground ground =
        mesh.plane_ids[static_cast<std::size_t>(hit.face)] < 0 ? Ground::kCurved : Ground::kFlat;
    const double depth = (hit.p_W - T_WC.p).norm();
    for (int i = 0; i < 8; ++i) {
      const double a = i * std::numbers::pi / 4;
      const std::optional<Hit> other =
          Cast(rig, T_WC, px + kRadius_px * Vector2d(std::cos(a), std::sin(a)));
      if (!other) return Ground::kDepthEdge;
      const double off = std::min(std::abs(hit.n_W.dot(other->p_W - hit.p_W)),
                                  std::abs(other->n_W.dot(other->p_W - hit.p_W)));
      if (off > kDepthStep * depth) return Ground::kDepthEdge;
      if (std::abs(hit.n_W.dot(other->n_W)) < fold_cosine) ground = Ground::kCrease;
    }
    return ground;
  }

  TriangleMesh mesh;
  TriangleIndex index;
};

TrueScene::TrueScene(const std::filesystem::path& sequence)
    : surfaces_(std::make_unique<Surfaces>(ReadPly(sequence / "truth" / "mesh.ply"))) {}

TrueScene::~TrueScene() = default;

std::optional<ScenePoint> TrueScene::Find(const StereoRig& rig,
                                          const SE3& T_WB,
                                          const Vector2d& px) const {
  const SE3 T_WC = T_WB * rig.T_BC[0];
  const std::optional<Hit> hit = surfaces_->Cast(rig, T_WC, px);
  if (!hit) return std::nullopt;
  return ScenePoint{hit->p_W,
                    hit->n_W,
                    surfaces_->Judge(rig, T_WC, px, *hit),
                    surfaces_->mesh.plane_ids[static_cast<std::size_t>(hit->face)]};
}

}  // namespace facet
