// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/asl_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/asl_files.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class AslDatasetTest : public ::testing::Test {
 protected:
  AslDatasetTest() { WriteTestSequence(Sequence()); }
  std::filesystem::path Sequence() const { return folder_ / "flight_7"; }
  std::filesystem::path Mav0() const { return Sequence() / "mav0"; }
  std::filesystem::path Csv(const std::string& sensor) const {
    return Mav0() / sensor / "data.csv";
  }
  std::filesystem::path Image(int camera, int i) const {
    return Mav0() / ("cam" + std::to_string(camera)) / "data" /
           (std::to_string(FrameStamp({}, i)) + ".pgm");
  }

  std::string Error() const {
    try {
      AslDataset dataset(Sequence());
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  std::vector<std::string> Warnings() const { return AslDataset(Sequence()).warnings(); }

  TempFolder folder_;
};

TEST_F(AslDatasetTest, ReadsEverything) {
  for (const auto& folder : {Sequence(), Mav0(), Sequence() / "", Mav0() / ".."}) {
    AslDataset dataset(folder);
    EXPECT_EQ(dataset.name(), "flight_7");
    EXPECT_EQ(dataset.frames().size(), 12u);
    EXPECT_EQ(dataset.frames()[3].t.ns, FrameStamp({}, 3));
    EXPECT_TRUE(dataset.frames()[3].HasRight());
    EXPECT_EQ(dataset.imu().size(), 151u);
    EXPECT_EQ(dataset.imu()[0].gyro, Vector3d(0.001, -0.002, 0.003));
    EXPECT_EQ(dataset.imu()[0].accel, Vector3d(9.81, 0.01, 0.02));
    EXPECT_THAT(dataset.warnings(), IsEmpty());
    cv::Mat left, right;
    EXPECT_EQ(dataset.ReadPair(11, left, right), "");
    EXPECT_EQ(left.cols, 160);
    EXPECT_EQ(right.rows, 120);
  }
}

TEST_F(AslDatasetTest, HeadersLineEndsAndMissingNamesDoNotMatter) {
  for (const char* sensor : {"cam0", "cam1", "imu0"}) {
    EditLines(Csv(sensor), [](std::vector<std::string>& lines) {
      lines[0] = "#ts,whatever";
      for (std::string& line : lines)
        line += "\r";
    });
  }
  EXPECT_EQ(AslDataset(Sequence()).frames().size(), 12u);
  EXPECT_THAT(Warnings(), IsEmpty());
}

TEST_F(AslDatasetTest, UnequalCountsArePairedByStamp) {
  EditLines(Csv("cam1"), [](std::vector<std::string>& lines) {
    lines.erase(lines.begin() + 6);  // right image of frame 5
    lines[3].replace(
        0, 19, std::to_string(FrameStamp({}, 2) + 3000000));  // 3 ms late: still a pair
    lines[8].replace(0, 19, std::to_string(FrameStamp({}, 8) + 20000000));  // 20 ms late: no pair
  });
  EditLines(Csv("cam0"), [](std::vector<std::string>& lines) { lines.erase(lines.begin() + 11); });
  AslDataset dataset(Sequence());
  ASSERT_EQ(dataset.frames().size(), 11u);
  EXPECT_TRUE(dataset.frames()[2].HasRight());
  EXPECT_FALSE(dataset.frames()[5].HasRight());
  EXPECT_FALSE(dataset.frames()[8].HasRight());
  EXPECT_THAT(dataset.warnings(), Contains(HasSubstr("2 left images have no right image")));
  EXPECT_THAT(dataset.warnings(), Contains(HasSubstr("2 right images have no left image")));
  cv::Mat left, right;
  EXPECT_EQ(dataset.ReadPair(5, left, right), "");
  EXPECT_TRUE(right.empty());
}

TEST_F(AslDatasetTest, BeginsWithTheFirstPair) {
  std::filesystem::remove(Image(1, 0));
  std::filesystem::remove(Image(0, 4));
  AslDataset dataset(Sequence());
  ASSERT_EQ(dataset.frames().size(), 10u);
  EXPECT_EQ(dataset.frames()[0].t.ns, FrameStamp({}, 1));
  EXPECT_THAT(dataset.warnings(), Contains(HasSubstr("1 of 12 listed images are missing")));
  EXPECT_THAT(dataset.warnings(), Contains(HasSubstr("before the first stereo pair")));
}

TEST_F(AslDatasetTest, AFewBadLinesAreSkippedAndReported) {
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    lines[10] = lines[9];
    lines[20] = lines[20].substr(0, 19) + ",nan,0,0,9.81,0,0";
    lines[30] = lines[30].substr(0, 19) + ",1,2";
    lines[40] = lines[12];
    lines[50] = "what is this";
  });
  AslDataset dataset(Sequence());
  EXPECT_EQ(dataset.imu().size(), 146u);
  EXPECT_THAT(dataset.warnings(),
              Contains(HasSubstr("data.csv:11: 1 of 151 lines have a duplicate")));
  EXPECT_THAT(dataset.warnings(), Contains(AllOf(HasSubstr(":21:"), HasSubstr("not finite"))));
  EXPECT_THAT(dataset.warnings(),
              Contains(AllOf(HasSubstr(":31:"), HasSubstr("missing or unread"))));
  EXPECT_THAT(dataset.warnings(), Contains(AllOf(HasSubstr(":41:"), HasSubstr("backwards"))));
  EXPECT_THAT(dataset.warnings(), Contains(AllOf(HasSubstr(":51:"), HasSubstr("no stamp"))));
}

