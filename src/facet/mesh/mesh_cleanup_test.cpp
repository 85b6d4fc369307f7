// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/mesh_cleanup.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

TEST(MeshCleanUp, LeavesEachFaceOnceAndNoLooseVertices) {
  TriangleMesh mesh;
  mesh.vertices = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}};
  for (std::uint8_t i = 0; i < 7; ++i)
    mesh.colours.push_back({i, i, i});
  mesh.faces = {{1, 2, 3}, {3, 1, 4}, {4, 5, 3}, {1, 2, 6}, {2, 4, 5}};
  mesh.plane_ids = {0, 1, 2, 3, 4};
  CleanUp(mesh);
  EXPECT_EQ(mesh.vertices, (std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(mesh.faces, (std::vector<std::array<int, 3>>{{0, 1, 2}, {1, 3, 2}}));
  EXPECT_EQ(mesh.plane_ids, (std::vector<int>{0, 2}));
  EXPECT_EQ(mesh.colours[3][0], 5);
}

TEST(MeshCleanUp, NothingStaysNothing) {
  TriangleMesh mesh;
  CleanUp(mesh);
  EXPECT_TRUE(mesh.vertices.empty());
}

}  // namespace
}  // namespace facet
