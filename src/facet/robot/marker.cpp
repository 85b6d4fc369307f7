// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/marker.h"

#include <algorithm>
#include <cstring>

namespace facet {
namespace robot {

namespace {

constexpr double kLineWidth_m = 0.02, kTextHeight_m = 0.2;

Colour ToColour(const std::array<std::uint8_t, 3>& c) {
  constexpr float kFull = 255;
  return {{static_cast<float>(c[0]) / kFull,
           static_cast<float>(c[1]) / kFull,
           static_cast<float>(c[2]) / kFull,
           1}};
}

Colour ColourOfPlane(std::int64_t id) {
  constexpr std::array<std::array<std::uint8_t, 3>, 6> kColours = {{{{230, 75, 50}},
                                                                    {{50, 150, 230}},
                                                                    {{75, 200, 75}},
                                                                    {{230, 180, 25}},
                                                                    {{180, 75, 200}},
                                                                    {{50, 200, 180}}}};
  return ToColour(
      kColours[static_cast<std::size_t>(std::max<std::int64_t>(id, 0)) % kColours.size()]);
}

Marker Named(std::int64_t t_ns, const std::string& name, std::int32_t id) {
  Marker marker;
  marker.t_ns = t_ns;
  marker.name = name;
  marker.id = id;
  return marker;
}

Marker Outline(std::int64_t t_ns, const api::Plane& plane) {
  Marker marker = Named(t_ns, "outline", static_cast<std::int32_t>(plane.id));
  marker.type = Marker::kLineStrip;
  marker.scale[0] = kLineWidth_m;
  marker.colour = ColourOfPlane(plane.id);
  marker.points = plane.outline;
  marker.points.push_back(plane.outline.front());
  return marker;
}

Marker Label(std::int64_t t_ns, const api::Plane& plane) {
  Marker marker = Named(t_ns, "label", static_cast<std::int32_t>(plane.id));
  marker.type = Marker::kText;
  marker.scale[2] = kTextHeight_m;
  marker.colour = ColourOfPlane(plane.id);
  marker.text = plane.label + " " + std::to_string(plane.id);
  const double share = 1 / static_cast<double>(plane.outline.size());
  for (const api::Vec3& corner : plane.outline) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      marker.position[axis] += share * corner[axis];
  }
  return marker;
}

}  // namespace

// A list of triangles has each corner anew for each face.
Marker MeshMarker(std::int64_t t_ns,
                  const std::string& name,
                  std::int32_t id,
                  const api::Mesh& mesh) {
  Marker marker = Named(t_ns, name, id);
  if (mesh.faces.empty()) {
    marker.action = Marker::kDelete;
    return marker;
  }
  marker.type = Marker::kTriangles;
  marker.scale = {{1, 1, 1}};
  marker.colour = {{0.7F, 0.7F, 0.7F, 1}};
  const bool has_colours = mesh.colours.size() == mesh.vertices.size();
  marker.points.reserve(3 * mesh.faces.size());
  if (has_colours) marker.colours.reserve(3 * mesh.faces.size());
  for (const auto& face : mesh.faces) {
    for (const int corner : face) {
      const auto i = static_cast<std::size_t>(corner);
      marker.points.push_back(mesh.vertices[i]);
      if (has_colours) marker.colours.push_back(ToColour(mesh.colours[i]));
    }
  }
  return marker;
}

std::vector<Marker> PlaneMarkers(const PlanesOutput& output) {
  std::vector<Marker> markers;
  for (const api::Plane& plane : output.planes) {
    if (plane.outline.empty()) continue;
    markers.push_back(Outline(output.t_ns, plane));
    markers.push_back(Label(output.t_ns, plane));
  }
  for (const std::int64_t id : output.removed) {
    for (const char* name : {"outline", "label"}) {
      markers.push_back(Named(output.t_ns, name, static_cast<std::int32_t>(id)));
      markers.back().action = Marker::kDelete;
    }
  }
  return markers;
}

Marker RemovalOfAll() {
  Marker marker;
  marker.action = Marker::kDeleteAll;
  return marker;
}

PointRows ToPointRows(const api::Mesh& mesh) {
  PointRows rows;
  rows.has_colours = !mesh.vertices.empty() && mesh.colours.size() == mesh.vertices.size();
  rows.num_points = static_cast<std::uint32_t>(mesh.vertices.size());
  rows.bytes_per_point = static_cast<std::uint32_t>(sizeof(float)) * (rows.has_colours ? 4 : 3);
  rows.bytes.resize(std::size_t{rows.bytes_per_point} * rows.num_points);
  std::uint8_t* place = rows.bytes.data();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i, place += rows.bytes_per_point) {
    std::array<float, 3> xyz{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      xyz[axis] = static_cast<float>(mesh.vertices[i][axis]);
    std::memcpy(place, xyz.data(), sizeof xyz);
    if (!rows.has_colours) continue;
    const auto& [r, g, b] = mesh.colours[i];
    const std::uint32_t rgb = std::uint32_t{r} << 16 | std::uint32_t{g} << 8 | b;
    std::memcpy(place + sizeof xyz, &rgb, sizeof rgb);
  }
  return rows;
}

}  // namespace robot
}  // namespace facet
