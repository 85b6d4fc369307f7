// SPDX-License-Identifier: BSD-2-Clause
// The instrument against itself: one configuration, other starts. What it calls real must then be
// real nearly never, however the starts are paired.
#include <algorithm>
#include <iostream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/eval/ground_truth.h"
#include "facet/eval/paired_comparison.h"
#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr int kNumStarts = 22;  // 11 against 11
constexpr int kNumTrials = 21;
constexpr int kMaxReal = 1;

// FACET_SELF_COMPARISON_S=24 takes the whole recording instead of its first seconds.
std::string Duration() {
  const char* text = std::getenv("FACET_SELF_COMPARISON_S");
  return text != nullptr ? text : "4";
}

std::vector<std::vector<PosePair>> LoadRuns(const fs::path& folder, const GroundTruth& truth) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  std::vector<std::vector<PosePair>> runs;
  for (const fs::path& run : folders) {
    const auto poses = ReadTrajectory(run / "trajectory.tum").poses;
    runs.push_back(Associate(poses, truth.poses).pairs);
  }
  return runs;
}

void Shuffle(std::vector<double>& values, Rng& rng) {
  for (int i = static_cast<int>(values.size()) - 1; i > 0; --i)
    std::swap(values[i], values[rng.Index(i + 1)]);
}

// One trial: half of the starts, drawn at random, against the other half.
bool LooksReal(std::vector<double> rmse, int trial) {
  Rng rng(trial);
  Shuffle(rmse, rng);
  std::vector<double> ratios;
  for (std::size_t k = 0; k < rmse.size() / 2; ++k)
    ratios.push_back(rmse[rmse.size() / 2 + k] / rmse[k]);
  return CompareRatios(ratios, 2000).verdict == Verdict::kReal;
}

class SelfComparisonTest : public ::testing::Test {
 protected:
  void SetUp() override {
    sequence_ = testing::DataDir("rendered_room");
    if (!sequence_) GTEST_SKIP() << testing::MissingData("rendered_room");
  }

  ProgramRun Compare(int starts, const std::string& duration, const std::string& more = "") const {
    return RunFacet("compare " + sequence_->string() + " --pipelines S --jobs 2 --duration " +
                    duration + " --starts " + std::to_string(starts) + " --out " +
                    out_.path().string() + " " + more);
  }

  std::optional<fs::path> sequence_;
  TempFolder out_;
};

TEST_F(SelfComparisonTest, OtherStartsAreNoRealDifference) {
  const ProgramRun run = Compare(kNumStarts, Duration());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto runs = LoadRuns(out_ / "rendered_room" / "S", LoadGroundTruth(*sequence_));
  ASSERT_EQ(runs.size(), static_cast<std::size_t>(kNumStarts));
  const auto errors = ErrorsOnCommonFrames(runs, AlignmentKind::kSE3);
  ASSERT_TRUE(errors);
  int num_real = 0, num_real_of_many = 0;
  constexpr int kMany = 420;
  for (int trial = 0; trial < kMany; ++trial) {
    const bool is_real = LooksReal(errors->rmse_m, trial);
    num_real += is_real && trial < kNumTrials ? 1 : 0;
    num_real_of_many += is_real ? 1 : 0;
  }
  std::cout << "S against itself with other starts: " << num_real << " of " << kNumTrials
            << " trials called real, " << num_real_of_many << " of " << kMany << " ("
            << errors->num_frames << " common frames)\n";
  EXPECT_LE(num_real, kMaxReal);
}

TEST_F(SelfComparisonTest, AnInterruptedStudyGoesOn) {
  ASSERT_EQ(Compare(1, "2").exit_code, 0);
  const fs::path first = out_ / "rendered_room" / "S" / "start_0.0" / "trajectory.tum";
  const auto written = fs::last_write_time(first);
  const ProgramRun run = Compare(2, "2");
  EXPECT_THAT(run.err, ::testing::HasSubstr("[1/2] rendered_room S start 0: was there"));
  EXPECT_THAT(run.err, ::testing::HasSubstr("[2/2] rendered_room S start 0.1: done"));
  EXPECT_EQ(fs::last_write_time(first), written);
  const ProgramRun changed = Compare(1, "3");  // other arguments: another study
  EXPECT_THAT(changed.err, ::testing::HasSubstr("start 0: done"));
}

TEST_F(SelfComparisonTest, HorizonMeshesAreWrittenUnlessRefused) {
  const fs::path meshes = out_ / "rendered_room" / "S" / "start_0.0" / "meshes";
  EXPECT_EQ(Compare(1, "2").exit_code, 0);
  EXPECT_TRUE(fs::exists(meshes));
  EXPECT_EQ(Compare(1, "2", "--run-option=--mesh-every=0").exit_code, 0);
  EXPECT_FALSE(fs::exists(meshes));
}

}  // namespace
}  // namespace facet
