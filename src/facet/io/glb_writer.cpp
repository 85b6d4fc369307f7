// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/glb_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

#include <nlohmann/json.hpp>

#include "facet/io/errors.h"
#include "facet/io/json_file.h"
#include "facet/mesh/vertex_normals.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little,
              "numbers are written as they lie in memory");

template <class T>
void Append(T value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void AppendVector(const Vector3d& v, std::string& bytes) {
  for (int i = 0; i < 3; ++i)
    Append(static_cast<float>(v[i]), bytes);
}

/// The arrays of the mesh one after the other, and their description.
struct Content {
  std::string bytes;
  Json json;

  int AddView(std::size_t begin, int target) {
    json["bufferViews"].push_back({{"buffer", 0},
                                   {"byteOffset", begin},
                                   {"byteLength", bytes.size() - begin},
                                   {"target", target}});
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
};

constexpr int kVertices = 34962, kIndices = 34963;                        // buffer targets
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;  // component types

void AddPositions(const TriangleMesh& mesh, Content& content) {
  const std::size_t begin = content.bytes.size();
  constexpr float kLarge = std::numeric_limits<float>::max();
  std::array<float, 3> low = {kLarge, kLarge, kLarge}, high = {-kLarge, -kLarge, -kLarge};
  for (const Vector3d& p : mesh.vertices) {
    AppendVector(p, content.bytes);
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], static_cast<float>(p[i]));
      high[i] = std::max(high[i], static_cast<float>(p[i]));
    }
  }
  content.json["accessors"].push_back({{"bufferView", content.AddView(begin, kVertices)},
                                       {"componentType", kFloat},
                                       {"count", mesh.vertices.size()},
                                       {"type", "VEC3"},
                                       {"min", low},
                                       {"max", high}});
}

/// Of unit length, which glTF asks for; up where nothing is known.
Vector3d UnitNormal(const Vector3d& n) {
  const double norm = n.norm();
  return norm > 0 && std::isfinite(norm) ? Vector3d(n / norm) : Vector3d(0, 0, 1);
}

void AddNormals(const TriangleMesh& mesh, Content& content) {
  const std::size_t begin = content.bytes.size();
  TriangleMesh with_normals;
  const std::vector<Vector3d>* normals = &mesh.normals;
  if (mesh.normals.empty()) {
    with_normals.vertices = mesh.vertices;
    with_normals.faces = mesh.faces;
    SetVertexNormals(with_normals);
    normals = &with_normals.normals;
  }
  for (const Vector3d& n : *normals)
    AppendVector(UnitNormal(n), content.bytes);
  content.json["accessors"].push_back({{"bufferView", content.AddView(begin, kVertices)},
                                       {"componentType", kFloat},
                                       {"count", mesh.vertices.size()},
                                       {"type", "VEC3"}});
}

/// The intensity of light of a grey value of an image (sRGB), which is what glTF's vertex colours
/// are; 0 to 65535, because 8 bits would be too few for dark ones.
std::uint16_t LinearLight(std::uint8_t value) {
  const double s = value / 255.0;
  const double light = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(std::lround(65535 * light));
}

void AddColours(const TriangleMesh& mesh, Content& content) {
  const std::size_t begin = content.bytes.size();
  constexpr std::uint8_t kGrey = 160;
  constexpr std::uint16_t kOpaque = 65535;
  std::array<std::uint16_t, 256> light;
  for (std::size_t i = 0; i < light.size(); ++i)
    light[i] = LinearLight(static_cast<std::uint8_t>(i));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel)
      Append(light[mesh.colours.empty() ? kGrey : mesh.colours[i][channel]], content.bytes);
    Append(kOpaque, content.bytes);
  }
  content.json["accessors"].push_back({{"bufferView", content.AddView(begin, kVertices)},
                                       {"componentType", kUnsignedShort},
                                       {"normalized", true},
                                       {"count", mesh.vertices.size()},
                                       {"type", "VEC4"}});
}

void AddFaces(const TriangleMesh& mesh, Content& content) {
  const std::size_t begin = content.bytes.size();
  for (const auto& face : mesh.faces) {
    for (int corner : face)
      Append(static_cast<std::uint32_t>(corner), content.bytes);
  }
  content.json["accessors"].push_back({{"bufferView", content.AddView(begin, kIndices)},
                                       {"componentType", kUnsignedInt},
                                       {"count", 3 * mesh.faces.size()},
                                       {"type", "SCALAR"}});
}

Content Describe(const TriangleMesh& mesh) {
  Content content;
  content.json["asset"] = {{"version", "2.0"}, {"generator", "facet"}};
  content.json["scene"] = 0;
  if (mesh.faces.empty()) {  // glTF has no empty arrays
    content.json["scenes"] = Json::array({Json::object()});
    return content;
  }
  const double half = std::sqrt(0.5);
  content.json["scenes"] = Json::array({Json::object({{"nodes", Json::array({0})}})});
  content.json["nodes"] = Json::array(
      {Json::object({{"mesh", 0}, {"rotation", Json::array({-half, 0.0, 0.0, half})}})});
  AddPositions(mesh, content);
  AddNormals(mesh, content);
  AddColours(mesh, content);
  AddFaces(mesh, content);
  const Json attributes = Json::object({{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}});
  const Json primitive =
      Json::object({{"attributes", attributes}, {"indices", 3}, {"material", 0}});
  const Json surface = Json::object({{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}});
  const Json material = Json::object({{"pbrMetallicRoughness", surface}, {"doubleSided", true}});
  content.json["materials"] = Json::array({material});
  content.json["meshes"] = Json::array({Json::object({{"primitives", Json::array({primitive})}})});
  content.json["buffers"] = Json::array({Json::object({{"byteLength", content.bytes.size()}})});
  return content;
}

void AppendChunk(std::string text, const char* type, char padding, std::string& file) {
  while (text.size() % 4 != 0)
    text += padding;
  Append(static_cast<std::uint32_t>(text.size()), file);
  file.append(type, 4);
  file += text;
}

}  // namespace

std::string GlbBytes(const TriangleMesh& mesh) {
  const Content content = Describe(mesh);
  std::string chunks;
  AppendChunk(JsonText(content.json), "JSON", ' ', chunks);
  if (!content.bytes.empty()) AppendChunk(content.bytes, "BIN\0", '\0', chunks);
  std::string header = "glTF";
  Append(std::uint32_t{2}, header);
  Append(static_cast<std::uint32_t>(12 + chunks.size()), header);
  return header + chunks;
}

void WriteGlbMesh(const std::filesystem::path& file, const TriangleMesh& mesh) {
  std::ofstream stream(file, std::ios::binary);
  stream << GlbBytes(mesh);
  stream.flush();
  if (!stream) throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
}

}  // namespace facet