TEST_F(AslDatasetTest, NamesWithControlCharactersAreNoFiles) {
  const auto add_to_name = [](std::string& line, char c) { line += std::string{c, 'x'}; };
  EditLines(Csv("cam0"), [&](std::vector<std::string>& lines) { add_to_name(lines[2], '\0'); });
  const AslDataset dataset(Sequence());
  EXPECT_EQ(dataset.frames().size(), 11u);
  EXPECT_THAT(dataset.warnings(),
              Contains(AllOf(HasSubstr("cam0/data.csv:3: 1 of 12 lines"), HasSubstr("NUL bytes"))));
  for (const char c : {'\0', '\x1b', '\x7f'}) {
    EditLines(Csv("cam1"), [&](std::vector<std::string>& lines) {
      for (std::size_t i = 1; i < lines.size(); ++i)
        add_to_name(lines[i], c);
    });
    EXPECT_THAT(Error(), HasSubstr("cam1/data.csv:2: 12 of 12 lines have a file name with NUL"));
  }
}

TEST_F(AslDatasetTest, NamesMayLeadToAnotherFolder) {
  std::filesystem::rename(Mav0() / "cam0" / "data", Mav0() / "left images");
  EditLines(Csv("cam0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i].insert(lines[i].find(',') + 1, "../../left images/");
  });
  std::filesystem::create_directory(Mav0() / "cam0" / "data");
  EXPECT_EQ(AslDataset(Sequence()).frames().size(), 12u);
}

TEST_F(AslDatasetTest, DamagedImages) {
  Truncate(Image(0, 0), 1000);
  Truncate(Image(1, 3), 1000);
  AslDataset dataset(Sequence());
  cv::Mat left, right;
  EXPECT_THROW(dataset.ReadPair(0, left, right), InputError);
  EXPECT_THAT(dataset.ReadPair(3, left, right), HasSubstr("truncated PGM"));
  EXPECT_FALSE(left.empty());
  EXPECT_TRUE(right.empty());
  EXPECT_EQ(dataset.ReadPair(4, left, right), "");
  EXPECT_FALSE(right.empty());
}

TEST_F(AslDatasetTest, OneReadablePairIsEnough) {
  for (int i = 0; i < 11; ++i)
    Truncate(Image(i % 2, i), 1000);
  EXPECT_EQ(AslDataset(Sequence()).frames().size(), 12u);
  Truncate(Image(1, 11), 1000);
  EXPECT_THAT(Error(), AllOf(HasSubstr(Image(0, 0)), HasSubstr("no other stereo pair")));
}

TEST_F(AslDatasetTest, MissingParts) {
  std::filesystem::remove_all(Mav0() / "cam0" / "data");
  EXPECT_THAT(Error(),
              AllOf(HasSubstr("no such file, as all 12 images"), HasSubstr("cam0/data.csv")));
  std::filesystem::remove(Csv("imu0"));
  std::filesystem::remove(Csv("cam0"));
  EXPECT_THAT(Error(), HasSubstr("cam0/data.csv: no such file"));
  std::filesystem::remove_all(Mav0());
  EXPECT_THAT(Error(), HasSubstr("holds neither mav0/ nor cam0/"));
  std::filesystem::remove_all(Sequence());
  EXPECT_THAT(Error(), HasSubstr("no such folder"));
}

