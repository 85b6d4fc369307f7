// SPDX-License-Identifier: BSD-2-Clause
// A flight that returns to places, with and without recognising them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/io/csv_reader.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

class LoopsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const ProgramRun made = RunFacet(
        "simulate --quiet --scene room --seed 5 --duration 24 --set image.rays_per_pixel=1 --set "
        "image.max_rays_per_pixel=2 --out " +
        Path("room"));
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Read(const std::string& name) const { return ReadText(folder_ / name); }

  void Run(const std::string& out, const std::string& options) {
    const ProgramRun run = RunFacet("run " + Path("room") +
                                    " --quiet --set mesh.enabled=false "
                                    "--pipeline S --out " +
                                    Path(out) + " " + options);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  TempFolder folder_;
};

TEST_F(LoopsTest, PlacesAreRecognisedAndTheOdometryStaysTheSame) {
  Run("without", "");
  Run("with", "--set loops.enabled=true");
  Run("threads", "--set loops.enabled=true --threads 2");
  for (const char* file : {"/trajectory.tum", "/keyframes.tum", "/states.csv"})
    EXPECT_TRUE(Read(std::string("without") + file) == Read(std::string("with") + file)) << file;
  for (const char* file : {"/trajectory_map.tum", "/trajectory_final.tum", "/closures.csv"}) {
    EXPECT_FALSE(std::filesystem::exists(Path("without") + file)) << file;
    const std::string text = Read(std::string("with") + file);
    EXPECT_FALSE(text.empty()) << file;
    EXPECT_TRUE(text == Read(std::string("threads") + file)) << file;
  }
  EXPECT_FALSE(Read("with/trajectory_map.tum") == Read("with/trajectory.tum")) << "nothing moved";
  EXPECT_FALSE(Read("with/trajectory_final.tum") == Read("with/trajectory_map.tum"));
  const auto summary = nlohmann::json::parse(Read("with/summary.json"));
  EXPECT_GT(summary["loops"]["places"], 5);
  EXPECT_GT(summary["loops"]["closures"], 3) << Read("with/closures.csv");
  const auto ate_mm = [&](const std::string& trajectory) {
    const ProgramRun judged = RunFacet("evaluate " + Path(trajectory) + " --truth " + Path("room") +
                                       " --report " + Path("report"));
    EXPECT_EQ(judged.exit_code, 0) << judged.err;
    const std::string key = "ATE rmse [m]";
    return 1e3 * std::stod(judged.out.substr(judged.out.find(key) + key.size()));
  };
  EXPECT_LT(ate_mm("with/trajectory_map.tum"), 1.1 * ate_mm("with/trajectory.tum") + 0.5);
  EXPECT_LT(ate_mm("with/trajectory_final.tum"), 1.1 * ate_mm("with/trajectory.tum") + 0.5);
}

}  // namespace
}  // namespace facet
