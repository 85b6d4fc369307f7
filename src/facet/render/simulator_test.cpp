// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/simulator.h"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "facet/io/asl_dataset.h"
#include "facet/io/errors.h"
#include "facet/io/trajectory_file.h"
#include "facet/render/clearance.h"
#include "facet/render/scene_source.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// Small images, few of them.
class SimulatorTest : public ::testing::Test {
 protected:
  SimulatorTest() {
    for (int c = 0; c < 2; ++c) {
      WriteText(folder_ / "rig" / ("cam" + std::to_string(c)) / "sensor.yaml", TestCameraYaml(c));
    }
    WriteText(folder_ / "rig" / "imu0" / "sensor.yaml", TestImuYaml());
    request_.calibration = (folder_ / "rig").string();
    request_.duration_s = 0.1;
    request_.options.truth.max_points = 20000;
  }

  fs::path Simulate(const std::string& name) { return SimulateAll({name}).front(); }

  /// One noise realisation for each name.
  std::vector<fs::path> SimulateAll(const std::vector<std::string>& names) {
    std::vector<fs::path> folders;
    for (const std::string& name : names) {
      folders.push_back(folder_ / name);
      fs::create_directory(folders.back());
    }
    report_ = facet::Simulate(request_, folders, [](int, int) { return true; });
    return folders;
  }

  TempFolder folder_;
  SimulationRequest request_;
  SimulationReport report_;
};

std::map<std::string, std::string> ReadAll(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      files[fs::relative(entry.path(), folder).string()] = ReadText(entry.path());
  }
  return files;
}

TEST_F(SimulatorTest, SameRequestSameBytesWithAnyNumberOfThreads) {
  for (const char* scene : {"room", "clutter"}) {
    request_.scene = scene;
    request_.num_threads = 1;
    const auto one = ReadAll(Simulate(std::string(scene) + "-one"));
    request_.num_threads = 3;
    const auto three = ReadAll(Simulate(std::string(scene) + "-three"));
    ASSERT_EQ(one.size(), three.size());
    for (const auto& [name, bytes] : one)
      EXPECT_TRUE(bytes == three.at(name)) << scene << ": " << name << " differs";
  }
}

TEST_F(SimulatorTest, AnotherSeedIsAnotherFlight) {
  const auto a = ReadAll(Simulate("a"));
  request_.seed = 2;
  const auto b = ReadAll(Simulate("b"));
  EXPECT_NE(a.at("truth/mesh.ply"), b.at("truth/mesh.ply"));
  EXPECT_NE(a.at("mav0/imu0/data.csv"), b.at("mav0/imu0/data.csv"));
}

TEST_F(SimulatorTest, NoiseRealisationsDifferInNoiseOnly) {
  const auto alone = ReadAll(Simulate("alone"));
  const auto folders = SimulateAll({"first", "second", "third"});
  const auto first = ReadAll(folders[0]), second = ReadAll(folders[1]), third = ReadAll(folders[2]);
  EXPECT_EQ(alone, first);
  ASSERT_EQ(first.size(), second.size());
  for (const auto& [name, bytes] : first) {
    const bool is_noisy = name.ends_with(".png") || name == "mav0/imu0/data.csv" ||
                          name == "mav0/state_groundtruth_estimate0/data.csv";  // for the biases
    EXPECT_EQ(bytes == second.at(name), !is_noisy) << name;
    EXPECT_EQ(bytes == third.at(name), !is_noisy) << name;
    EXPECT_EQ(second.at(name) == third.at(name), !is_noisy) << name;
  }
  const Trajectory truth = ReadTrajectory(FindTruth(folders[0])),
                   other = ReadTrajectory(FindTruth(folders[1]));
  EXPECT_EQ(truth.poses.back().T_WB.p, other.poses.back().T_WB.p);
}

