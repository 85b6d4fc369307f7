// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/result_writer.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

#include "facet/io/errors.h"
#include "facet/io/planes_file.h"
#include "facet/io/result_folder.h"
#include "facet/io/states_file.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

RunRecord SmallRun() {
  RunRecord run;
  run.version = "0.1.0";
  run.sequence = "flight";
  run.pipeline = "S";
  run.first_pair = {1000000000};
  run.num_frames = 5;
  run.duration_s = 0.2;
  run.wall_s = 0.1;
  run.warnings = {"something, \"odd\" \xFF"};
  for (int i = 0; i < 4; ++i) {
    FrameRecord f;
    f.t = {1000000000 + i * 50000000};
    f.has_pose = i > 0;
    f.is_keyframe = i % 2 == 0;
    f.status = f.has_pose ? "ok" : "initialising";
    f.reason = f.has_pose ? "" : "waiting, 3 of 7 frames";
    f.state.T_WB.p = Vector3d(i, 0, 0);
    f.times[Stage::kDecode] = 2;
    f.times[Stage::kTrack] = i + 1;
    f.num_landmarks = 100 + i;
    run.frames.push_back(f);
  }
  run.keyframes = {{{1100000000}, {}}};
  run.landmarks = {{1, 2, 3}, {4, 5, 6}};
  run.config = "a: 1\n";
  return run;
}

TEST(ResultWriterTest, WritesEveryFile) {
  TempFolder folder;
  WriteResult(folder.path(), SmallRun());
  EXPECT_EQ(ReadTrajectory(folder / "trajectory.tum").poses.size(), 3u);
  EXPECT_EQ(ReadTrajectory(folder / "keyframes.tum").poses.size(), 1u);
  EXPECT_EQ(ReadText(folder / "config.yaml"), "a: 1\n");

  const auto states = Lines(ReadText(folder / "states.csv"));
  ASSERT_EQ(states.size(), 5u);
  EXPECT_THAT(states[1], ::testing::StartsWith("1000000000,,,"));
  EXPECT_THAT(states[1], ::testing::EndsWith(",initialising,\"waiting, 3 of 7 frames\","));
  EXPECT_THAT(states[2], ::testing::StartsWith("1050000000,1,0,0,1,0,0,0,"));
  EXPECT_EQ(std::count(states[0].begin(), states[0].end(), ','), 34);
  EXPECT_EQ(std::count(states[1].begin(), states[1].end(), ','), 35);  // one within the quotes
  EXPECT_EQ(std::count(states[2].begin(), states[2].end(), ','), 34);
  EXPECT_THAT(states[2], ::testing::EndsWith(",0"));

  const auto timing = Lines(ReadText(folder / "timing.csv"));
  EXPECT_THAT(timing[0], ::testing::StartsWith("timestamp_ns,is_keyframe,decode,track,stereo,"));
  EXPECT_EQ(timing[2],
            "1050000000,0,2.0000,2.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,"
            "2.0000,4.0000,0.0000,0.0000,101,0,0,0.0000");

  const std::string ply = ReadText(folder / "landmarks.ply");
  EXPECT_THAT(ply,
              ::testing::StartsWith("ply\nformat binary_little_endian 1.0\nelement vertex 2\n"));
  const std::size_t body = ply.find("end_header\n") + 11;
  EXPECT_EQ(ply.size() - body, 24u);
}

TEST(ResultWriterTest, PlanesTellTheirOutlineAndWhatTheyHaveAbsorbed) {
  TempFolder folder;
  RunRecord run = SmallRun();
  run.planes.emplace(2);
  (*run.planes)[0].id = PlaneId{4};
  (*run.planes)[0].outline_W = {{0, 0, 1}, {1, 0.5, 1}};
  (*run.planes)[0].merged_ids = {PlaneId{7}, PlaneId{9}};
  (*run.planes)[1].id = PlaneId{5};
  WriteResult(folder.path(), run);
  const auto planes = Lines(ReadText(folder / "planes.csv"));
  ASSERT_EQ(planes.size(), 3u);
  EXPECT_THAT(planes[0], ::testing::EndsWith(",outline,absorbed"));
  EXPECT_THAT(planes[1], ::testing::StartsWith("4,"));
  EXPECT_THAT(planes[1], ::testing::EndsWith(",0.000 0.000 1.000;1.000 0.500 1.000,7 9"));
  EXPECT_THAT(planes[2], ::testing::EndsWith(",,"));
  EXPECT_EQ(ReadEstimatedPlanes(folder / "planes.csv").size(), 2u);
}

