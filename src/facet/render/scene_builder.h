// SPDX-License-Identifier: BSD-2-Clause
// The built-in scenes. They are built around the path that the cameras will take: nothing is put
// where it would be in the way.
#pragma once

#include <span>

#include "facet/render/lighting.h"
#include "facet/render/materials.h"
#include "facet/render/scene_mesh.h"

namespace facet {

struct SceneModel {
  SceneMesh mesh;  ///< without light
  Lighting lighting;
};

/// What a builder needs to know.
struct ScenePlan {
  const MaterialLibrary& materials;
  std::span<const Vector3d> path_W;  ///< positions of the body, some cm apart
  /// Points close in front of the cameras where somebody with a camera in the hand looks at
  /// something; empty for flights, which keep away from things.
  std::span<const Vector3d> near_W;
  std::uint64_t seed = 1;
};

/// A furnished room around the path, at least 8 x 8 x 4 m, turned by a random angle.
SceneModel BuildRoom(const ScenePlan& plan);

/// A ring of corridors with rooms inside it; all corners are right angles. The path follows
/// CorridorRoute.
SceneModel BuildCorridor(const ScenePlan& plan);

/// Uneven ground, boulders, bushes and a rough cave around them: not one plane.
SceneModel BuildClutter(const ScenePlan& plan);

/// An office of 12 x 8 m or more: islands of desks with screens, shelves, whiteboards, a meeting
/// table, sloped boards and a ramp.
SceneModel BuildOffice(const ScenePlan& plan);

/// A machine hall of 30 x 20 x 8 m or more. One half of the ground is level, the other one uneven.
SceneModel BuildHall(const ScenePlan& plan);

/// A yard outdoors: fronts of buildings 10 to 40 m from the path, cars, trees and poles, under a
/// sky without texture.
SceneModel BuildFacade(const ScenePlan& plan);

/// Waypoints along which the built-in flights go, in a frame with the floor at z = 0.
std::vector<Vector3d> RoomRoute(std::uint64_t seed);
std::vector<Vector3d> CorridorRoute(std::uint64_t seed);
std::vector<Vector3d> ClutterRoute(std::uint64_t seed);
std::vector<Vector3d> OfficeRoute(std::uint64_t seed);
std::vector<Vector3d> HallRoute(std::uint64_t seed);
std::vector<Vector3d> FacadeRoute(std::uint64_t seed);

}  // namespace facet
