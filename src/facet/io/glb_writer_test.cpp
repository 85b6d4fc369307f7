// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/glb_writer.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

std::string ReadAll(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::uint32_t WordAt(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

TEST(GlbWriter, HeaderChunksAndArraysFitTogether) {
  const TempFolder folder;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 1}, {2, 0, 1}, {0, 3, 1}, {2, 3, 1}};
  mesh.faces = {{0, 1, 2}, {1, 3, 2}};
  mesh.colours.assign(4, {1, 2, 3});
  const auto file = folder.path() / "mesh.glb";
  WriteGlbMesh(file, mesh);
  const std::string bytes = ReadAll(file);
  ASSERT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(WordAt(bytes, 4), 2u);
  EXPECT_EQ(WordAt(bytes, 8), bytes.size());
  const std::uint32_t json_size = WordAt(bytes, 12);
  EXPECT_EQ(json_size % 4, 0u);
  const auto json = nlohmann::json::parse(bytes.substr(20, json_size));
  EXPECT_EQ(bytes.substr(24 + json_size, 4), std::string("BIN\0", 4));
  EXPECT_EQ(WordAt(bytes, 20 + json_size), json["buffers"][0]["byteLength"]);
  std::size_t end = 0;
  for (const auto& view : json["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"], end);
    EXPECT_EQ(end % 4, 0u);
    end += view["byteLength"].get<std::size_t>();
  }
  EXPECT_EQ(end, json["buffers"][0]["byteLength"]);
  EXPECT_EQ(json["accessors"][0]["max"], (std::vector<float>{2, 3, 1}));
  EXPECT_EQ(json["accessors"][3]["count"], 6);
  const std::size_t faces =
      28 + json_size + json["bufferViews"][3]["byteOffset"].get<std::size_t>();
  EXPECT_EQ(WordAt(bytes, faces + 4), 1u);
  EXPECT_EQ(WordAt(bytes, faces + 16), 3u);
}

/// A float of an array of the file, by its accessor.
float FloatAt(const std::string& bytes, int accessor, std::size_t index) {
  const std::uint32_t json_size = WordAt(bytes, 12);
  const auto json = nlohmann::json::parse(bytes.substr(20, json_size));
  const std::size_t begin = json["bufferViews"][accessor]["byteOffset"];
  return std::bit_cast<float>(WordAt(bytes, 28 + json_size + begin + 4 * index));
}

TEST(GlbWriter, TheMaterialIsNoMetalAndHasTwoSides) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 1}, {2, 0, 1}, {0, 3, 1}};
  mesh.faces = {{0, 1, 2}};
  mesh.colours = {{0, 128, 255}, {0, 0, 0}, {0, 0, 0}};
  const std::string bytes = GlbBytes(mesh);
  const auto json = nlohmann::json::parse(bytes.substr(20, WordAt(bytes, 12)));
  EXPECT_EQ(json["meshes"][0]["primitives"][0]["material"], 0);
  const auto& material = json["materials"][0];
  EXPECT_EQ(material["pbrMetallicRoughness"]["metallicFactor"], 0.0);
  EXPECT_EQ(material["doubleSided"], true);
  EXPECT_EQ(json["accessors"][2]["componentType"], 5123);
  const std::size_t colours =
      28 + WordAt(bytes, 12) + json["bufferViews"][2]["byteOffset"].get<std::size_t>();
  EXPECT_EQ(WordAt(bytes, colours) >> 16, 14146u);  // 128 of 255 is 21.6 % of the light
  EXPECT_EQ(WordAt(bytes, colours + 4), 0xffffffffu);
}

TEST(GlbWriter, NormalsThatAreMissingComeFromTheFaces) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {1, 2, 0}, {1, 0, 3}};
  mesh.faces = {{0, 1, 2}};
  const std::string bytes = GlbBytes(mesh);
  EXPECT_FLOAT_EQ(FloatAt(bytes, 1, 0), 1);
  EXPECT_FLOAT_EQ(FloatAt(bytes, 1, 2), 0);
  mesh.normals = {{0, 0, 0}, {0, 0, 2}, {0, 1, 0}};  // glTF wants unit ones
  const std::string repaired = GlbBytes(mesh);
  EXPECT_FLOAT_EQ(FloatAt(repaired, 1, 2), 1);
  EXPECT_FLOAT_EQ(FloatAt(repaired, 1, 5), 1);
  EXPECT_FLOAT_EQ(FloatAt(repaired, 1, 7), 1);
}

TEST(GlbWriter, AnEmptyMeshIsAnEmptyScene) {
  const TempFolder folder;
  const auto file = folder.path() / "mesh.glb";
  WriteGlbMesh(file, TriangleMesh());
  const std::string bytes = ReadAll(file);
  EXPECT_EQ(WordAt(bytes, 8), bytes.size());
  EXPECT_FALSE(nlohmann::json::parse(bytes.substr(20)).contains("meshes"));
}

TEST(GlbWriter, AFileThatCannotBeWrittenIsNamed) {
  EXPECT_THROW(WriteGlbMesh("/nonexistent/mesh.glb", TriangleMesh()), OutputError);
}

}  // namespace
}  // namespace facet
