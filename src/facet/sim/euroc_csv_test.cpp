// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/euroc_csv.h"

#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>

namespace facet {
namespace {

std::filesystem::path Write(const std::string& text) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const auto path = std::filesystem::path(::testing::TempDir()) /
                    (std::string("euroc_csv_") + test->name() + ".csv");
  std::ofstream(path) << text;
  return path;
}

TEST(EurocCsvTest, ReadsGroundTruth) {
  const auto states = LoadGroundTruthCsv(
      Write("#timestamp,...\n"
            "1403715524907143168,1,2,3,0.5,0.5,-0.5,0.5,4,5,6,7,8,9,10,11,12\r\n"
            "1403715524912143104, 1, 2, 3, 1, 0, 0, 0, nan, nan, nan, nan, nan, nan, 1, 2, 3\n"));
  ASSERT_EQ(states.size(), 2u);
  EXPECT_EQ(states[0].t, Timestamp{1403715524907143168});
  EXPECT_EQ(states[0].T_WB.p, Vector3d(1, 2, 3));
  EXPECT_EQ(states[0].T_WB.q.w(), 0.5);
  EXPECT_EQ(states[0].T_WB.q.y(), -0.5);
  EXPECT_EQ(states[0].v_WB, Vector3d(4, 5, 6));
  EXPECT_EQ(states[0].bias.b_g, Vector3d(7, 8, 9));
  EXPECT_EQ(states[0].bias.b_a, Vector3d(10, 11, 12));
  EXPECT_EQ(states[1].v_WB, Vector3d(0, 0, 0));
  EXPECT_TRUE(states[1].bias.b_g.array().isNaN().all());
  EXPECT_EQ(states[1].bias.b_a, Vector3d(1, 2, 3));
}

TEST(EurocCsvTest, ReadsImu) {
  const auto samples = LoadImuCsv(Write("#t\n5,1,2,3,4,5,6\n10,1,2,3,4,5,-6e-1\n"));
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[1].t, Timestamp{10});
  EXPECT_EQ(samples[1].gyro, Vector3d(1, 2, 3));
  EXPECT_EQ(samples[1].accel, Vector3d(4, 5, -0.6));
}

TEST(EurocCsvTest, SaysWhereAFileIsWrong) {
  EXPECT_THROW(LoadImuCsv("there/is/no/such/file.csv"), std::runtime_error);
  EXPECT_THROW(LoadImuCsv(Write("#only a comment\n")), std::runtime_error);
  EXPECT_THROW(LoadImuCsv(Write("5,1,2,3,4,5\n")), std::runtime_error);
  EXPECT_THROW(LoadImuCsv(Write("5,1,2,3,4,5,6\n5,1,2,3,4,5,6\n")), std::runtime_error);
  try {
    LoadImuCsv(Write("#t\n5,1,2,3,4,5,6\n6,1,2,x,4,5,6\n"));
    FAIL() << "no exception";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find(".csv:3:"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace facet
