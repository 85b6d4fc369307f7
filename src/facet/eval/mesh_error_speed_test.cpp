// SPDX-License-Identifier: BSD-2-Clause
// What the evaluation of a large mesh costs. Apart from the other tests, because sanitizers and
// debug builds would fail it.
#include <cmath>
#include <ctime>
#include <iostream>

#include <gtest/gtest.h>

#include "facet/eval/mesh_error.h"
#include "facet/eval/visibility.h"
#include "facet/geometry/so3.h"
#include "facet/testing/eval/test_shapes.h"

namespace facet {
namespace {

TEST(MeshErrorSpeedTest, LargeMeshAgainstLargeCloudInTime) {
  // A wavy floor of 200k faces against a scan of 2 million points; thread CPU time, so that other
  // programs on the machine do not matter.
  TriangleMesh mesh = Square(14, 0, 317), dense = Square(14, 0, 100);
  for (TriangleMesh* m : {&mesh, &dense}) {
    for (Vector3d& p : m->vertices)
      p.z() = 0.3 * std::sin(p.x()) * std::cos(p.y());
  }
  TriangleMesh cloud = CloudOf(dense, 10300);
  ASSERT_GT(mesh.faces.size(), 200'000u);
  ASSERT_GT(cloud.vertices.size(), 2'000'000u);
  const std::clock_t begin = std::clock();
  const auto surface = MakeTruthSurface(std::move(cloud));
  std::vector<SE3> poses;
  for (int i = 0; i < 100; ++i)
    poses.emplace_back(ExpSO3({0, 0.6, 0.06 * i}), Vector3d(7, 7, 2));
  MeshUnderTest test;
  test.mesh_G = std::move(mesh);
  test.range_m = [](const Vector3d& p, int) { return (p - Vector3d(7, 7, 2)).norm(); };
  const auto seen = SeenPoints(*surface, RigLookingAlongX(), poses);
  const auto seen_near = SeenPoints(*surface, RigLookingAlongX(), poses, {kNearRange});
  const MeshError error =
      EvaluateMesh(test, *surface, {std::vector<char>(seen.size(), 1), seen_near});
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::cout << "200k faces against 2M points: " << seconds << " s\n";
  EXPECT_LT(seconds, 20);
  EXPECT_LT(error.aligned.accuracy.mean_m, 0.005);
}

}  // namespace
}  // namespace facet
