// SPDX-License-Identifier: BSD-2-Clause
// Where everything that a calibration says of a rig stands in the vectors of its errors: RigVector
// (calibration/rig_parameters.h) and CalibrationVector (calibration/calibration_vector.h).
#pragma once

namespace facet {

inline constexpr int kNumIntrinsics = 8;   ///< of one camera: fx fy cx cy, four of distortion
inline constexpr int kPrincipalPoint = 2;  ///< cx among them
inline constexpr int kStereoRotation = 2 * kNumIntrinsics;
inline constexpr int kStereoTranslation = kStereoRotation + 3;
inline constexpr int kNumRigParameters = kStereoTranslation + 3;

inline constexpr int kNumLensModes = 10;  ///< of one camera (calibration/lens_modes.h)
inline constexpr int kLensModes = kNumRigParameters;
inline constexpr int kNumLensColumns = kLensModes + 2 * kNumLensModes;  ///< those of the images

inline constexpr int kMountRotation = kNumLensColumns;
inline constexpr int kMountTranslation = kMountRotation + 3;
inline constexpr int kTimeOffset = kMountTranslation + 3;
inline constexpr int kGyroScale = kTimeOffset + 1;
inline constexpr int kNumCalibration = kGyroScale + 3;
/// Those that move the cameras of a frame as a whole, like its pose.
inline constexpr int kNumMount = kGyroScale - kNumLensColumns;

}  // namespace facet
