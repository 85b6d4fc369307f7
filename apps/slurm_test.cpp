// SPDX-License-Identifier: BSD-2-Clause
// `facet compare --slurm`: with a stand-in for sbatch, and on a one-node cluster where Debian's
// Slurm is installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/testing/data_dir.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::int64_t kBegin_ns = 1403636584763555584;

class SlurmTest : public ::testing::Test {
 protected:
  // Images of noise, from which a start just comes about.
  SlurmTest() {
    TestSequenceOptions options;
    options.num_frames = 16;
    WriteTestSequence(folder_ / "seq", options);
    std::string truth;
    for (int i = 0; i < 200; ++i)
      truth += std::to_string(kBegin_ns + 5'000'000LL * i) + ",0,0,0,1,0,0,0\n";
    WriteText(folder_ / "seq/mav0/state_groundtruth_estimate0/data.csv", truth);
  }

  std::string Study(const std::string& out, const std::string& more) const {
    return std::string(FACET_PROGRAM) + " compare " + (folder_ / "seq").string() +
           " --pipelines S,SPR --starts 1 --set estimator.imu.gyro_noise_scale=3 --out " +
           (folder_ / out).string() + " " + more;
  }

  /// A program of this name in a folder of its own, which comes first where programs are searched.
  void Install(const std::string& script) const {
    WriteText(folder_ / "bin/sbatch", script);
    fs::permissions(folder_ / "bin/sbatch", fs::perms::owner_all);
  }
  ProgramRun RunWithStandIn(const std::string& command) const {
    return RunShell("PATH=" + (folder_ / "bin").string() + ":$PATH " + command);
  }

  std::string Trajectory(const std::string& out, const std::string& pipeline) const {
    return ReadText(folder_ / out / "seq" / pipeline / "start_0.0/trajectory.tum");
  }

  TempFolder folder_;
};

// Runs the tasks of the array one after the other; its arguments go to a file.
std::string StandIn(const fs::path& log) {
  return "#!/bin/sh\necho \"$@\" >>'" + log.string() +
         "'\n"
         "for word in \"$@\"; do case $word in --array=*) tasks=${word#--array=0-};; esac; "
         "script=$word; "
         "done\n"
         "echo 17\n"
         "for task in $(seq 0 ${tasks%\\%*}); do SLURM_ARRAY_TASK_ID=$task sh \"$script\" || true; "
         "done\n";
}

TEST_F(SlurmTest, GivesTheResultsOfARunHere) {
  Install(StandIn(folder_ / "log"));
  const ProgramRun here = RunShell(Study("here", "--quiet"));
  ASSERT_EQ(here.exit_code, 0) << here.err;
  const ProgramRun there =
      RunWithStandIn(Study("there", "--slurm --slurm-option=--partition=short --jobs 3"));
  ASSERT_EQ(there.exit_code, 0) << there.err;
  EXPECT_THAT(there.err, HasSubstr("2 of 2 runs go to Slurm, 0 were there"));
  EXPECT_THAT(ReadText(folder_ / "log"), HasSubstr("--array=0-1%3 "));
  EXPECT_THAT(ReadText(folder_ / "log"), HasSubstr(" --partition=short "));
  for (const char* pipeline : {"S", "SPR"}) {
    EXPECT_FALSE(Trajectory("there", pipeline).empty());
    EXPECT_EQ(Trajectory("there", pipeline), Trajectory("here", pipeline));
  }
}

TEST_F(SlurmTest, AStudyGoesOnWithWhatIsMissing) {
  Install(StandIn(folder_ / "log"));
  ASSERT_EQ(RunWithStandIn(Study("out", "--slurm")).exit_code, 0);
  const ProgramRun nothing = RunWithStandIn(Study("out", "--slurm"));
  EXPECT_EQ(nothing.exit_code, 0);
  EXPECT_EQ(nothing.err, "");
  fs::remove(folder_ / "out/seq/SPR/start_0.0.cell.json");
  const ProgramRun again = RunWithStandIn(Study("out", "--slurm"));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("1 of 2 runs go to Slurm, 1 were there"));
  EXPECT_THAT(ReadText(folder_ / "out/slurm/run_cell.sh"), HasSubstr("set -- 1 \n"));
}

TEST_F(SlurmTest, WhatFailsIsSaid) {
  Install("#!/bin/sh\necho 'sbatch: error: invalid partition specified: nowhere' >&2\nexit 1\n");
  const ProgramRun refused = RunWithStandIn(Study("out", "--slurm"));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("sbatch refused the job: sbatch: error: invalid partition"));
  Install("#!/bin/sh\necho 17\n");  // the tasks never ran
  const ProgramRun lost = RunWithStandIn(Study("out", "--slurm"));
  EXPECT_EQ(lost.exit_code, 4);
  EXPECT_THAT(lost.err, HasSubstr("the job of Slurm left no result; see "));
  const ProgramRun none = RunShell("PATH=/nowhere " + Study("out", "--slurm"));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("there is no sbatch"));
  EXPECT_EQ(RunShell(Study("out", "--cell 2")).exit_code, 2);
  EXPECT_EQ(RunShell(Study("out", "--slurm-option=-x")).exit_code, 2);
}

TEST_F(SlurmTest, OneNode) {
  constexpr int kSkipped = 77;
  const ProgramRun there = RunShell(testing::SourceFolder().string() +
                                    "/scripts/one_node_slurm.sh " + Study("there", "--slurm"));
  if (there.exit_code == kSkipped) GTEST_SKIP() << there.err;
  ASSERT_EQ(there.exit_code, 0) << there.err;
  ASSERT_EQ(RunShell(Study("here", "--quiet")).exit_code, 0);
  EXPECT_EQ(Trajectory("there", "SPR"), Trajectory("here", "SPR"));
}

}  // namespace
}  // namespace facet
