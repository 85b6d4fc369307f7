// SPDX-License-Identifier: BSD-2-Clause
// The boards of a pallet in a recorded sequence are flat, and so must be the horizon mesh on them.
// Their outlines in some images were drawn by hand (testdata/mh01_pallet.csv). With planes they are
// one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "facet/io/asl_dataset.h"
#include "facet/mesh/mesh_query.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/testing/data_dir.h"

namespace facet {
namespace {

constexpr double kStep_px = 4;  // between the rays that ask the mesh
// The boards are nearer than this; a ray that passes through a hole of the mesh and meets what lies
// behind says nothing about them, and is counted as not met.
constexpr double kRange_m = 2;

struct Outline {
  std::string board;
  std::vector<Vector2d> px;

  bool Contains(const Vector2d& p) const {
    bool is_inside = false;
    for (std::size_t i = 0, j = px.size() - 1; i < px.size(); j = i++) {
      const bool crosses = (px[i].y() > p.y()) != (px[j].y() > p.y());
      const double t = (p.y() - px[i].y()) / (px[j].y() - px[i].y());
      if (crosses && p.x() < px[i].x() + t * (px[j].x() - px[i].x())) is_inside = !is_inside;
    }
    return is_inside;
  }
};

std::map<Timestamp, std::vector<Outline>> ReadOutlines() {
  std::map<Timestamp, std::vector<Outline>> outlines;
  std::ifstream file(testing::SourceFolder() / "testdata" / "mh01_pallet.csv");
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    std::string cell;
    std::getline(cells, cell, ',');
    Outline& outline = outlines[Timestamp{std::stoll(cell)}].emplace_back();
    std::getline(cells, outline.board, ',');
    std::vector<double> values;
    while (std::getline(cells, cell, ','))
      values.push_back(std::stod(cell));
    for (std::size_t i = 0; i + 1 < values.size(); i += 2)
      outline.px.push_back({values[i], values[i + 1]});
  }
  return outlines;
}

/// Points of the mesh on one board.
struct Board {
  std::vector<Vector3d> p_W;
  int num_rays = 0;
  double nearest_m = 1e9, farthest_m = 0;

  double Rms() const {
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : p_W)
      mean += p / static_cast<double>(p_W.size());
    Matrix3d scatter = Matrix3d::Zero();
    for (const Vector3d& p : p_W)
      scatter += (p - mean) * (p - mean).transpose() / static_cast<double>(p_W.size());
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter);
    return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  }
};

/// What the camera sees of the mesh inside the outline, from min_m away on.
Board Look(const MeshQuery& mesh,
           const CameraModel& camera,
           const SE3& T_WC,
           const Outline& outline,
           double min_m) {
  Board board;
  for (double y = 0; y < camera.height(); y += kStep_px) {
    for (double x = 0; x < camera.width(); x += kStep_px) {
      const auto ray = camera.Unproject({x, y});
      if (!outline.Contains({x, y}) || !ray) continue;
      ++board.num_rays;
      const Vector3d direction_W = T_WC.q * (*ray / ray->z());
      const auto hit = mesh.FirstAlongRay(T_WC.p, direction_W, kRange_m);
      if (!hit || hit->distance_m < min_m) continue;
      board.p_W.push_back(hit->p_W);
      board.nearest_m = std::min(board.nearest_m, hit->distance_m);
      board.farthest_m = std::max(board.farthest_m, hit->distance_m);
    }
  }
  return board;
}

/// What one keyframe knows of the boards; lengths in metres, in the left camera's frame.
struct View {
  double since_start_s = 0;
  int num_planes = 0;
  std::vector<Board> boards, boards_beyond_1m;  // in the order of the outlines
  std::vector<Plane> planes_C;                  // likewise
};

