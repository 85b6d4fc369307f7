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
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/eval/run_evaluation.h"
#include "facet/io/planes_file.h"
#include "facet/io/ply_reader.h"
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

  fs::path Run(const std::string& pipeline, const std::string& arguments = "") {
    const fs::path out = folder_ / pipeline;
    const std::string command = std::string(FACET_PROGRAM) + " run '" + sequence_->string() +
                                "' --pipeline " + pipeline + " --duration 12 --quiet --out '" +
                                out.string() + "' " + arguments;
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return out;
  }

  // One per test: they run at the same time.
  const fs::path folder_ = testing::BuildFolder() / "pipelines_test" /
                           ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::optional<fs::path> sequence_;
};

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

// In the end: planes have become part of others by then, or turned out to be none.
TEST_F(PipelinesTest, EveryPlaneOfTheMeshesIsListed) {
  const fs::path out = Run("SPR");
  std::map<int, EstimatedPlane> listed;
  for (const EstimatedPlane& plane : ReadEstimatedPlanes(out / "planes.csv"))
    listed[static_cast<int>(plane.id)] = plane;
  for (const char* name : {"mesh.ply", "map.ply"}) {
    const TriangleMesh mesh = ReadPly(out / name);
    std::map<int, std::vector<double>> distances_m;  // of corners from their plane
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const int id = mesh.plane_ids[f];
      if (id < 0) continue;
      ASSERT_TRUE(listed.contains(id)) << name << ": plane " << id;
      for (const int corner : mesh.faces[f]) {
        const EstimatedPlane& plane = listed[id];
        distances_m[id].push_back(std::abs(plane.n_W.dot(mesh.vertices[corner]) - plane.d_W));
      }
    }
    EXPECT_FALSE(distances_m.empty()) << name;
    for (auto& [id, distances] : distances_m) {
      const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
      std::nth_element(distances.begin(), middle, distances.end());
      EXPECT_LT(*middle, 0.05) << name << ": plane " << id << " [m]";
    }
  }
}

TEST_F(PipelinesTest, AFullMapIsReportedOnce) {
  const fs::path out = Run("S", "--set mesh.map.max_memory_mb=1 --threads 2");
  const auto summary = nlohmann::json::parse(std::ifstream(out / "summary.json"));
  EXPECT_TRUE(summary["map_is_full"].get<bool>());
  EXPECT_LE(summary["map_memory_mb"].get<double>(), 1);
  int num_warnings = 0;
  for (const auto& warning : summary["warnings"])
    num_warnings +=
        warning.get<std::string>().find("mesh.map.max_memory_mb=1;") != std::string::npos;
  EXPECT_EQ(num_warnings, 1) << summary["warnings"];
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
