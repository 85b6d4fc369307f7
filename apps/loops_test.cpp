// SPDX-License-Identifier: BSD-2-Clause
// A flight that returns to places, with and without recognising them.
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/base/types.h"
#include "facet/io/csv_reader.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

/// Positions by stamp.
std::map<std::string, Vector3d> Positions(const std::string& tum) {
  std::map<std::string, Vector3d> positions;
  std::istringstream lines(tum);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string stamp;
    Vector3d p;
    if (words >> stamp >> p.x() >> p.y() >> p.z()) positions[stamp] = p;
  }
  return positions;
}

class LoopsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    const ProgramRun made = RunFacet(
        "simulate --quiet --scene room --seed 5 --duration 24 --set image.rays_per_pixel=1 --set "
        "image.max_rays_per_pixel=2 --out " +
        Path("room"));
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string Path(const std::string& name) { return (*folder_ / name).string(); }
  static std::string Read(const std::string& name) { return ReadText(*folder_ / name); }

  static void Run(const std::string& out, const std::string& options) {
    const ProgramRun run = RunFacet("run " + Path("room") +
                                    " --quiet --set mesh.enabled=false "
                                    "--pipeline S --out " +
                                    Path(out) + " " + options);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  static inline TempFolder* folder_ = nullptr;
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

TEST_F(LoopsTest, ALaterRunIsFoundInTheSavedMapOrSaysThatItIsNot) {
  const std::string map = Path("map");
  Run("first", "--duration 14 --save-map " + map);
  EXPECT_TRUE(std::filesystem::exists(Path("map/places.facetmap")));
  const ProgramRun info = RunFacet("map info " + map);
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_THAT(info.out, ::testing::HasSubstr("1 runs"));
  EXPECT_THAT(info.out, ::testing::HasSubstr("closures within it, 0 with runs before"));
  EXPECT_EQ(RunFacet("map export " + map + " " + Path("points.ply")).exit_code, 0);
  EXPECT_GT(Read("points.ply").size(), 1000u);
  // The same room from another moment on, whose world begins elsewhere.
  Run("later", "--start 6 --duration 6 --map " + map);
  const auto known = nlohmann::json::parse(Read("later/summary.json"))["loops"]["known_map"];
  ASSERT_TRUE(known["localised_s"].is_number()) << known;
  EXPECT_LT(known["localised_s"], 3.0);
  EXPECT_EQ(known["ambiguous"], false);
  // Both trajectories are in the map of the first run.
  const auto first = Positions(Read("first/trajectory_final.tum"));
  int num = 0;
  for (const auto& [stamp, p] : Positions(Read("later/trajectory_map.tum"))) {
    if (!first.contains(stamp)) continue;
    ++num;
    EXPECT_LT((p - first.at(stamp)).norm(), 0.03) << stamp;
  }
  EXPECT_GT(num, 40);
  // Poses from before it was found are in no map.
  EXPECT_LT(Read("later/trajectory_map.tum").size(), Read("later/trajectory.tum").size());

  // Too short to be sure of anything: the map is saved as it was.
  const std::string before = Read("map/places.facetmap");
  const ProgramRun run = RunFacet("run " + Path("room") +
                                  " --quiet --set mesh.enabled=false --pipeline S --duration 0.5 "
                                  "--start 18 --map " +
                                  map + " --save-map " + map + " --out " + Path("short"));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, ::testing::HasSubstr("was not found in the map"));
  const ProgramRun over = RunFacet("run " + Path("room") + " --save-map " + map);
  EXPECT_EQ(over.exit_code, 2);
  EXPECT_THAT(over.err, ::testing::HasSubstr("has a map already"));
  EXPECT_TRUE(Read("map/places.facetmap") == before);
  EXPECT_EQ(Read("short/trajectory_map.tum").find("14"), std::string::npos) << "a pose in the map";
}

TEST_F(LoopsTest, MapsOfTwoRunsBecomeOneAndALaterRunIsFoundInIt) {
  Run("one", "--duration 12 --save-map " + Path("one-map"));
  Run("two", "--start 9 --save-map " + Path("two-map"));
  const std::string both = Path("both-map");
  const ProgramRun merged =
      RunFacet("map merge " + Path("one-map") + " " + Path("two-map") + " " + both);
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_THAT(merged.out, ::testing::HasSubstr("2 runs"));
  EXPECT_EQ(RunFacet("map merge " + Path("one-map") + " " + Path("two-map") + " " + both).exit_code,
            2)
      << "there is a map already";

  // Where the second run was in the world of the first one: by its own poses at the same moments.
  ASSERT_EQ(RunFacet("map export " + both + " " + Path("two.tum") + " --run 2").exit_code, 0);
  Run("all", "");
  const auto in_all = Positions(Read("all/trajectory.tum")), in_map = Positions(Read("two.tum"));
  ASSERT_GT(in_map.size(), 4U);
  for (const auto& [stamp, p] : in_map) {
    ASSERT_TRUE(in_all.contains(stamp)) << stamp;
    EXPECT_LT((p - in_all.at(stamp)).norm(), 0.04) << stamp;
  }
  EXPECT_EQ(RunFacet("map export " + both + " " + Path("x.tum") + " --run 3").exit_code, 3);

  const ProgramRun found = RunFacet("map localise " + both + " " + Path("room") + " --start 15");
  ASSERT_EQ(found.exit_code, 0) << found.err;
  EXPECT_THAT(found.out, ::testing::MatchesRegex("found [0-4]\\.[0-9]+ s after the first pose.*"));
}

TEST_F(LoopsTest, ARecordingOfElsewhereIsNotFound) {
  Run("here", "--duration 8 --save-map " + Path("here-map"));
  ASSERT_EQ(RunFacet("simulate --quiet --scene room --seed 6 --duration 8 --set "
                     "image.rays_per_pixel=1 --set image.max_rays_per_pixel=2 --out " +
                     Path("elsewhere"))
                .exit_code,
            0);
  const ProgramRun lost =
      RunFacet("map localise " + Path("here-map") + " " + Path("elsewhere") + " --duration 4");
  EXPECT_EQ(lost.exit_code, 3);
  EXPECT_THAT(lost.err, ::testing::HasSubstr("not found in"));
  ASSERT_EQ(RunFacet("run " + Path("elsewhere") + " --quiet --pipeline S --out " + Path("there") +
                     " --save-map " + Path("there-map"))
                .exit_code,
            0);
  const ProgramRun apart =
      RunFacet("map merge " + Path("here-map") + " " + Path("there-map") + " " + Path("x-map"));
  EXPECT_EQ(apart.exit_code, 3);
  EXPECT_THAT(apart.err, ::testing::HasSubstr("is not found in what both maps show"));
  EXPECT_FALSE(std::filesystem::exists(Path("x-map")));
}

TEST(SavedMapTest, AMapThatIsNoneIsRefused) {
  const TempFolder folder;
  const ProgramRun none = RunFacet("run recording --map " + (folder / "nowhere").string());
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_THAT(none.err, ::testing::HasSubstr("--save-map"));
  WriteText(folder / "map/places.facetmap", "FACETMAP but not really");
  const ProgramRun damaged = RunFacet("run recording --map " + (folder / "map").string());
  EXPECT_EQ(damaged.exit_code, 3);
  EXPECT_THAT(damaged.err, ::testing::HasSubstr("places.facetmap"));
  EXPECT_EQ(RunFacet("map info " + (folder / "map").string()).exit_code, 3);
}

}  // namespace
}  // namespace facet
