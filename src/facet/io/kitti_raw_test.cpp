// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/kitti_raw.h"

#include <cmath>
#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_images.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

// The grey cameras of 2011-09-26, with the size of the made images.
constexpr const char* kCameras =
    "calib_time: 09-Jan-2012 13:57:47\n"
    "corner_dist: 9.950000e-02\n"
    "S_00: 1392 512\n"
    "K_00: 984.2439 0 690 0 980.8141 233.1966 0 0 1\n"
    "D_00: -3.728755e-01 2.037299e-01 2.219027e-03 1.383707e-03 -7.233722e-02\n"
    "R_00: 1 0 0 0 1 0 0 0 1\n"
    "T_00: 0 0 0\n"
    "S_01: 1392 512\n"
    "K_01: 989.5267 0 702 0 987.8481 245.5900 0 0 1\n"
    "D_01: -3.644661e-01 1.790019e-01 1.148107e-03 -6.298563e-04 0\n"
    "R_01: 1 0 0 0 1 0 0 0 1\n"
    "T_01: -0.5370 0.0048 -0.0122\n";
// Velodyne: x ahead, y left, z up; camera: x right, y down, z ahead; IMU: as the Velodyne.
constexpr const char* kVeloToCam =
    "calib_time: 15-Mar-2012 11:37:16\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.08 -0.27\n";
constexpr const char* kImuToVelo = "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n";

/// Nanoseconds after the first second of the drive.
std::string TimeText(std::int64_t ns) {
  char text[60];
  std::snprintf(text,
                sizeof(text),
                "2011-09-26 13:02:%02d.%09d\n",
                static_cast<int>(25 + ns / 1000000000),
                static_cast<int>(ns % 1000000000));
  return text;
}
// date -u -d "2011-09-26 13:02:25" +%s
constexpr std::int64_t kFirstNs = 1317042145LL * 1000000000;

std::string FileNumber(int i) {
  char text[20];
  std::snprintf(text, sizeof(text), "%010d", i);
  return text;
}

class KittiRawTest : public ::testing::Test {
 protected:
  KittiRawTest() {
    WriteText(Day() / "calib_cam_to_cam.txt", kCameras);
    WriteText(Day() / "calib_velo_to_cam.txt", kVeloToCam);
    WriteText(Day() / "calib_imu_to_velo.txt", kImuToVelo);
    TestImage image{1392, 512, 1, std::vector<std::uint16_t>(1392 * 512, 90)};
    const std::string png = EncodePng(image);
    for (const char* camera : {"image_00", "image_01"}) {
      std::string times;
      for (int i = 0; i < 4; ++i) {
        times += TimeText(i * 100000000LL);
        WriteText(Drive() / camera / "data" / (FileNumber(i) + ".png"), png);
      }
      WriteText(Drive() / camera / "timestamps.txt", times);
    }
    WriteOxts(10000000, 40);
  }
  fs::path Day() const { return folder_ / "2011_09_26"; }
  fs::path Drive() const { return Day() / "2011_09_26_drive_0001_extract"; }

  /// Sample i has the acceleration (i, 0.5, 9.8) and the rates (0.1, 0.2, i).
  void WriteOxts(std::int64_t interval_ns, int num) const {
    std::string times;
    for (int i = 0; i < num; ++i) {
      times += TimeText(i * interval_ns);
      std::string numbers;
      for (int k = 0; k < 11; ++k)
        numbers += "49.015 ";
      numbers += std::to_string(i) + " 0.5 9.8 7 7 7 0.1 0.2 " + std::to_string(i) + " 7 7 7\n";
      WriteText(Drive() / "oxts/data" / (FileNumber(i) + ".txt"), numbers);
    }
    WriteText(Drive() / "oxts/timestamps.txt", times);
  }

