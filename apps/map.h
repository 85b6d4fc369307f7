// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet map` is told on the command line.
struct MapArguments {
  std::string map;     // folder of facet run --save-map
  std::string second;  // of merge: another one
  std::string out;     // of export: file.ply or file.tum; of merge: folder
  // Of localise.
  std::string recording, calibration, imu_calibration;
  std::vector<std::string> overrides;
  double start_s = 0, duration_s = 20;
  int run = 0;  // of export to .tum: which, from 1 on; 0: all
};

/// `facet map info`: what is in a map of places, on the standard output. Throws InputError.
void MapInfoCommand(const MapArguments& arguments);

/// `facet map export`: the points of its places, in the map, as a PLY file, or where the body was
/// at each place as a TUM trajectory. Throws InputError or OutputError.
void MapExportCommand(const MapArguments& arguments);

/// `facet map merge`: both maps as one, in the frame of the first, in a folder that has none yet,
/// and what was found on the standard output. Throws ConfigError where there is a map, InputError,
/// also where the second map is not found in the first, or OutputError.
void MapMergeCommand(const MapArguments& arguments);

/// `facet map localise`: where in the map the recording is, on the standard output, as soon as that
/// is known. Throws InputError, also where it is not found.
void MapLocaliseCommand(const MapArguments& arguments);

}  // namespace facet
