// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/trajectory_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

Trajectory Read(const std::string& text) {
  TempFolder folder;
  WriteText(folder / "t.txt", text);
  return ReadTrajectory(folder / "t.txt");
}

std::string TrajectoryErrorOf(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(TrajectoryFileTest, RoundTripKeepsEveryNanosecond) {
  Rng rng(3);
  std::vector<StampedPose> poses;
  for (int i = 0; i < 50; ++i) {
    const Quaterniond q(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
    poses.push_back(
        {{1403636584763555584 + i * std::int64_t{49999999}}, {q.normalized(), rng.Normal3()}});
  }
  TempFolder folder;
  WriteTum(folder / "a.tum", poses);
  const Trajectory read = ReadTrajectory(folder / "a.tum");
  EXPECT_EQ(read.format, TrajectoryFormat::kTum);
  EXPECT_TRUE(read.warnings.empty());
  ASSERT_EQ(read.poses.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(read.poses[i].t, poses[i].t);
    EXPECT_NEAR((read.poses[i].T_WB.p - poses[i].T_WB.p).norm(), 0, 2e-9);
    EXPECT_NEAR((read.poses[i].T_WB.q.coeffs() - poses[i].T_WB.q.coeffs()).norm(), 0, 1e-11);
  }
}

TEST(TrajectoryFileTest, FormatsNegativeAndSmallStamps) {
  EXPECT_EQ(FormatSeconds({5}), "0.000000005");
  EXPECT_EQ(FormatSeconds({-1500000000}), "-1.500000000");
  EXPECT_EQ(FormatSeconds({1403636584763555584}), "1403636584.763555584");
}

TEST(TrajectoryFileTest, TumHasTheRealPartLast) {
  const Trajectory t = Read("# comment\n1.5 1 2 3 0.6 0 0 0.8\n\n2.5 1 2 3 0 0 0 1\r\n");
  ASSERT_EQ(t.poses.size(), 2u);
  EXPECT_EQ(t.poses[0].t.ns, 1500000000);
  EXPECT_DOUBLE_EQ(t.poses[0].T_WB.q.w(), 0.8);
  EXPECT_DOUBLE_EQ(t.poses[0].T_WB.q.x(), 0.6);
  EXPECT_EQ(t.poses[0].T_WB.p, Vector3d(1, 2, 3));
}

TEST(TrajectoryFileTest, EurocHasTheRealPartFirstAndMayHaveMoreColumns) {
  const Trajectory t = Read(
      "#timestamp, p_RS_R_x [m], ...\n"
      "1403638519492829440,1,2,3,0.8,0.6,0,0,nan,nan,nan\n"
      "1403638519497829376,1,2,3,0.8,0.6,0,0,nan,nan,nan\n");
  EXPECT_EQ(t.format, TrajectoryFormat::kEurocCsv);
  ASSERT_EQ(t.poses.size(), 2u);
  EXPECT_EQ(t.poses[0].t.ns, 1403638519492829440);
  EXPECT_DOUBLE_EQ(t.poses[0].T_WB.q.w(), 0.8);
  EXPECT_DOUBLE_EQ(t.poses[0].T_WB.q.x(), 0.6);
}

TEST(TrajectoryFileTest, OrbSlamStampsInNanosecondsAreReadWithAWarning) {
  const Trajectory t = Read(
      "1403715529112143517.000000 1 2 3 0 0 0.6 0.8\n1403715529162143517.000000 1 2 3 0 0 0.6 "
      "0.8\n");
  EXPECT_EQ(t.format, TrajectoryFormat::kTum);
  EXPECT_EQ(t.poses[0].t.ns, 1403715529112143517);
  EXPECT_DOUBLE_EQ(t.poses[0].T_WB.q.w(), 0.8);
  ASSERT_EQ(t.warnings.size(), 1u);
  EXPECT_THAT(t.warnings[0], HasSubstr("nanoseconds"));
}

TEST(TrajectoryFileTest, DuplicatesKeepTheFirst) {
  const Trajectory t = Read("1 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n1 3 0 0 0 0 0 1\n2 4 0 0 0 0 0 1\n");
  ASSERT_EQ(t.poses.size(), 2u);
  EXPECT_EQ(t.poses[0].T_WB.p.x(), 1);
  EXPECT_EQ(t.num_duplicates, 2);
  EXPECT_THAT(t.warnings, ::testing::Contains(HasSubstr("t.txt:2")));
  EXPECT_THAT(t.warnings, ::testing::Contains(HasSubstr("2 duplicate stamps")));
}

TEST(TrajectoryFileTest, ErrorsNameTheLine) {
  const std::string good = "1.0 0 0 0 0 0 0 1\n";
  EXPECT_THAT(TrajectoryErrorOf(""), HasSubstr("no pose"));
  EXPECT_THAT(TrajectoryErrorOf("# only a header\n"), HasSubstr("no pose"));
  EXPECT_THAT(TrajectoryErrorOf(good + "2.0 0 0 0 0 0 1\n"), HasSubstr("t.txt:2: 7 columns"));
  EXPECT_THAT(TrajectoryErrorOf(good + "2.0 nan 0 0 0 0 0 1\n"),
              HasSubstr("t.txt:2: column 2 is 'nan'"));
  EXPECT_THAT(TrajectoryErrorOf(good + "2.0 x 0 0 0 0 0 1\n"),
              HasSubstr("t.txt:2: column 2 is 'x'"));
  EXPECT_THAT(TrajectoryErrorOf(good + "2.0 0 0 0 0 0 0 0\n"),
              HasSubstr("t.txt:2: the quaternion has norm 0"));
  EXPECT_THAT(TrajectoryErrorOf(good + "2.0 0 0 0 0 0 1 1\n"), HasSubstr("norm 1.41"));
  EXPECT_THAT(TrajectoryErrorOf(good + "2.0 0 1e300 0 0 0 0 1\n"),
              HasSubstr("t.txt:2: the position is more than 10000 km away"));
  EXPECT_THAT(TrajectoryErrorOf(good + "0.5 0 0 0 0 0 0 1\n"),
              HasSubstr("t.txt:2: the stamp runs backwards"));
}

TEST(TrajectoryFileTest, WrongUnitsAreExplained) {
  EXPECT_THAT(TrajectoryErrorOf("1403638519.49,1,2,3,0.8,0.6,0,0\n"),
              HasSubstr("looks like seconds"));
  EXPECT_THAT(TrajectoryErrorOf("1,0,0,0,1,0,0,0\n2,0,0,0,1,0,0,0\n3,0,0,0,1,0,0,0\n"),
              HasSubstr("must be nanoseconds"));
}

TEST(TrajectoryFileTest, FullDiskIsReported) {
  EXPECT_THROW(WriteTum("/dev/full", std::vector<StampedPose>(1)), OutputError);
  EXPECT_THROW(WriteTum("/nonexistent/a.tum", std::vector<StampedPose>(1)), OutputError);
}

}  // namespace
}  // namespace facet
