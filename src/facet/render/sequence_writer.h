// SPDX-License-Identifier: BSD-2-Clause
// The files of a simulated sequence in the ASL/EuRoC layout. All functions throw OutputError when a
// file cannot be written completely.
#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "facet/calibration/drawn_calibration.h"
#include "facet/camera/stereo_rig.h"
#include "facet/imu/imu_types.h"
#include "facet/render/scene_mesh.h"
#include "facet/render/surface_truth.h"

namespace facet {

/// Creates the folders below `sequence` and writes the calibration files, and those of the exact
/// rig as truth/cam0, cam1 and imu0.
void WriteCalibration(const std::filesystem::path& sequence,
                      const StereoRig& measured,
                      const StereoRig& exact,
                      const ImuNoise& noise,
                      double frame_rate_hz);

/// truth/imu0/errors.yaml: what the IMU does that its calibration does not know.
void WriteImuErrors(const std::filesystem::path& sequence, const ImuErrors& errors);

/// Those of a sequence; empty if it tells none. Throws InputError.
std::optional<ImuErrors> ReadImuErrors(const std::filesystem::path& sequence);

/// mav0/camN/data/STAMP.png, for camera N.
std::filesystem::path ImageFile(const std::filesystem::path& sequence, int camera, Timestamp t);

/// data.csv of both cameras.
void WriteImageLists(const std::filesystem::path& sequence, std::span<const Timestamp> stamps);

void WriteImu(const std::filesystem::path& sequence, std::span<const ImuSample> samples);

/// state_groundtruth_estimate0/data.csv.
void WriteStates(const std::filesystem::path& sequence, std::span<const NavState> states);

/// truth/mesh.ply (with the plane of each face), truth/planes.csv and mav0/pointcloud0/data.ply.
void WriteSurfaces(const std::filesystem::path& sequence,
                   const SceneMesh& mesh,
                   const SurfaceTruth& truth);

}  // namespace facet
