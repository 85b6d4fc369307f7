// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/ply_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/io/ply_writer.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5}};
  mesh.normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  mesh.colours = {{{1, 2, 3}}, {{4, 5, 6}}, {{7, 8, 9}}, {{250, 251, 252}}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  mesh.plane_ids = {7, -1, -1, 12};
  return mesh;
}

class PlyReaderTest : public ::testing::Test {
 protected:
  TriangleMesh Read(const std::string& content) const {
    WriteText(folder_ / "a.ply", content);
    return ReadPly(folder_ / "a.ply");
  }

  std::string MessageOf(const std::string& content) const {
    try {
      Read(content);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  TempFolder folder_;
};

const char* const kAscii =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty double x\n"
    "property double y\nproperty double z\nproperty float intensity\nelement face 1\n"
    "property list uchar int vertex_index\nend_header\n"
    "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0.25 9\n4 0 1 2 3\n";

TEST_F(PlyReaderTest, ReadsBackWhatWasWritten) {
  const TriangleMesh mesh = Tetrahedron();
  WritePlyMesh(folder_ / "b.ply", mesh);
  const TriangleMesh again = ReadPly(folder_ / "b.ply");
  EXPECT_EQ(again.vertices, mesh.vertices);
  EXPECT_EQ(again.normals, mesh.normals);
  EXPECT_EQ(again.colours, mesh.colours);
  EXPECT_EQ(again.faces, mesh.faces);
  EXPECT_EQ(again.plane_ids, mesh.plane_ids);
  EXPECT_TRUE(again.sigma_m.empty());
}

TEST_F(PlyReaderTest, AMeshComesBackWithTheSigmasOfItsVertices) {
  TriangleMesh mesh = Tetrahedron();
  mesh.sigma_m = {0.5F, 0.25F, 0.125F, 2};
  WritePlyMesh(folder_ / "b.ply", mesh);
  const TriangleMesh again = ReadPly(folder_ / "b.ply");
  EXPECT_EQ(again.sigma_m, mesh.sigma_m);
  EXPECT_EQ(again.colours, mesh.colours);
  EXPECT_EQ(again.vertices, mesh.vertices);
}

TEST_F(PlyReaderTest, PointsHaveNoFaces) {
  const std::vector<Vector3d> points = {{1, 2, 3}, {4, 5, 6}};
  WritePlyPoints(folder_ / "p.ply", points);
  const TriangleMesh cloud = ReadPly(folder_ / "p.ply");
  EXPECT_EQ(cloud.vertices, points);
  EXPECT_TRUE(cloud.faces.empty());
  EXPECT_TRUE(cloud.normals.empty());
}

TEST_F(PlyReaderTest, AsciiPolygonsBecomeFans) {
  const TriangleMesh mesh = Read(kAscii);
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.vertices[3], Vector3d(0, 1, 0.25));
  const std::vector<std::array<int, 3>> fan = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(mesh.faces, fan);
  EXPECT_TRUE(mesh.plane_ids.empty());
}

TEST_F(PlyReaderTest, WindowsLineEnds) {
  std::string text = kAscii;
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2)
    text.replace(i, 1, "\r\n");
  EXPECT_EQ(Read(text).faces.size(), 2u);
}

