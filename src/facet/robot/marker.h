// SPDX-License-Identifier: BSD-2-Clause
// Meshes and planes as ROS draws them: visualization_msgs/Marker and sensor_msgs/PointCloud2 as
// plain data. Each middleware copies them into messages of its own.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "facet/facet.h"
#include "facet/robot/robot_output.h"

namespace facet {
namespace robot {

/// red, green, blue, opacity, from 0 to 1.
using Colour = std::array<float, 4>;

/// What is not here is the same for all markers: they move with their frame and live for ever.
struct Marker {
  enum Type { kArrow = 0, kLineStrip = 4, kText = 9, kTriangles = 11 };
  enum Action { kAdd = 0, kDelete = 2, kDeleteAll = 3 };

  std::int64_t t_ns = 0;
  std::string name;  ///< `ns` in ROS; with `id` it says which marker this is
  std::int32_t id = 0;
  Type type = kArrow;
  Action action = kAdd;
  api::Vec3 position{{0, 0, 0}};
  api::Vec3 scale{{0, 0, 0}};
  Colour colour{{0, 0, 0, 0}};
  std::vector<api::Vec3> points;
  std::vector<Colour> colours;  ///< one for each point, or none
  std::string text;
};

/// A list of triangles; of a mesh without any, the removal of the marker before.
Marker MeshMarker(std::int64_t t_ns,
                  const std::string& name,
                  std::int32_t id,
                  const api::Mesh& mesh);

/// Outline and label of each plane, and the removal of those that are gone.
std::vector<Marker> PlaneMarkers(const PlanesOutput& output);

/// Removes all markers of a topic.
Marker RemovalOfAll();

/// Points as rows of floats: x y z and, where the mesh has colours, rgb, which is the three bytes
/// 0x00RRGGBB in the place of a float, as PCL and rviz read it.
struct PointRows {
  bool has_colours = false;
  std::uint32_t num_points = 0;
  std::uint32_t bytes_per_point = 0;
  std::vector<std::uint8_t> bytes;
};

/// The vertices of a mesh.
PointRows ToPointRows(const api::Mesh& mesh);

}  // namespace robot
}  // namespace facet
