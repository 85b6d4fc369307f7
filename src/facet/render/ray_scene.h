// SPDX-License-Identifier: BSD-2-Clause
// Rays against the triangles of a scene. The only file that knows Embree.
#pragma once

#include <memory>
#include <optional>

#include "facet/render/scene_mesh.h"

namespace facet {

/// Sixteen rays and what they hit: the arrays that Embree works on, without its types.
struct RayPacket {
  static constexpr int kSize = 16;
  static constexpr std::uint32_t kMiss = ~0U;
  /// In: origin and direction (any length) in W.
  alignas(64) float origin[3][kSize];
  alignas(64) float direction[3][kSize];
  /// Out: triangle, or kMiss; distance in lengths of the direction; barycentric weights of the
  /// triangle's second and third corner.
  alignas(64) std::uint32_t triangle[kSize];
  alignas(64) float distance[kSize];
  alignas(64) float weight_1[kSize], weight_2[kSize];
};

struct SceneHit {
  std::uint32_t triangle = RayPacket::kMiss;
  double distance = 0;  ///< in lengths of the direction
  double weight_1 = 0, weight_2 = 0;
  bool is_back_face = false;
};

/// Thread-safe once it is built. Keeps its own copy of the corners.
class RayScene {
 public:
  /// CHECKs that there is at least one triangle.
  explicit RayScene(const SceneMesh& mesh);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// Neighbouring rays; fills the out part.
  void Intersect(RayPacket& packet) const;

  std::optional<SceneHit> Cast(const Vector3d& origin_W, const Vector3d& direction_W) const;

  /// Whether anything lies between the two points, a millimetre at both ends left out.
  bool IsBlocked(const Vector3d& from_W, const Vector3d& to_W) const;

  /// Whether anything lies on the ray before `length`, in metres; direction of unit length.
  bool IsBlocked(const Vector3d& origin_W, const Vector3d& direction_W, double length) const;

  struct Nearest {
    double distance_m = 0;
    std::uint32_t triangle = RayPacket::kMiss;
  };
  /// The surface nearest to a point, if one is within `radius_m`.
  std::optional<Nearest> FindNearest(const Vector3d& p_W, double radius_m) const;

 private:
  struct Device;
  std::unique_ptr<Device> device_;
  const SceneMesh& mesh_;
};

}  // namespace facet