TEST_F(PlyReaderTest, NamesFileAndLineOfWhatIsWrong) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = kAscii;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(MessageOf("hello\n"), HasSubstr("a.ply:1: is not a PLY file"));
  EXPECT_THAT(MessageOf("ply\nformat ascii 1.0\n"), HasSubstr("no end_header"));
  EXPECT_THAT(MessageOf(changed("ascii", "binary_big_endian")),
              HasSubstr("a.ply:2: format 'binary_big_endian' is not supported"));
  EXPECT_THAT(MessageOf(changed("property double y", "property length y")),
              HasSubstr("a.ply:6: unknown property type 'length'"));
  EXPECT_THAT(MessageOf(changed("double y", "double why")), HasSubstr("no x y z"));
  EXPECT_THAT(MessageOf(changed("1 1 0 9", "1 nan 0 9")),
              HasSubstr("a.ply:14: vertex 2: the position is not finite"));
  EXPECT_THAT(MessageOf(changed("1 1 0 9", "1 one 0 9")), HasSubstr("'one' is not a number"));
  EXPECT_THAT(MessageOf(changed("4 0 1 2 3", "4 0 1 2 4")),
              HasSubstr("a.ply:16: face 0: has a vertex that does not exist; the file has 4"));
  EXPECT_THAT(MessageOf(changed("4 0 1 2 3", "4 0 1")), HasSubstr("face 0: the file ends here"));
  EXPECT_THAT(MessageOf("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n"
                        "property float y\nproperty float z\nend_header\n"),
              HasSubstr("holds no vertex"));
  EXPECT_THAT(MessageOf(changed("property list uchar int vertex_index\n", "")),
              HasSubstr("a.ply:14: face 0: the element has no properties"));
  EXPECT_THAT(MessageOf(changed("vertex 4", "vertex 4000000000000")), HasSubstr("a.ply"));
}

// Read as far as they look like numbers, "1e9" faces would be one.
TEST_F(PlyReaderTest, CountsAreWholeNumbersInDigits) {
  const auto with_faces = [](const std::string& count) {
    std::string text = kAscii;
    const std::string from = "element face 1";
    return text.replace(text.find(from), from.size(), "element face" + count);
  };
  for (const char* count :
       {" 1e9", " 1.0", " -1", " +1", " 0x1", " 1 2", " one", "", " 99999999999999999999"})
    EXPECT_THAT(MessageOf(with_faces(count)), HasSubstr("a.ply:9: 'element NAME COUNT'")) << count;
  EXPECT_EQ(MessageOf(with_faces(" 1")), "accepted");
  EXPECT_THAT(MessageOf(with_faces(" 4000000000000")),
              HasSubstr("a.ply:17: face 1: the file ends"));
}

TEST_F(PlyReaderTest, NumbersThatDoNotFitTheirType) {
  const std::string faces_first =
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
      "element vertex 4000000000000\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n3 0 1 3999999999999\n0 0 0\n";
  EXPECT_THAT(MessageOf(faces_first), HasSubstr("a.ply: 4000000000000 vertices; at most"));
  const auto with_plane = [](const std::string& vertex, const std::string& id) {
    return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
           "element face 1\nproperty list uchar int vertex_index\nproperty int plane_id\n"
           "end_header\n0 0 0 nan -5 1e300\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 " +
           vertex + " " + id + "\n";
  };
  EXPECT_THAT(MessageOf(with_plane("2", "1e300")), HasSubstr("plane_id"));
  EXPECT_THAT(MessageOf(with_plane("2", "nan")), HasSubstr("plane_id"));
  EXPECT_THAT(MessageOf(with_plane("1.5", "3")), HasSubstr("a vertex that does not exist"));
  const TriangleMesh mesh = Read(with_plane("2", "3"));
  EXPECT_EQ(mesh.plane_ids, std::vector<int>{3});
  EXPECT_THAT(mesh.colours.front(), ::testing::ElementsAre(0, 0, 255));
}

TEST_F(PlyReaderTest, TruncatedBinaryFile) {
  WritePlyMesh(folder_ / "b.ply", Tetrahedron());
  const std::string content = ReadText(folder_ / "b.ply");
  EXPECT_THAT(MessageOf(content.substr(0, content.size() - 5)),
              HasSubstr("face 3: the file ends here, it is incomplete"));
}

TEST_F(PlyReaderTest, MissingFile) {
  EXPECT_THROW(ReadPly(folder_ / "none.ply"), InputError);
  EXPECT_THROW(ReadPly(folder_.path()), InputError);
}

}  // namespace
}  // namespace facet