TEST_F(SimulatorTest, WritesASequenceThatTheReadersAccept) {
  const fs::path sequence = Simulate("sequence");
  EXPECT_TRUE(report_.is_complete);
  EXPECT_GE(report_.min_clearance_m, 0.3);
  AslDataset dataset(sequence);
  EXPECT_TRUE(dataset.warnings().empty());
  EXPECT_EQ(dataset.frames().size(), 3);
  cv::Mat left, right;
  EXPECT_EQ(dataset.ReadPair(0, left, right), "");
  EXPECT_EQ(left.size(), right.size());
  const Trajectory truth = ReadTrajectory(FindTruth(sequence));
  EXPECT_LE(truth.poses.front().t, dataset.frames().front().t);
  EXPECT_GE(truth.poses.back().t, dataset.frames().back().t);
  const auto planes = Lines(ReadText(sequence / "truth" / "planes.csv"));
  EXPECT_EQ(planes.front(),
            "#plane,nx,ny,nz,d [m] (n.x = d),area [m^2],seen area [m^2],label,seen_s [s]");
  EXPECT_EQ(planes[1].substr(0, 8), "0,0,0,1,");  // the floor
  EXPECT_NE(planes[1].find(",floor,"), std::string::npos);
}

TEST_F(SimulatorTest, AnImuWithoutNoiseSaysSo) {
  const ImuNoise noisy = AslDataset(Simulate("noisy")).imu_noise();
  request_.options.imu.add_noise = false;
  const ImuNoise clean = AslDataset(Simulate("clean")).imu_noise();
  EXPECT_DOUBLE_EQ(clean.gyro_noise, 0.05 * noisy.gyro_noise);
  EXPECT_DOUBLE_EQ(clean.accel_noise, 0.05 * noisy.accel_noise);
  EXPECT_DOUBLE_EQ(clean.gyro_walk, 0.05 * noisy.gyro_walk);
  EXPECT_DOUBLE_EQ(clean.accel_walk, 0.05 * noisy.accel_walk);
}

/// In how many of the images something of a bench is ahead, at most 1.2 m away.
double ShareWithABenchNear(const Motion& motion, const SceneMesh& mesh) {
  std::vector<Vector3d> corners_W;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.parts[mesh.triangles[i].part].label == "bench")
      corners_W.emplace_back(mesh.corner(i, 0).cast<double>());
  }
  double count = 0;
  for (const Timestamp t : motion.frames) {
    const SE3 T_BW = motion.trajectory.At(t).state.T_WB.Inverse();
    count += std::any_of(corners_W.begin(), corners_W.end(), [&](const Vector3d& corner_W) {
      const Vector3d p_B = T_BW * corner_W;
      return p_B.norm() < 1.2 && p_B.z() > 0.6 * p_B.norm();
    });
  }
  return count / static_cast<double>(motion.frames.size());
}

/// How far the things that are put near reach through a wall.
double WorstDepthInWalls(const SceneMesh& mesh) {
  double worst = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::string& label = mesh.parts[mesh.triangles[i].part].label;
    if (label != "bench" && label != "rail" && label != "net" && label != "heap") continue;
    for (const ScenePart& part : mesh.parts) {
      if (part.label != "wall") continue;
      const Vector3d p_W = mesh.corner(i, 0).cast<double>();
      worst = std::max(worst, part.d_W - part.n_W.dot(p_W));
    }
  }
  return worst;
}

TEST_F(SimulatorTest, ThingsAreNearIfTheCamerasAreHeldOrIfAsked) {
  const auto share_near = [&](const char* flight, double near_m, std::uint64_t seed) {
    request_.trajectory = flight;
    request_.options.near_things_m = near_m;
    request_.duration_s = 10;
    const Seeds seeds(seed);
    MaterialLibrary materials(seeds.textures, {});
    const Motion motion = MakeMotion(request_, seeds);
    const SceneMesh mesh = MakeScene(request_, motion, seeds, materials).mesh;
    EXPECT_EQ(WorstDepthInWalls(mesh), 0) << flight << ' ' << near_m << ' ' << seed;
    return ShareWithABenchNear(motion, mesh);
  };
  double held = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    held += share_near("hand-held", -1, seed) / 3;
    EXPECT_EQ(share_near("hand-held", 0, seed), 0);
    EXPECT_EQ(share_near("fast", -1, seed), 0);
    EXPECT_GT(share_near("fast", 0.6, seed), 0);
    share_near("aggressive", 3, seed);
  }
  EXPECT_GT(held, 0.3);
  request_.scene = "corridor";
  EXPECT_THROW(share_near("fast", 1, 1), ConfigError);
}