/// Flies from start_s on and tells of every keyframe. Boards are looked for in the first one at or
/// after the stamp of each image with outlines.
template <class Observe>
void Fly(AslDataset& data, Formulation pipeline, double start_s, const Observe& observe) {
  const auto outlines = ReadOutlines();
  ASSERT_EQ(outlines.size(), 3u);
  VioOptions options;
  options.pipeline = pipeline;
  VioPipeline vio(data.rig(), data.imu_noise(), options);
  const CameraModel& camera = data.rig().cameras[0];
  const Timestamp begin = data.frames().front().t + FromSeconds(start_s);
  auto next = outlines.lower_bound(begin);
  std::optional<SE3> T_WC;  // of the outlines' image
  std::size_t next_imu = 0;
  for (std::size_t i = 0; i < data.frames().size() && next != outlines.end(); ++i) {
    StereoFrame frame;
    frame.t = data.frames()[i].t;
    if (frame.t < begin) continue;
    ASSERT_EQ(data.ReadPair(i, frame.left, frame.right), "");
    const Timestamp until = frame.t + data.rig().time_offset;
    while (next_imu < data.imu().size() && (next_imu == 0 || data.imu()[next_imu - 1].t <= until))
      vio.AddImu(data.imu()[next_imu++]);
    const VioOutput output = vio.AddStereo(frame);
    if (output.t == next->first && output.has_pose) T_WC = output.state.T_WB * data.rig().T_BC[0];
    if (!output.mesh) continue;
    View view;
    view.since_start_s = ToSeconds(output.t - begin);
    view.num_planes = output.num_planes;
    if (T_WC) {
      for (const PlaneEstimate& plane : output.snapshot->planes) {
        const Plane& plane_W = plane.plane_W;
        view.planes_C.push_back(
            {T_WC->q.conjugate() * plane_W.n, -plane_W.SignedDistance(T_WC->p)});
      }
      const MeshQuery mesh(output.mesh->mesh);
      for (const Outline& outline : next->second) {
        view.boards.push_back(Look(mesh, camera, *T_WC, outline, 0));
        view.boards_beyond_1m.push_back(Look(mesh, camera, *T_WC, outline, 1));
        for (Vector3d& p : view.boards.back().p_W)
          p = T_WC->q.conjugate() * (p - T_WC->p);
      }
      T_WC.reset();
      ++next;
    }
    observe(view);
  }
}

TEST(PalletFlatness, BoardsAreFlatInTheHorizonMesh) {
  const auto folder = testing::DataDir("euroc_mh01_handheld");
  if (!folder) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");
  int num_boards = 0;
  AslDataset data(*folder);
  Fly(data, Formulation::kS, 0, [&](const View& view) {
    for (std::size_t k = 0; k < view.boards.size(); ++k) {
      const Board &all = view.boards[k], &far = view.boards_beyond_1m[k];
      ASSERT_GT(all.num_rays, 100);
      EXPECT_GT(all.p_W.size(), 200u);
      EXPECT_LE(all.Rms(), 0.02);
      std::printf(
          "board: %zu of %d rays, %.2f to %.2f m away, %.1f mm RMS; %zu beyond 1 m, %.1f mm\n",
          all.p_W.size(),
          all.num_rays,
          all.nearest_m,
          all.farthest_m,
          1e3 * all.Rms(),
          far.p_W.size(),
          far.p_W.size() < 10 ? 0.0 : 1e3 * far.Rms());
      ++num_boards;
    }
  });
  EXPECT_EQ(num_boards, 11);
}

// Median of the distances, in metres: at the rims of a board the mesh goes down to the ground.
double MedianDistance(const Plane& plane, const std::vector<Vector3d>& points) {
  std::vector<double> distances;
  for (const Vector3d& p : points)
    distances.push_back(std::abs(plane.SignedDistance(p)));
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

// What the boards have in common is one plane, soon and to the end. Where the boards are is told by
// a run that knows no planes.
TEST(PalletPlane, IsFoundWithinThreeSecondsAndGoesThroughTheBoards) {
  const auto folder = testing::DataDir("euroc_mh01_handheld");
  if (!folder) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");
  AslDataset data(*folder);
  std::vector<View> seen;
  const auto with_boards = [](std::vector<View>& views) {
    return [&views](const View& view) {
      if (!view.boards.empty()) views.push_back(view);
    };
  };
  Fly(data, Formulation::kS, 0, with_boards(seen));
  ASSERT_EQ(seen.size(), 3u);
  for (const double start_s : {0.0, 0.35, 0.7}) {
    std::vector<View> views;
    double found_after_s = 1e9;
    int most_planes = 0;
    Fly(data, Formulation::kSPR, start_s, [&](const View& view) {
      if (view.num_planes > 0) found_after_s = std::min(found_after_s, view.since_start_s);
      most_planes = std::max(most_planes, view.num_planes);
      with_boards(views)(view);
    });
    EXPECT_LE(found_after_s, 3) << start_s;
    EXPECT_EQ(most_planes, 1) << start_s;
    ASSERT_GE(views.size(), 2u);
    std::printf("start %.2f s: a plane after %.2f s; boards from it [mm]:", start_s, found_after_s);
    for (std::size_t back = 1; back <= 2; ++back) {
      ASSERT_EQ(views[views.size() - back].planes_C.size(), 1u) << start_s;
      const Plane& plane_C = views[views.size() - back].planes_C.front();
      for (const Board& board : seen[seen.size() - back].boards) {
        const double distance_m = MedianDistance(plane_C, board.p_W);
        EXPECT_LE(distance_m, 0.01) << start_s;
        std::printf(" %.1f", 1e3 * distance_m);
      }
    }
    std::printf("\n");
  }
}

}  // namespace
}  // namespace facet
