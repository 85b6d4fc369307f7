// SPDX-License-Identifier: BSD-2-Clause
// Which scene and which motion a request names.
#pragma once

#include "facet/render/motion.h"
#include "facet/render/scene_builder.h"
#include "facet/render/simulator.h"

namespace facet {

/// Seeds of the independent parts of a simulation: changing one leaves the others as they are.
struct Seeds {
  explicit Seeds(std::uint64_t seed);
  /// The same scene, flight and exposures with other noise of cameras and IMU. 0: no change.
  Seeds WithNoise(int realisation) const;
  std::uint64_t textures, scene, flight, light, exposure, noise, imu, truth;
};

/// Throws ConfigError for an unknown name and InputError for unusable files.
Motion MakeMotion(const SimulationRequest& request, const Seeds& seeds);

/// The scene that the request names, built around the motion. Adds the pictures of a scene file to
/// `materials`. Throws ConfigError for an unknown name and InputError for unusable files.
SceneModel MakeScene(const SimulationRequest& request,
                     const Motion& motion,
                     const Seeds& seeds,
                     MaterialLibrary& materials);

}  // namespace facet
