// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/vertex_sigmas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

TEST(VertexSigmasTest, ComeBackAsTheyWere) {
  const TempFolder folder;
  TriangleMesh mesh;
  mesh.vertices.resize(3, Vector3d::Zero());
  WriteVertexSigmas(folder / "a.ply", mesh.sigma_m);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.sigma")) << "it has none";
  mesh.sigma_m = {0.1F, 0.25F, 1.0F / 3};
  WriteVertexSigmas(folder / "a.ply", mesh.sigma_m);
  TriangleMesh read;
  read.vertices = mesh.vertices;
  ReadVertexSigmas(folder / "a.ply", read);
  EXPECT_EQ(read.sigma_m, mesh.sigma_m);
  WriteVertexSigmas(folder / "meshes" / "7.ply", mesh.sigma_m);
  EXPECT_FALSE(std::filesystem::exists(folder / "meshes")) << "meshes are alone there";
  EXPECT_TRUE(std::filesystem::exists(folder / "mesh_sigmas" / "7.sigma"));
  ReadVertexSigmas(folder / "meshes" / "7.ply", read);
  EXPECT_EQ(read.sigma_m, mesh.sigma_m);
  ReadVertexSigmas(folder / "b.ply", read);
  EXPECT_TRUE(read.sigma_m.empty());
}

TEST(VertexSigmasTest, ThoseOfAnotherMeshAreRefused) {
  const TempFolder folder;
  TriangleMesh mesh;
  mesh.vertices.resize(3, Vector3d::Zero());
  for (const auto& [text, reason] : std::vector<std::pair<std::string, std::string>>{
           {"sigma_m\n0.1\n0.2\n", "2 values for 3 vertices"},
           {"sigma_m\n0.1\n-1\n0.2\n", "a.sigma:3: no 1-sigma"},
           {"sigma_m\n0.1\n0.2\nx\n", "a.sigma:4: no 1-sigma"}}) {
    WriteText(folder / "a.sigma", text);
    try {
      ReadVertexSigmas(folder / "a.ply", mesh);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(reason));
    }
  }
}

}  // namespace
}  // namespace facet
