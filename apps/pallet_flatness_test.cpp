// SPDX-License-Identifier: BSD-2-Clause
// The boards of a pallet in a recorded sequence are flat, and so must be the horizon mesh on them.
// Their outlines in some images were drawn by hand (testdata/mh01_pallet.csv).
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
      const auto ray = camera.Undistort({x, y});
      if (!outline.Contains({x, y}) || !ray) continue;
      ++board.num_rays;
      const Vector3d direction_W = T_WC.q * Vector3d(ray->xy.x(), ray->xy.y(), 1);
      const auto hit = mesh.FirstAlongRay(T_WC.p, direction_W, kRange_m);
      if (!hit || hit->distance_m < min_m) continue;
      board.p_W.push_back(hit->p_W);
      board.nearest_m = std::min(board.nearest_m, hit->distance_m);
      board.farthest_m = std::max(board.farthest_m, hit->distance_m);
    }
  }
  return board;
}

TEST(PalletFlatness, BoardsAreFlatInTheHorizonMesh) {
  const auto folder = testing::DataDir("euroc_mh01_handheld");
  if (!folder) GTEST_SKIP() << testing::MissingData("euroc_mh01_handheld");
  const auto outlines = ReadOutlines();
  ASSERT_EQ(outlines.size(), 3u);
  AslDataset data(*folder);
  VioOptions options;
  options.pipeline = Formulation::kS;
  VioPipeline vio(data.rig(), data.imu_noise(), options);
  auto next = outlines.begin();
  std::optional<SE3> T_WC;  // of the outlines' image
  int num_boards = 0;
  std::size_t next_imu = 0;
  for (std::size_t i = 0; i < data.frames().size() && next != outlines.end(); ++i) {
    StereoFrame frame;
    frame.t = data.frames()[i].t;
    ASSERT_EQ(data.ReadPair(i, frame.left, frame.right), "");
    const Timestamp until = frame.t + data.rig().time_offset;
    while (next_imu < data.imu().size() && (next_imu == 0 || data.imu()[next_imu - 1].t <= until))
      vio.AddImu(data.imu()[next_imu++]);
    const VioOutput output = vio.AddStereo(frame);
    if (output.t == next->first && output.has_pose) T_WC = output.state.T_WB * data.rig().T_BC[0];
    if (!T_WC || !output.mesh) continue;  // the first keyframe from there on
    const MeshQuery mesh(output.mesh->mesh);
    for (const Outline& outline : next->second) {
      const Board all = Look(mesh, data.rig().cameras[0], *T_WC, outline, 0);
      const Board far = Look(mesh, data.rig().cameras[0], *T_WC, outline, 1);
      ASSERT_GT(all.num_rays, 100);
      EXPECT_GT(all.p_W.size(), 200u) << outline.board;
      EXPECT_LE(all.Rms(), 0.02) << outline.board;
      std::printf(
          "board %s: %zu of %d rays, %.2f to %.2f m away, %.1f mm RMS; "
          "%zu beyond 1 m, %.1f mm\n",
          outline.board.c_str(),
          all.p_W.size(),
          all.num_rays,
          all.nearest_m,
          all.farthest_m,
          1e3 * all.Rms(),
          far.p_W.size(),
          far.p_W.size() < 10 ? 0.0 : 1e3 * far.Rms());
      ++num_boards;
    }
    T_WC.reset();
    ++next;
  }
  EXPECT_EQ(num_boards, 11);
}

}  // namespace
}  // namespace facet