TEST_F(AslDatasetTest, EmptyCsv) {
  const std::string good = ReadText(Csv("imu0"));
  WriteText(Csv("imu0"), "#timestamp [ns],w_x\n");
  EXPECT_THAT(Error(), AllOf(HasSubstr("imu0/data.csv"), HasSubstr("holds no data")));
  WriteText(Csv("imu0"), good);
  WriteText(Csv("cam1"), "");
  EXPECT_THAT(Error(), AllOf(HasSubstr("cam1/data.csv"), HasSubstr("holds no data")));
}

TEST_F(AslDatasetTest, StampsOutOfOrder) {
  EditLines(Csv("imu0"),
            [](std::vector<std::string>& lines) { std::reverse(lines.begin() + 1, lines.end()); });
  EXPECT_THAT(Error(),
              AllOf(HasSubstr("imu0/data.csv:3: 150 of 151 lines have a stamp that runs backwards"),
                    HasSubstr("sort the lines")));
}

TEST_F(AslDatasetTest, DuplicateStamps) {
  EditLines(Csv("cam0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 2; i < 10; ++i)
      lines[i] = lines[1];
  });
  EXPECT_THAT(Error(), HasSubstr("cam0/data.csv:3: 8 of 12 lines have a duplicate stamp"));
}

TEST_F(AslDatasetTest, StampsInOtherUnits) {
  const std::string good = ReadText(Csv("imu0"));
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i].insert(10, 1, '.');
  });
  EXPECT_THAT(Error(), AllOf(HasSubstr("look like seconds"), HasSubstr("multiply them by 1e9")));
  const std::pair<int, const char*> units[] = {{3, "microseconds"}, {6, "milliseconds"}};
  for (const auto& [num_digits, unit] : units) {
    WriteText(Csv("imu0"), good);
    EditLines(Csv("imu0"), [&](std::vector<std::string>& lines) {
      for (std::size_t i = 1; i < lines.size(); ++i)
        lines[i].erase(19 - num_digits, num_digits);
    });
    EXPECT_THAT(Error(), HasSubstr(unit));
  }
  WriteText(Csv("imu0"), good);
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i].replace(19, 1, ".0,");
  });
  EXPECT_EQ(Error(), "no error");
}

TEST_F(AslDatasetTest, ImuThatIsNotFinite) {
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i] = lines[i].substr(0, 19) + ",nan,0,0,0,0,inf";
  });
  EXPECT_THAT(Error(),
              HasSubstr("imu0/data.csv:2: 151 of 151 lines have values that are not finite"));
}

TEST_F(AslDatasetTest, NoOverlapInTime) {
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i][5] = '9';
  });
  EXPECT_THAT(Error(), AllOf(HasSubstr("imu0/data.csv"), HasSubstr("do not overlap in time")));
}

TEST_F(AslDatasetTest, NoPair) {
  EditLines(Csv("cam1"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i][5] = '9';
  });
  EXPECT_THAT(Error(), HasSubstr("no right image has the stamp of a left one"));
}

TEST_F(AslDatasetTest, WrongImageSize) {
  ReplaceInFile(Mav0() / "cam1" / "sensor.yaml", "[160, 120]", "[752, 480]");
  EXPECT_THAT(Error(),
              AllOf(HasSubstr("cam1/data/"),
                    HasSubstr("160 x 120 pixels, the calibration of cam1 has 752 x 480")));
}

TEST_F(AslDatasetTest, TruthIsFoundButNotRead) {
  EXPECT_TRUE(FindTruth(Sequence()).empty());
  EXPECT_THROW(RequireTruth(Sequence()), InputError);
  WriteText(Csv("state_groundtruth_estimate0"), "total nonsense");
  EXPECT_EQ(Error(), "no error");
  EXPECT_EQ(FindTruth(Mav0()), std::filesystem::canonical(Csv("state_groundtruth_estimate0")));
  EXPECT_EQ(RequireTruth(Mav0()), FindTruth(Mav0()));
}

}  // namespace
}  // namespace facet