TEST(ResultWriterTest, StatesAreReadBack) {
  TempFolder folder;
  RunRecord run = SmallRun();
  FrameRecord& f = run.frames[2];
  f.state.v_WB = {4, 5, 6};
  f.state.bias = {{0.1, 0.2, 0.3}, {1, 2, 3}};
  f.sigma_p = {0.01, 0.02, 0.03};
  f.sigma_theta = {0.001, 0.002, 0.003};
  f.sigma_v = {0.4, 0.5, 0.6};
  f.sigma_b_g = {1e-4, 2e-4, 3e-4};
  f.sigma_b_a = {0.07, 0.08, 0.09};
  WriteResult(folder.path(), run);
  const std::vector<EstimatedState> states = ReadStates(folder / "states.csv");
  ASSERT_EQ(states.size(), 3u);
  EXPECT_EQ(states[1].state.bias.b_a, f.state.bias.b_a);
  EXPECT_EQ(states[1].sigma_p, f.sigma_p);
  EXPECT_EQ(states[1].sigma_theta, f.sigma_theta);
  EXPECT_EQ(states[1].sigma_v, f.sigma_v);
  EXPECT_EQ(states[1].sigma_b_g, f.sigma_b_g);
  EXPECT_EQ(states[1].sigma_b_a, f.sigma_b_a);
}

TEST(ResultWriterTest, Summary) {
  TempFolder folder;
  WriteResult(folder.path(), SmallRun());
  const auto summary = nlohmann::json::parse(ReadText(folder / "summary.json"));
  EXPECT_EQ(summary["frames"], 5);
  EXPECT_EQ(summary["frames_with_pose"], 3);
  EXPECT_EQ(summary["keyframes"], 1);
  EXPECT_EQ(summary["realtime_factor"], 2.0);
  EXPECT_EQ(summary["init_s"], 0.05);
  EXPECT_EQ(summary["landmarks_median"], 102);
  const auto& track = summary["stages"]["track"];
  EXPECT_EQ(track["mean_ms"], 2.5);
  EXPECT_EQ(track["median_ms"], 2.5);
  EXPECT_EQ(track["p99_ms"], 4);
  EXPECT_EQ(track["max_ms"], 4);
  EXPECT_EQ(track["keyframe_median_ms"], 2);
  EXPECT_EQ(summary["stages"]["total_without_decode"]["max_ms"], 4);
  EXPECT_FALSE(summary["stages"].contains("mesh"));
  EXPECT_FALSE(summary.contains("mesh_faces"));
  EXPECT_EQ(summary["warnings"].size(), 1u);
}

TEST(ResultWriterTest, ASummaryWhileTheRunGoesOnSaysSo) {
  RunRecord run = SmallRun();
  EXPECT_FALSE(nlohmann::json::parse(SummaryJson(run)).contains("interrupted"));
  run.is_interrupted = true;
  const auto summary = nlohmann::json::parse(SummaryJson(run));
  EXPECT_EQ(summary["interrupted"], true);
  EXPECT_EQ(summary["frames"], 5);
  EXPECT_FALSE(summary.contains("stages"));
  run.frames.clear();
  EXPECT_EQ(nlohmann::json::parse(SummaryJson(run))["frames_with_pose"], 0);
}

TEST(ResultWriterTest, LatenciesOfARunAtRecordedSpeed) {
  RunRecord run = SmallRun();
  EXPECT_FALSE(nlohmann::json::parse(SummaryJson(run)).contains("latency"));
  run.is_realtime = true;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    run.frames[i].has_pose = true;
    run.frames[i].is_keyframe = i == 1;
    run.frames[i].pose_latency_ms = static_cast<double>(i + 1);
    run.frames[i].latency_ms = 20;
  }
  const auto latency = nlohmann::json::parse(SummaryJson(run))["latency"];
  EXPECT_EQ(latency["pose"]["median_ms"], 0.5 * static_cast<double>(run.frames.size() + 1));
  EXPECT_EQ(latency["pose"]["max_ms"], run.frames.size());
  EXPECT_EQ(latency["mesh"]["p99_ms"], 20);
}

TEST(ResultWriterTest, RunWithoutAnyPose) {
  TempFolder folder;
  RunRecord run = SmallRun();
  run.frames.clear();
  run.keyframes.clear();
  WriteResult(folder.path(), run);
  const auto summary = nlohmann::json::parse(ReadText(folder / "summary.json"));
  EXPECT_FALSE(summary.contains("init_s"));
  EXPECT_EQ(summary["frames_with_pose"], 0);
}

TEST(ResultWriterTest, UnwritableFileIsNamed) {
  TempFolder folder;
  std::filesystem::create_directory(folder / "states.csv");
  try {
    WriteResult(folder.path(), SmallRun());
    FAIL() << "no exception";
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("states.csv"));
  }
}

