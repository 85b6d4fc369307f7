// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/view_message.h"

#include <array>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/viewer/scene_messages.h"

namespace facet {
namespace {

template <class T>
T At(const std::string& bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

TEST(ViewMessage, TheBytesAreThoseOfTheProtocol) {
  ViewMessage message({MessageType::kMesh, 1, Timestamp{1403715288300000001}, 7});
  const std::vector<float> numbers = {1, 2, 3};
  message.Add(BlockName::kPositions, std::span<const float>(numbers), 3);
  message.AddText("abc");
  const std::string bytes = message.Finish();
  ASSERT_EQ(bytes.size(), 32u + 8 + 16 + 8 + 8);
  EXPECT_EQ(bytes.substr(0, 4), "FCTV");
  EXPECT_EQ(At<std::uint16_t>(bytes, 4), kViewProtocol);
  EXPECT_EQ(At<std::uint16_t>(bytes, 6), 2);
  EXPECT_EQ(At<std::uint16_t>(bytes, 8), 1);
  EXPECT_EQ(At<std::uint16_t>(bytes, 10), 2);
  EXPECT_EQ(At<std::uint32_t>(bytes, 12), bytes.size());
  EXPECT_EQ(At<std::int64_t>(bytes, 16), 1403715288300000001);
  EXPECT_EQ(At<std::uint32_t>(bytes, 24), 7u);
  EXPECT_EQ(At<std::uint16_t>(bytes, 32), 2);
  EXPECT_EQ(At<std::uint8_t>(bytes, 34), 5);
  EXPECT_EQ(At<std::uint8_t>(bytes, 35), 3);
  EXPECT_EQ(At<std::uint32_t>(bytes, 36), 1u);
  EXPECT_EQ(At<float>(bytes, 48), 3);
  EXPECT_EQ(bytes.substr(64, 3), "abc");
  EXPECT_EQ(At<std::uint32_t>(bytes, 60), 3u);
}

TEST(ViewMessage, RowsAreWhole) {
  ViewMessage message({MessageType::kMesh});
  const std::vector<float> numbers = {1, 2};
  EXPECT_THROW(message.Add(BlockName::kPositions, std::span<const float>(numbers), 3), CheckError);
}

TEST(SceneMessages, AMeshWithoutFacesHasItsHeaderOnly) {
  EXPECT_EQ(MeshMessage({MessageType::kMapPart}, TriangleMesh()).size(), 32u);
}

TEST(SceneMessages, NormalsThatAreNotFiniteAreSentAsZero) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}};
  mesh.normals = {{std::nan(""), 2, -1}};
  const std::string bytes = MeshMessage({MessageType::kMesh}, mesh);
  const std::size_t normals = 32 + 8 + 16 + 8;
  EXPECT_EQ(At<std::int8_t>(bytes, normals), 0);
  EXPECT_EQ(At<std::int8_t>(bytes, normals + 1), 127);
  EXPECT_EQ(At<std::int8_t>(bytes, normals + 2), -127);
}

}  // namespace
}  // namespace facet
