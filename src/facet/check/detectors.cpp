// SPDX-License-Identifier: BSD-2-Clause
#include "facet/check/detectors.h"

namespace facet {

std::vector<std::unique_ptr<Detector>> MakeDetectors(const Calibration* calibration) {
  std::vector<std::unique_ptr<Detector>> detectors;
  for (const auto& make : {MakeImageBeat,
                           MakeImuBeat,
                           MakePairing,
                           MakeImuValues,
                           MakeStandstill,
                           MakeRepeatedImages,
                           MakeExposure,
                           MakeSharpness,
                           MakeTexture,
                           MakeFixedView}) {
    detectors.push_back(make());
  }
  if (calibration != nullptr) {
    detectors.push_back(MakeStereoGeometry(calibration->rig));
    detectors.push_back(MakeCameraImu(calibration->rig));
  }
  detectors.push_back(MakeSpecificForce());
  detectors.push_back(MakeAccelerometerAxes());
  if (calibration != nullptr) detectors.push_back(MakeImuNoise(calibration->imu_noise));
  return detectors;
}

}  // namespace facet