std::vector<std::string> NamesIn(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST(ResultFolderTest, AppearsOnlyWhenCommitted) {
  TempFolder folder;
  {
    ResultFolder result(folder / "deep/er/run");
    WriteText(result.staging() / "summary.json", "{}");
    EXPECT_FALSE(std::filesystem::exists(folder / "deep/er/run"));
  }
  EXPECT_TRUE(NamesIn(folder / "deep/er").empty());
  ResultFolder result(folder / "deep/er/run/");
  WriteText(result.staging() / "summary.json", "{}");
  result.Commit();
  EXPECT_EQ(NamesIn(folder / "deep/er"), std::vector<std::string>{"run"});
}

TEST(ResultFolderTest, ReplacesAnEarlierResultAsAWhole) {
  TempFolder folder;
  WriteText(folder / "run/summary.json", "old");
  WriteText(folder / "run/meshes/1.ply", "old");
  {
    ResultFolder result(folder / "run");
    WriteText(result.staging() / "summary.json", "new");
    EXPECT_EQ(ReadText(folder / "run/summary.json"), "old");
    result.Commit();
  }
  EXPECT_EQ(NamesIn(folder.path()), std::vector<std::string>{"run"});
  EXPECT_EQ(NamesIn(folder / "run"), std::vector<std::string>{"summary.json"});
  EXPECT_EQ(ReadText(folder / "run/summary.json"), "new");
}

// A process that is killed leaves its unfinished folder behind.
TEST(ResultFolderTest, RemovesWhatDeadProcessesLeftBehind) {
  TempFolder folder;
  WriteText(folder / ".run.partial-123/meshes/1.ply", "half");
  WriteText(folder / ".run.partial-124-old/summary.json", "old");
  WriteText(folder / "run/summary.json", "newer");
  // These belong to somebody else.
  WriteText(folder / ".run.partial-mine/notes", "text");
  WriteText(folder / ".run2.partial-123/summary.json", "half");
  {
    ResultFolder alive(folder / "run"), other(folder / "run2");
    EXPECT_FALSE(std::filesystem::exists(folder / ".run2.partial-123"));
    EXPECT_TRUE(std::filesystem::exists(alive.staging()));
  }
  EXPECT_EQ(NamesIn(folder.path()), (std::vector<std::string>{".run.partial-mine", "run"}));
  EXPECT_EQ(ReadText(folder / "run/summary.json"), "newer");
}

TEST(ResultFolderTest, LeavesAloneWhatALiveProcessWrites) {
  TempFolder folder;
  const std::filesystem::path live = folder / ".run.partial-1";
  WriteText(live / "summary.json", "half");
  const int descriptor = open(live.c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(flock(descriptor, LOCK_EX), 0);
  { ResultFolder result(folder / "run"); }
  EXPECT_TRUE(std::filesystem::exists(live));
  close(descriptor);
  { ResultFolder result(folder / "run"); }
  EXPECT_FALSE(std::filesystem::exists(live));
}

TEST(ResultFolderTest, AResultThatHadToMakeRoomComesBack) {
  TempFolder folder;
  WriteText(folder / ".run.partial-123/trajectory.tum", "half");
  WriteText(folder / ".run.partial-123-old/summary.json", "old");
  { ResultFolder result(folder / "run"); }
  EXPECT_EQ(NamesIn(folder.path()), std::vector<std::string>{"run"});
  EXPECT_EQ(ReadText(folder / "run/summary.json"), "old");
}

TEST(ResultFolderTest, RelativeNames) {
  TempFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  for (const char* name : {"run", "./other", "deep/run"}) {
    ResultFolder result(name);
    WriteText(result.staging() / "summary.json", "{}");
    result.Commit();
    EXPECT_TRUE(std::filesystem::exists((folder / name) / "summary.json"));
  }
  std::filesystem::current_path(before);
}

TEST(ResultFolderTest, NeverReplacesWhatIsNoResult) {
  TempFolder folder;
  WriteText(folder / "home/thesis.tex", "years of work");
  WriteText(folder / "file", "text");
  EXPECT_THROW(ResultFolder(folder / "home"), ConfigError);
  EXPECT_THROW(ResultFolder(folder / "file"), ConfigError);
  EXPECT_THROW(ResultFolder(folder / "file/run"), ConfigError);
  EXPECT_THROW(ResultFolder("/proc/nothing/run"), ConfigError);
  std::filesystem::create_directory(folder / "empty");
  ResultFolder result(folder / "empty");
  WriteText(result.staging() / "summary.json", "{}");
  result.Commit();
  EXPECT_EQ(NamesIn(folder / "empty"), std::vector<std::string>{"summary.json"});
  EXPECT_EQ(NamesIn(folder.path()), (std::vector<std::string>{"empty", "file", "home"}));
}

}  // namespace
}  // namespace facet