  std::string Complaint() const {
    try {
      StereoDataset dataset(ReadKittiRaw(Drive()));
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }

  TempFolder folder_;
};

TEST_F(KittiRawTest, TheUnsynchronisedVariantIsRead) {
  EXPECT_TRUE(IsKittiRaw(Drive()));
  EXPECT_FALSE(IsKittiRaw(Day()));
  StereoDataset dataset(ReadKittiRaw(Drive()));
  EXPECT_EQ(dataset.name(), "2011_09_26_drive_0001_extract");
  ASSERT_EQ(dataset.frames().size(), 4u);
  EXPECT_EQ(dataset.frames()[3].t.ns, kFirstNs + 300000000);
  EXPECT_TRUE(dataset.frames()[3].HasRight());
  ASSERT_EQ(dataset.imu().size(), 40u);
  EXPECT_EQ(dataset.imu()[7].t.ns, kFirstNs + 70000000);
  EXPECT_EQ(dataset.imu()[7].accel, Vector3d(7, 0.5, 9.8));
  EXPECT_EQ(dataset.imu()[7].gyro, Vector3d(0.1, 0.2, 7));
  EXPECT_THAT(dataset.warnings(), Contains(HasSubstr("noise densities")));
  cv::Mat left, right;
  EXPECT_EQ(dataset.ReadPair(2, left, right), "");
}

TEST_F(KittiRawTest, TransformsAreChainedFromTheImuToTheCameras) {
  const StereoRig rig = ReadKittiRaw(Drive()).calibration.rig;
  // A point 10 m ahead of the IMU, by hand: Velodyne (9.2, 0.3, -0.8), camera 0 (-0.3, 0.72, 8.93).
  const Vector3d p_B(10, 0, 0), p_C0(-0.3, 0.72, 8.93);
  EXPECT_LT((rig.T_BC[0] * p_C0 - p_B).norm(), 1e-12);
  EXPECT_LT((rig.T_BC[1] * (p_C0 + Vector3d(-0.5370, 0.0048, -0.0122)) - p_B).norm(), 1e-12);
}

TEST_F(KittiRawTest, LensesHaveAThirdRadialCoefficient) {
  const CameraModel lens = ReadKittiRaw(Drive()).calibration.rig.cameras[0];
  for (double x = -0.6; x <= 0.6; x += 0.2) {
    for (double y = -0.2; y <= 0.2; y += 0.1) {
      const double r2 = x * x + y * y;
      const double radial =
          1 - 3.728755e-01 * r2 + 2.037299e-01 * r2 * r2 - 7.233722e-02 * r2 * r2 * r2;
      const double p1 = 2.219027e-03, p2 = 1.383707e-03;
      const Vector2d expected(
          984.2439 * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + 690,
          980.8141 * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + 233.1966);
      const auto px = lens.Project(Vector3d(x, y, 1));
      ASSERT_TRUE(px);
      EXPECT_LT((*px - expected).norm(), 1e-9);
    }
  }
}

TEST_F(KittiRawTest, TheSynchronisedVariantIsRefusedWithTheReason) {
  WriteOxts(100000000, 4);
  EXPECT_THAT(Complaint(),
              AllOf(HasSubstr("oxts/timestamps.txt: the IMU has 10.0 Hz"),
                    HasSubstr("synced+rectified"),
                    HasSubstr("_extract")));
}

TEST_F(KittiRawTest, MissingSamplesAndStampsThatDoNotRiseAreCounted) {
  fs::remove(Drive() / "oxts/data" / (FileNumber(5) + ".txt"));
  EditLines(Drive() / "oxts/timestamps.txt",
            [](std::vector<std::string>& lines) { std::swap(lines[8], lines[9]); });
  const RecordingFiles files = ReadKittiRaw(Drive());
  EXPECT_EQ(files.imu.size(), 38u);
  EXPECT_THAT(files.warnings, Contains(HasSubstr("oxts: 2 stamps do not rise or have no file")));
}

TEST_F(KittiRawTest, SaysWhatCannotBeRead) {
  WriteText(Drive() / "image_01/timestamps.txt", "2011-09-26 13:02:25.9\n2011-19-26 13:02:25.9\n");
  EXPECT_THAT(Complaint(), HasSubstr("image_01/timestamps.txt:2: a time such as"));
  WriteText(Drive() / "image_01/timestamps.txt", "2011-09-26 13:02:25.9\n2480-09-26 13:02:25.9\n");
  EXPECT_THAT(Complaint(), HasSubstr("image_01/timestamps.txt:2: a time such as"));
  WriteText(Drive() / "oxts/data/0000000003.txt", "1 2 3 x");
  EXPECT_THAT(Complaint(), HasSubstr("0000000003.txt: 30 numbers of an OXTS unit are expected"));
  WriteOxts(10000000, 40);
  WriteText(Day() / "calib_cam_to_cam.txt", "S_00: 1392 512\n");
  EXPECT_THAT(Complaint(), HasSubstr("calib_cam_to_cam.txt: 'K_00:' with 9 numbers is expected"));
  fs::remove(Day() / "calib_imu_to_velo.txt");
  WriteText(Day() / "calib_cam_to_cam.txt", kCameras);
  EXPECT_THAT(Complaint(), HasSubstr("calib_imu_to_velo.txt: no such file"));
}

}  // namespace
}  // namespace facet
