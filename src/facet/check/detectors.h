// SPDX-License-Identifier: BSD-2-Clause
// The detectors, one in each source file of the same name.
#pragma once

#include <memory>

#include "facet/check/detector.h"

namespace facet {

std::unique_ptr<Detector> MakeImageBeat();
std::unique_ptr<Detector> MakeImuBeat();
std::unique_ptr<Detector> MakePairing();
std::unique_ptr<Detector> MakeImuValues();
std::unique_ptr<Detector> MakeStandstill();
std::unique_ptr<Detector> MakeRepeatedImages();
std::unique_ptr<Detector> MakeExposure();
std::unique_ptr<Detector> MakeSharpness();
std::unique_ptr<Detector> MakeTexture();
std::unique_ptr<Detector> MakeFixedView();
std::unique_ptr<Detector> MakeStereoGeometry(const StereoRig& rig);
std::unique_ptr<Detector> MakeCameraImu(const StereoRig& rig);
std::unique_ptr<Detector> MakeSpecificForce();
/// After the camera against the IMU, which tells the bias of the gyroscope.
std::unique_ptr<Detector> MakeAccelerometerAxes();
std::unique_ptr<Detector> MakeImuNoise(const ImuNoise& noise);

}  // namespace facet
