// SPDX-License-Identifier: BSD-2-Clause
// The whole evaluation on a recording with exact truth: a result folder whose trajectory, planes
// and map are the truth itself must be judged nearly perfect.
#include <cmath>
#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "facet/eval/run_evaluation.h"
#include "facet/geometry/so3.h"
#include "facet/io/ply_reader.h"
#include "facet/io/ply_writer.h"
#include "facet/testing/data_dir.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr double kCell = 0.06;  // [m]

// Squares wherever the cloud has a point on a plane.
TriangleMesh TiledPlanes(const std::vector<Vector3d>& cloud, const std::vector<TruePlane>& planes) {
  TriangleMesh mesh;
  for (const TruePlane& plane : planes) {
    if (plane.seen_area_m2 < 0.5) continue;
    const Matrix<3, 2> basis = TangentBasis(plane.n_G);
    std::set<std::pair<int, int>> cells;
    for (const Vector3d& p : cloud) {
      if (std::abs(plane.n_G.dot(p) - plane.d_G) > 0.002) continue;
      const Vector2d q = basis.transpose() * p / kCell;
      cells.emplace(std::floor(q.x()), std::floor(q.y()));
    }
    for (const auto& [c, r] : cells) {
      const int first = static_cast<int>(mesh.vertices.size());
      for (const auto& [dc, dr] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        mesh.vertices.push_back(plane.d_G * plane.n_G +
                                basis * Vector2d(kCell * (c + dc), kCell * (r + dr)));
      }
      mesh.faces.push_back({first, first + 1, first + 2});
      mesh.faces.push_back({first, first + 2, first + 3});
    }
  }
  return mesh;
}

void WritePlanes(const fs::path& file, const std::vector<TruePlane>& planes) {
  std::ofstream stream(file);
  stream.precision(12);
  stream << "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first_seen_ns,last_seen_ns,landmarks,area_m2,"
            "sigma_normal_rad,sigma_d_m\n";
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const TruePlane& plane = planes[i];
    if (plane.seen_area_m2 < 0.5) continue;
    const Vector3d& n = plane.n_G;
    const Vector3d c = plane.d_G * n;
    stream << i << ',' << n.x() << ',' << n.y() << ',' << n.z() << ',' << plane.d_G << ',' << c.x()
           << ',' << c.y() << ',' << c.z() << ",,,0,0,10," << plane.seen_area_m2 << ",0,0\n";
  }
}

TEST(RenderedRoomTest, TruthJudgedAgainstItself) {
  const auto sequence = testing::DataDir("rendered_room");
  if (!sequence) GTEST_SKIP() << testing::MissingData("rendered_room");
  const GroundTruth truth = LoadGroundTruth(*sequence);
  ASSERT_TRUE(truth.surface);
  const std::vector<TruePlane> planes = ReadTruePlanes(truth.planes_file);
  const TriangleMesh mesh = TiledPlanes(ReadPly(truth.surface->path()).vertices, planes);
  const TempFolder result;
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < truth.poses.size(); i += 10)
    poses.push_back(truth.poses[i]);
  WriteTum(result / "trajectory.tum", poses);
  WritePlyMesh(result / "map.ply", mesh);
  fs::create_directory(result / "meshes");
  for (std::size_t i = 0; i < poses.size(); i += 200)
    WritePlyMesh(result / "meshes" / (std::to_string(poses[i].t.ns) + ".ply"), mesh);
  WritePlanes(result / "planes.csv", planes);

  const RunEvaluation evaluation = EvaluateRun(result.path(), truth, {});
  ASSERT_TRUE(evaluation.map);
  const MeshFigures& map = evaluation.map->aligned;
  EXPECT_LT(map.accuracy.median_m, 0.002);
  EXPECT_LT(map.accuracy.p90_m, 0.01);
  EXPECT_GT(evaluation.map->num_seen, 30'000u);
  EXPECT_GT((*map.completeness)[0], 0.7);  // the rest is furniture that is not flat
  EXPECT_GT((*map.fscore)[1], 0.85);
  EXPECT_EQ(map.by_range.size(), 3u);
  EXPECT_LT(evaluation.map->icp.correction_translation_m, 0.002);
  EXPECT_EQ(evaluation.mesh->num_files, 3);
  EXPECT_GT(*evaluation.planes->recall, 0.99);
  EXPECT_DOUBLE_EQ(*evaluation.planes->precision, 1);
  EXPECT_EQ(evaluation.planes->num_duplicates, 0);
}

}  // namespace
}  // namespace facet
