// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/scene_source.h"

#include <array>

#include "facet/geometry/angles.h"
#include "facet/io/errors.h"
#include "facet/render/scene_file.h"

namespace facet {
namespace {

struct NamedScene {
  const char* name;
  SceneModel (*build)(const ScenePlan&);
  std::vector<Vector3d> (*route)(std::uint64_t seed);
};
constexpr std::array<NamedScene, 6> kScenes = {{{"room", BuildRoom, RoomRoute},
                                                {"corridor", BuildCorridor, CorridorRoute},
                                                {"clutter", BuildClutter, ClutterRoute},
                                                {"office", BuildOffice, OfficeRoute},
                                                {"hall", BuildHall, HallRoute},
                                                {"facade", BuildFacade, FacadeRoute}}};

bool IsFile(const std::string& name) {
  std::error_code error;
  return std::filesystem::is_regular_file(name, error);
}

/// Empty if the scene is a file.
const NamedScene* FindScene(const std::string& name) {
  for (const NamedScene& scene : kScenes) {
    if (name == scene.name) return &scene;
  }
  if (IsFile(name)) return nullptr;
  throw ConfigError("--scene " + name + ": no such scene or file; known: " + SceneNames() +
                    ", or a scene file (docs/simulator.md)");
}

/// How far in front of the cameras things shall be; 0: wherever they happen to be.
double NearThings_m(const SimulationRequest& request) {
  constexpr double kArmsLength_m = 0.5;
  const double asked_m = request.options.near_things_m;
  if (asked_m > 0 && request.scene != "room") {
    throw ConfigError("near_things_m=" + std::to_string(asked_m) + ": --scene " + request.scene +
                      " has no things to put there; only room has");
  }
  if (asked_m >= 0) return asked_m;
  return FlightKindFromText(request.trajectory) == FlightKind::kHandHeld ? kArmsLength_m : 0;
}

}  // namespace

std::string SceneNames() {
  std::string names;
  for (const NamedScene& scene : kScenes)
    names += (names.empty() ? "" : ", ") + std::string(scene.name);
  return names;
}

Seeds::Seeds(std::uint64_t seed) {
  Rng rng(seed);
  for (std::uint64_t* part :
       {&textures, &scene, &flight, &light, &exposure, &noise, &imu, &truth}) {
    *part = rng.Next();
  }
}

Seeds Seeds::WithNoise(int realisation) const {
  Seeds other = *this;
  if (realisation == 0) return other;
  Rng rng(static_cast<std::uint64_t>(realisation));
  other.noise += rng.Next();
  other.imu += rng.Next();
  return other;
}

Motion MakeMotion(const SimulationRequest& request, const Seeds& seeds) {
  const NamedScene* scene = FindScene(request.scene);
  const MotionRange range{request.start_s, request.duration_s, request.options.image.rate_hz};
  const auto kind = FlightKindFromText(request.trajectory);
  if (!kind) {
    if (!IsFile(request.trajectory)) {
      throw ConfigError("--trajectory " + request.trajectory + ": no such flight or file; known: " +
                        FlightNames() + ", or a ground truth file in EuRoC's csv format");
    }
    return LoadMotion(request.trajectory, request.imu, range);
  }
  if (!request.imu.empty()) {
    throw ConfigError("--imu " + request.imu +
                      ": a real IMU only goes with a recorded --trajectory groundtruth.csv");
  }
  const std::vector<Vector3d> route_W =
      scene ? scene->route(seeds.scene) : ReadSceneRoute(request.scene);
  const double look_down = request.options.look_down_deg * kDegree;
  return MakeUpMotion(*kind, route_W, range, look_down, seeds.flight);
}

SceneModel MakeScene(const SimulationRequest& request,
                     const Motion& motion,
                     const Seeds& seeds,
                     MaterialLibrary& materials) {
  const NamedScene* scene = FindScene(request.scene);
  if (!scene) return ReadSceneFile(request.scene, seeds.scene, materials);
  const double near_m = NearThings_m(request);
  std::vector<Vector3d> path_W, near_W;
  for (Timestamp t = motion.imu_begin; t < motion.imu_end; t = t + FromSeconds(0.05)) {
    const SE3 T_WB = motion.trajectory.At(t).state.T_WB;
    path_W.push_back(T_WB.p);
    // The cameras look along the body's z, as EuRoC's do and as made-up flights expect.
    if (near_m > 0) near_W.push_back(T_WB * Vector3d(0, 0, near_m));
  }
  return scene->build({materials, path_W, near_W, seeds.scene});
}

}  // namespace facet
