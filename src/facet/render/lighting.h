// SPDX-License-Identifier: BSD-2-Clause
// Light that does not move: computed before the first image.
#pragma once

#include <vector>

#include "facet/render/ray_scene.h"
#include "facet/render/scene_mesh.h"

namespace facet {

/// A lamp of some size: its shadows have soft borders.
struct Light {
  Vector3d p_W = Vector3d::Zero();
  double radius_m = 0.25;
  double power = 1;  ///< about the radiance of a white surface at 1 m that faces the lamp
};

struct Lighting {
  std::vector<Light> lights;
  double ambient = 0.35;         ///< light from everywhere, less in corners (ambient occlusion)
  double occlusion_reach_m = 1;  ///< surfaces nearer than this take ambient light away
  double sky = 0.8;              ///< radiance where a ray leaves the scene
};

/// Irradiance falls off with the squared distance, softened near the lamp.
double Falloff(const Light& light, double distance_m);

/// Sets the light of every part and vertex. The result does not depend on the number of threads.
void BakeLight(const RayScene& rays,
               const Lighting& lighting,
               std::uint64_t seed,
               int num_threads,
               SceneMesh& mesh);

}  // namespace facet
