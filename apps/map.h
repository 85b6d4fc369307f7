// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>

namespace facet {

/// What `facet map` is told on the command line.
struct MapArguments {
  std::string map;  // folder of facet run --save-map
  std::string out;  // of export: file.ply
};

/// `facet map info`: what is in a map of places, on the standard output. Throws InputError.
void MapInfoCommand(const MapArguments& arguments);

/// `facet map export`: the points of its places, in the map, as a PLY file. Throws InputError or
/// OutputError.
void MapExportCommand(const MapArguments& arguments);

}  // namespace facet
