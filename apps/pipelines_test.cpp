// SPDX-License-Identifier: BSD-2-Clause
// The three pipelines on a recording: SPR finds the room's planes, S and SP have none, and all of
// them follow the path.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/base/median.h"
#include "facet/eval/run_evaluation.h"
#include "facet/io/planes_file.h"
#include "facet/io/ply_reader.h"
#include "facet/mesh/far_surfaces.h"
#include "facet/testing/data_dir.h"
#include "facet/testing/folders.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

class PipelinesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    sequence_ = testing::DataDir("rendered_room");
    if (!sequence_) GTEST_SKIP() << testing::MissingData("rendered_room");
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path Run(const std::string& pipeline, const std::string& arguments = "--duration 12") {
    const fs::path out = folder_ / pipeline;
    const std::string command = std::string(FACET_PROGRAM) + " run '" + sequence_->string() +
                                "' --pipeline " + pipeline + " --quiet --out '" + out.string() +
                                "' " + arguments;
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return out;
  }

  // One per test: they run at the same time.
  const fs::path folder_ = testing::BuildFolder() / "pipelines_test" /
                           ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::optional<fs::path> sequence_;
};

// Every plane of the mesh is in the list, and half of its faces' corners are within the gate of
// what is 6 m away (5 cm up to 3 m): the room is not larger.
void ExpectFacesOnTheirPlanes(const TriangleMesh& mesh,
                              const std::map<int, EstimatedPlane>& listed,
                              const std::string& name) {
  ASSERT_EQ(mesh.plane_ids.size(), mesh.faces.size()) << name;
  std::map<int, std::vector<double>> distances_m;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const int id = mesh.plane_ids[f];
    if (id < 0) continue;
    const auto plane = listed.find(id);
    ASSERT_NE(plane, listed.end()) << name << ": plane " << id;
    for (const int corner : mesh.faces[f]) {
      const double along = plane->second.n_W.dot(mesh.vertices[corner]);
      distances_m[id].push_back(std::abs(along - plane->second.d_W));
    }
  }
  EXPECT_FALSE(distances_m.empty()) << name;
  for (auto& [id, distances] : distances_m)
    EXPECT_LT(*Median(distances), 0.05 * LengthScale(6)) << name << ": plane " << id << " [m]";
}

TEST_F(PipelinesTest, SprFindsPlanesThatAreThere) {
  const fs::path out = Run("SPR");
  const std::vector<EstimatedPlane> planes = ReadEstimatedPlanes(out / "planes.csv");
  ASSERT_GE(planes.size(), 2u);
  EXPECT_TRUE(std::any_of(planes.begin(), planes.end(), [](const EstimatedPlane& plane) {
    return plane.label == "floor" && plane.orientation == "horizontal" && plane.area_m2 > 5 &&
           plane.n_W.z() > 0.999;
  }));
  EvaluationOptions options;
  options.judge_mesh = false;
  const RunEvaluation evaluation = EvaluateRun(out, LoadGroundTruth(*sequence_), options);
  ASSERT_TRUE(evaluation.planes);
  EXPECT_GE(evaluation.planes->precision.value_or(0), 0.8);
  EXPECT_LE(evaluation.planes->normal_error_deg_median.value_or(90), 2.0);
  EXPECT_LE(evaluation.causal.ate_m.rmse, 0.004) << "m";
}

// What became part of another plane, or turned out to be none, has another id in the meshes of the
// end, or none. Within these two runs there are such planes; the meshes on the way show them.
TEST_F(PipelinesTest, EveryPlaneOfTheLastMeshesIsListed) {
  std::size_t num_vanished = 0;
  for (const char* start : {"0.15", "0.6"}) {
    const fs::path out = Run("SPR", std::string("--mesh-every 1 --start ") + start);
    std::map<int, EstimatedPlane> listed;
    for (const EstimatedPlane& plane : ReadEstimatedPlanes(out / "planes.csv"))
      EXPECT_TRUE(listed.emplace(plane.id, plane).second) << "plane " << plane.id << " twice";
    std::set<int> vanished;
    for (const auto& file : fs::directory_iterator(out / "meshes")) {
      for (const int id : ReadPly(file.path()).plane_ids) {
        if (id >= 0 && !listed.contains(id)) vanished.insert(id);
      }
    }
    num_vanished += vanished.size();
    for (const char* name : {"mesh.ply", "map.ply"})
      ExpectFacesOnTheirPlanes(ReadPly(out / name), listed, name);
  }
  EXPECT_GT(num_vanished, 0U) << "choose runs in which a plane ends";
}

TEST_F(PipelinesTest, AFullMapIsReportedOnce) {
  const fs::path out = Run("S", "--duration 12 --set mesh.map.max_memory_mb=1 --threads 2");
  const auto summary = nlohmann::json::parse(std::ifstream(out / "summary.json"));
  EXPECT_TRUE(summary["map_is_full"].get<bool>());
  EXPECT_LE(summary["map_memory_mb"].get<double>(), 1);
  int num_warnings = 0;
  for (const auto& warning : summary["warnings"])
    num_warnings +=
        warning.get<std::string>().find("mesh.map.max_memory_mb=1;") != std::string::npos;
  EXPECT_EQ(num_warnings, 1) << summary["warnings"];
}

TEST_F(PipelinesTest, PlanesWithoutAMeshAreNotMissedSilently) {
  const auto num_warnings = [](const fs::path& out) {
    const auto summary = nlohmann::json::parse(std::ifstream(out / "summary.json"));
    return std::count_if(
        summary["warnings"].begin(), summary["warnings"].end(), [](const auto& warning) {
          return warning.template get<std::string>().starts_with("mesh.enabled=false: ");
        });
  };
  EXPECT_EQ(num_warnings(Run("SPR", "--duration 3 --set mesh.enabled=false")), 1);
  EXPECT_EQ(num_warnings(Run("S", "--duration 3 --set mesh.enabled=false")), 0);
  EXPECT_EQ(num_warnings(Run("SPR", "--duration 3")), 0);
}

std::string TrajectoryOf(const fs::path& out) {
  std::ostringstream text;
  text << std::ifstream(out / "trajectory.tum").rdbuf();
  return text.str();
}

TEST_F(PipelinesTest, TrajectoriesDifferWherePlanesAreSeen) {
  const std::string s = TrajectoryOf(Run("S")), sp = TrajectoryOf(Run("SP")),
                    spr = TrajectoryOf(Run("SPR"));
  EXPECT_NE(s, sp);
  EXPECT_NE(s, spr);
  EXPECT_NE(sp, spr);
}

TEST_F(PipelinesTest, TrajectoriesAreTheSameWhereNoPlaneIsFound) {
  const std::string none = "--duration 6 --set regularities.detection.min_faces=1000";
  const std::string s = TrajectoryOf(Run("S", none));
  EXPECT_GT(std::count(s.begin(), s.end(), '\n'), 100);
  EXPECT_EQ(s, TrajectoryOf(Run("SP", none)));
  EXPECT_EQ(s, TrajectoryOf(Run("SPR", none)));
}

TEST_F(PipelinesTest, TheOthersHaveNone) {
  for (const char* pipeline : {"S", "SP"}) {
    const fs::path out = Run(pipeline);
    EXPECT_FALSE(fs::exists(out / "planes.csv")) << pipeline;
    EXPECT_TRUE(fs::exists(out / "trajectory.tum")) << pipeline;
  }
}

}  // namespace
}  // namespace facet
