// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/plain_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/asl_dataset.h"
#include "facet/io/calibration_writer.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_images.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The test sequence, as a plain folder.
class PlainFolderTest : public ::testing::Test {
 protected:
  PlainFolderTest() {
    WriteTestSequence(folder_ / "seq");
    const fs::path mav0 = folder_ / "seq/mav0";
    fs::create_directories(Plain());
    fs::rename(mav0 / "cam0/data", Left());
    fs::rename(mav0 / "cam1/data", Plain() / "right");
    fs::copy_file(mav0 / "imu0/data.csv", Plain() / "imu.csv");
    WriteCalibration(Plain() / "camchain.yaml", ReadEurocCalibration(mav0, {}).rig);
    WriteText(Plain() / "imu.yaml", TestImuYaml());
  }
  fs::path Plain() const { return folder_ / "flight_8"; }
  fs::path Left() const { return Plain() / "left"; }
  StereoDataset Read() const { return StereoDataset(ReadPlainFolder(Plain())); }
  std::string Complaint() const {
    try {
      Read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }

  TempFolder folder_;
};

TEST_F(PlainFolderTest, NamesAreStamps) {
  EXPECT_TRUE(IsPlainFolder(Plain()));
  EXPECT_FALSE(IsPlainFolder(folder_ / "seq"));
  StereoDataset dataset = Read();
  EXPECT_EQ(dataset.name(), "flight_8");
  EXPECT_THAT(dataset.warnings(), IsEmpty());
  ASSERT_EQ(dataset.frames().size(), 12u);
  EXPECT_EQ(dataset.imu().size(), 151u);
  EXPECT_NEAR(dataset.rig().baseline_m(), 0.11, 0.001);
  cv::Mat left, right;
  for (int i = 0; i < 12; ++i) {
    const FrameEntry& frame = dataset.frames()[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.t.ns, FrameStamp({}, i));
    EXPECT_EQ(frame.left, std::to_string(frame.t.ns) + ".pgm");
    EXPECT_EQ(dataset.ReadPair(static_cast<std::size_t>(i), left, right), "");
  }
}

TEST_F(PlainFolderTest, ListsOfTimesGoBeforeNames) {
  std::string list;
  for (int i = 0; i < 12; ++i) {
    const std::string name = "frame_" + std::to_string(i) + ".pgm";
    for (const char* side : {"left", "right"}) {
      fs::rename(Plain() / side / (std::to_string(FrameStamp({}, i)) + ".pgm"),
                 Plain() / side / name);
    }
    list += std::to_string(FrameStamp({}, i) + 7) + "," + name + "\n";
  }
  EXPECT_THAT(Complaint(), HasSubstr("left: no image that is named by its stamp"));
  WriteText(Plain() / "times.csv", "time,file\n" + list);
  EXPECT_EQ(Read().frames()[2].t.ns, FrameStamp({}, 2) + 7);
  EXPECT_EQ(Read().frames()[2].left, "frame_2.pgm");
  // That of one camera goes before that of both.
  WriteText(Left() / "times.csv", list.substr(list.find('\n') + 1));
  EXPECT_EQ(Read().frames().size(), 11u);
  EXPECT_THAT(Read().warnings(), Contains(HasSubstr("1 right images have no left image")));
}

TEST_F(PlainFolderTest, OtherFilesAreCounted) {
  WriteText(Left() / "Thumbs.db", "?");
  WriteText(Left() / "cover.png", "?");
  EXPECT_THAT(Read().warnings(), Contains(HasSubstr("left: 2 files are no images named by")));
}

TEST_F(PlainFolderTest, SaysWhatIsMissing) {
  fs::rename(Plain() / "camchain.yaml", folder_ / "camchain.yaml");
  EXPECT_THAT(Complaint(), HasSubstr("flight_8: no camchain*.yaml in it"));
  EXPECT_EQ(ReadPlainFolder(Plain(), {folder_ / "camchain.yaml", {}}).imu.size(), 151u);
  fs::rename(folder_ / "camchain.yaml", Plain() / "camchain.yaml");
  fs::remove(Plain() / "imu.csv");
  EXPECT_THAT(Complaint(), HasSubstr("imu.csv: no such file"));
}

TEST_F(PlainFolderTest, NamesInMicrosecondsAreRefused) {
  for (const char* side : {"left", "right"}) {
    for (int i = 0; i < 12; ++i) {
      const std::int64_t ns = FrameStamp({}, i);
      fs::rename(Plain() / side / (std::to_string(ns) + ".pgm"),
                 Plain() / side / (std::to_string(ns / 1000) + ".pgm"));
    }
  }
  EXPECT_THAT(Complaint(), HasSubstr("are the stamps of the same clock and unit?"));
}

/// Grey values up to `max` in 16-bit PNG files.
void WriteDeepImages(const fs::path& folder, int max) {
  fs::remove_all(folder);
  for (int i = 0; i < 12; ++i) {
    TestImage image{160, 120, 1, {}};
    for (int k = 0; k < 160 * 120; ++k)
      image.samples.push_back(static_cast<std::uint16_t>(k * max / (160 * 120 - 1)));
    WriteText(folder / (std::to_string(FrameStamp({}, i)) + ".png"), EncodePng(image, {16}));
  }
}

TEST_F(PlainFolderTest, RightAlignedSamplesAreScaled) {
  for (const auto& [max, bits] : {std::pair{1023, 10}, {4095, 12}, {65535, 16}}) {
    WriteDeepImages(Left(), max);
    WriteDeepImages(Plain() / "right", max);
    StereoDataset dataset = Read();
    EXPECT_EQ(dataset.sample_bits(), bits);
    if (bits < 16) {
      EXPECT_THAT(dataset.warnings(), Contains(HasSubstr(std::to_string(bits) + " bits are used")));
    } else {
      EXPECT_THAT(dataset.warnings(), IsEmpty());
    }
    cv::Mat left, right;
    EXPECT_EQ(dataset.ReadPair(5, left, right), "");
    for (const cv::Mat& image : {left, right}) {
      EXPECT_EQ(image.at<std::uint8_t>(0, 0), 0);
      EXPECT_EQ(image.at<std::uint8_t>(119, 159), 255);
      EXPECT_NEAR(image.at<std::uint8_t>(60, 0), 128, 1);
    }
  }
}

}  // namespace
}  // namespace facet