TEST_F(SimulatorTest, ClutterHasNoPlane) {
  request_.scene = "clutter";
  const fs::path sequence = Simulate("clutter");
  EXPECT_EQ(report_.num_planes, 0);
  EXPECT_EQ(Lines(ReadText(sequence / "truth" / "planes.csv")).size(), 1);
}

/// Distance of what the middle of the left image shows, sorted, over the flight.
std::vector<double> DepthsAhead(const Motion& motion, const SceneMesh& mesh) {
  const RayScene rays(mesh);
  std::vector<double> depths;
  for (const Timestamp t : motion.frames) {
    const SE3 T_WB = motion.trajectory.At(t).state.T_WB;
    if (const auto hit = rays.Cast(T_WB.p, T_WB.q * Vector3d::UnitZ()))
      depths.push_back(hit->distance);
  }
  std::sort(depths.begin(), depths.end());
  return depths;
}

TEST_F(SimulatorTest, HallAndFacadeAreLarge) {
  const auto median_depth = [&](const char* scene) {
    request_.scene = scene;
    request_.trajectory = "fast";
    request_.duration_s = 60;
    const Seeds seeds(1);
    MaterialLibrary materials(seeds.textures, {});
    const Motion motion = MakeMotion(request_, seeds);
    const std::vector<double> depths =
        DepthsAhead(motion, MakeScene(request_, motion, seeds, materials).mesh);
    EXPECT_GT(depths.size(), 0.8 * static_cast<double>(motion.frames.size())) << scene;
    return depths[depths.size() / 2];
  };
  EXPECT_LT(median_depth("office"), 5);
  EXPECT_GT(median_depth("hall"), 6);
  EXPECT_GT(median_depth("facade"), 10);
}

TEST_F(SimulatorTest, TheHallIsLevelInOneHalfOnly) {
  request_.scene = "hall";
  const Seeds seeds(1);
  MaterialLibrary materials(seeds.textures, {});
  const Motion motion = MakeMotion(request_, seeds);
  const SceneMesh mesh = MakeScene(request_, motion, seeds, materials).mesh;
  const auto num_planar = [&](const char* label) {
    return std::count_if(mesh.parts.begin(), mesh.parts.end(), [&](const ScenePart& part) {
      return part.label == label && part.is_planar;
    });
  };
  EXPECT_EQ(num_planar("floor"), 1);
  EXPECT_EQ(num_planar("ground"), 0);
  EXPECT_GT(num_planar("machine"), 100);
}

TEST_F(SimulatorTest, NothingComesNearerThanAllowedInAnyScene) {
  for (const char* scene_name : {"room", "corridor", "clutter", "office", "hall", "facade"}) {
    for (const char* flight : {"gentle", "fast", "aggressive", "hover", "hand-held", "walk"}) {
      for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        request_.scene = scene_name;
        request_.trajectory = flight;
        request_.duration_s = 30;
        const Seeds seeds(seed);
        MaterialLibrary materials(seeds.textures, {});
        const Motion motion = MakeMotion(request_, seeds);
        const SceneModel scene = MakeScene(request_, motion, seeds, materials);
        const RayScene rays(scene.mesh);
        const Clearance clearance = CheckClearance(
            scene.mesh, rays, motion.trajectory, motion.imu_begin, motion.imu_end, 0.3);
        EXPECT_EQ(clearance.problem, "") << scene_name << ' ' << flight << ' ' << seed;
      }
    }
  }
}

TEST_F(SimulatorTest, StoppedByTheObserver) {
  request_.num_threads = 1;
  int calls = 0;
  const std::vector<fs::path> folders = {folder_ / "stopped"};
  fs::create_directory(folders.front());
  const auto report = facet::Simulate(request_, folders, [&](int, int) { return ++calls < 1; });
  EXPECT_FALSE(report.is_complete);
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace facet
