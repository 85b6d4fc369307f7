// SPDX-License-Identifier: BSD-2-Clause
#include "facet/faults/fault.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "facet/faults/image_edits.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/io/asl_dataset.h"
#include "facet/io/errors.h"
#include "facet/io/image_reader.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

// A still view: images at 20 Hz from 0 to 0.55 s, an IMU at rest.
class FaultTest : public ::testing::Test {
 protected:
  FaultTest() {
    WriteTestSequence(source_ / "sequence");
    recording_ = ReadRecording(source_ / "sequence");
  }

  AslDataset Written(const std::string& fault) {
    PlantFault(fault, recording_);
    WriteRecording(recording_, out_ / "damaged");
    return AslDataset(out_ / "damaged");
  }

  double SecondsOf(Timestamp t) const { return ToSeconds(t - recording_.images[0].front().t); }

  TempFolder source_, out_;
  RecordingCopy recording_;
};

TEST_F(FaultTest, WithoutAFaultTheCopyIsTheRecording) {
  const AslDataset source(source_ / "sequence");
  WriteRecording(recording_, out_ / "copy");
  AslDataset copy(out_ / "copy");
  ASSERT_EQ(copy.frames().size(), source.frames().size());
  ASSERT_EQ(copy.imu().size(), source.imu().size());
  EXPECT_EQ(copy.imu()[7].t, source.imu()[7].t);
  EXPECT_EQ(copy.imu()[7].accel, source.imu()[7].accel);
  EXPECT_LT((copy.rig().T_C1C0().p - source.rig().T_C1C0().p).norm(), 1e-12);
  EXPECT_EQ(copy.rig().cameras[1].intrinsics().fx, source.rig().cameras[1].intrinsics().fx);
  cv::Mat left, right, left_copy, right_copy;
  AslDataset(source_ / "sequence").ReadPair(3, left, right);
  EXPECT_EQ(copy.ReadPair(3, left_copy, right_copy), "");
  EXPECT_EQ(cv::norm(left, left_copy, cv::NORM_INF), 0);
}

// Images are links to those of the recording: a second one of the same name must not be written
// through the first, nor a copy over an earlier copy.
TEST_F(FaultTest, TheRecordingStaysAsItIs) {
  const auto pixels_of = [&](int pair) {
    cv::Mat left, right;
    EXPECT_EQ(AslDataset(source_ / "sequence").ReadPair(pair, left, right), "");
    return left.clone();
  };
  std::vector<cv::Mat> before;
  for (int i = 0; i < 12; ++i)
    before.push_back(pixels_of(i));
  const RecordingCopy clean = recording_;
  for (const std::string fault : {"stamps_repeated:imu=0,share=0.5", "older:share=1,back=3"}) {
    recording_ = clean;
    Written(fault);
  }
  for (int i = 0; i < 12; ++i)
    EXPECT_EQ(cv::norm(before[static_cast<std::size_t>(i)], pixels_of(i), cv::NORM_INF), 0) << i;
}

TEST_F(FaultTest, AGlitchIsOneSample) {
  const AslDataset damaged = Written("imu_glitch:at=0.2,gyro=35,axis=2");
  int num = 0;
  for (const ImuSample& sample : damaged.imu()) {
    if (sample.gyro.norm() < 1) continue;
    ++num;
    EXPECT_EQ(sample.gyro.z(), 35);
    EXPECT_NEAR(SecondsOf(sample.t), 0.2, 0.0051);
  }
  EXPECT_EQ(num, 1);
}

TEST_F(FaultTest, AScaledImuIsOffByItsPercent) {
  const Vector3d before = recording_.imu[3].accel;
  const AslDataset damaged = Written("imu_scaled:percent=1,deg=0,seed=4");
  const Vector3d after = damaged.imu()[3].accel;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NE(after(axis), before(axis)) << axis;
    EXPECT_NEAR(after(axis), before(axis), 0.04 * std::abs(before(axis))) << axis;
  }
  // The same seed is the same sensor for all samples.
  EXPECT_EQ(damaged.imu()[3].accel, damaged.imu()[4].accel);
}

TEST_F(FaultTest, APauseHasNothing) {
  const AslDataset damaged = Written("pause:at=0.2,length=0.1");
  for (const ImuSample& sample : damaged.imu())
    EXPECT_TRUE(SecondsOf(sample.t) < 0.2 || SecondsOf(sample.t) >= 0.3);
  for (const FrameEntry& frame : damaged.frames())
    EXPECT_TRUE(SecondsOf(frame.t) < 0.2 || SecondsOf(frame.t) >= 0.3);
  EXPECT_EQ(damaged.frames().size(), 10u);
}

TEST_F(FaultTest, OneCameraMayBeMissingOrFrozen) {
  const AslDataset damaged = Written("no_camera:at=0.2,length=0.1,camera=1");
  EXPECT_EQ(std::count_if(damaged.frames().begin(),
                          damaged.frames().end(),
                          [](const FrameEntry& frame) { return !frame.HasRight(); }),
            2);
  PlantFault("frozen:at=0.3,length=0.2,camera=0", recording_);
  EXPECT_EQ(recording_.images[0][7].file, recording_.images[0][6].file);
  EXPECT_EQ(recording_.images[0][9].file, recording_.images[0][6].file);
  EXPECT_NE(recording_.images[0][10].file, recording_.images[0][6].file);
  EXPECT_NE(recording_.images[1][7].file, recording_.images[1][6].file);
}

TEST_F(FaultTest, ImagesComeInAWrongOrder) {
  const RecordingCopy clean = recording_;
  PlantFault("older:share=1,back=3", recording_);
  EXPECT_EQ(recording_.images[0][2].file, clean.images[0][2].file);
  for (std::size_t i = 3; i < clean.images[0].size(); ++i) {
    EXPECT_EQ(recording_.images[0][i].file, clean.images[0][i - 3].file);
    EXPECT_EQ(recording_.images[1][i].file, clean.images[1][i - 3].file);
    EXPECT_EQ(recording_.images[0][i].t, clean.images[0][i].t);
  }
  recording_ = clean;
  PlantFault("exchanged:share=1", recording_);
  for (std::size_t i = 0; i + 1 < clean.images[0].size(); i += 2) {
    for (const std::size_t camera : {0, 1}) {
      EXPECT_EQ(recording_.images[camera][i].file, clean.images[camera][i + 1].file);
      EXPECT_EQ(recording_.images[camera][i + 1].file, clean.images[camera][i].file);
    }
  }
}

TEST_F(FaultTest, ImagesAreEditedWhereTheFaultIs) {
  AslDataset damaged = Written("black:at=0.2,length=0.1,camera=0");
  cv::Mat left, right;
  for (std::size_t i = 0; i < damaged.frames().size(); ++i) {
    ASSERT_EQ(damaged.ReadPair(i, left, right), "");
    EXPECT_EQ(cv::countNonZero(left) == 0, i == 4 || i == 5) << i;
    EXPECT_GT(cv::countNonZero(right), 0);
  }
}

TEST_F(FaultTest, AnObjectMovesThroughBothImages) {
  AslDataset clean(source_ / "sequence");
  AslDataset damaged = Written("object:at=0.1,length=0.3,crossing=0.3,share=0.25");
  cv::Mat left, right, left_clean, right_clean, changed;
  std::vector<double> centres;
  for (const std::size_t i : {std::size_t{2}, std::size_t{5}, std::size_t{7}}) {
    damaged.ReadPair(i, left, right);
    clean.ReadPair(i, left_clean, right_clean);
    changed = left != left_clean;
    EXPECT_NEAR(cv::countNonZero(changed), 0.25 * 160 * 120, 0.03 * 160 * 120);
    std::vector<cv::Point> places;
    cv::findNonZero(changed, places);
    double sum = 0;
    for (const cv::Point& place : places)
      sum += place.x;
    centres.push_back(sum / static_cast<double>(places.size()));
    changed = right != right_clean;
    EXPECT_GT(cv::countNonZero(changed), 0.1 * 160 * 120);
  }
  EXPECT_LT(centres[0] + 20, centres[1]);
  EXPECT_LT(centres[1] + 15, centres[2]);
}

TEST_F(FaultTest, TheCalibrationIsWhatIsWrong) {
  const StereoRig before = recording_.rig;
  const AslDataset damaged = Written("right_turned:axis=1,deg=0.2");
  const Quaterniond turn = before.T_BC[1].q.conjugate() * damaged.rig().T_BC[1].q;
  EXPECT_NEAR(turn.y(), 0.1 * kDegree, 1e-9);
  PlantFault("focal:percent=-1", recording_);
  EXPECT_NEAR(
      recording_.rig.cameras[0].intrinsics().fx, 0.99 * before.cameras[0].intrinsics().fx, 1e-9);
  PlantFault("baseline:percent=100", recording_);
  EXPECT_NEAR(recording_.rig.baseline_m(), 2 * before.baseline_m(), 1e-12);
}

TEST_F(FaultTest, StampsAreWhatIsWrong) {
  const auto num_of = [](const std::vector<ImuSample>& imu, auto is) {
    int num = 0;
    for (std::size_t i = 1; i < imu.size(); ++i)
      num += is(imu[i - 1].t, imu[i].t) ? 1 : 0;
    return num;
  };
  const RecordingCopy before = recording_;
  PlantFault("disordered:imu=1,share=0.05", recording_);
  const double num = static_cast<double>(recording_.imu.size());
  EXPECT_NEAR(
      num_of(recording_.imu, [](Timestamp a, Timestamp b) { return b < a; }), 0.05 * num, 1);
  recording_ = before;
  PlantFault("stamps_repeated:imu=1,share=0.05", recording_);
  EXPECT_NEAR(
      num_of(recording_.imu, [](Timestamp a, Timestamp b) { return b == a; }), 0.05 * num, 1);
  PlantFault("cut:at=0.1,length=0.2", recording_);
  EXPECT_EQ(recording_.images[0].size(), 4u);
  EXPECT_GE(SecondsOf(recording_.imu.front().t), 0);
  recording_ = before;
  PlantFault("clock_jump:at=0.2,ms=30", recording_);
  EXPECT_EQ(recording_.images[0][3].t, before.images[0][3].t);
  EXPECT_NEAR(ToSeconds(recording_.images[1][4].t - before.images[1][4].t), 0.03, 1e-9);
  recording_ = before;
  PlantFault("thinned:imu=0,every=3", recording_);
  ASSERT_EQ(recording_.images[0].size(), 4u);
  EXPECT_EQ(recording_.images[1][1].t, before.images[1][3].t);
  recording_ = before;
  PlantFault("jitter:imu=0,ms=5", recording_);
  EXPECT_NE(recording_.images[0][3].t, before.images[0][3].t);
  EXPECT_EQ(recording_.images[0][3].t, recording_.images[1][3].t);
}

TEST_F(FaultTest, RightImagesMayBeThoseOfEarlierPairs) {
  const RecordingCopy before = recording_;
  PlantFault("right_late:images=2", recording_);
  EXPECT_EQ(recording_.images[1][5].file, before.images[1][3].file);
  EXPECT_EQ(recording_.images[1][5].t, before.images[1][5].t);
  EXPECT_EQ(recording_.images[0][5].file, before.images[0][5].file);
}

TEST_F(FaultTest, TheImuIsWhatIsWrong) {
  const RecordingCopy before = recording_;
  PlantFault("gyro_scaled:percent=5", recording_);
  EXPECT_NEAR(recording_.imu[3].gyro.x(), 1.05 * before.imu[3].gyro.x(), 1e-12);
  PlantFault("gyro_biased:axis=2,bias=0.2", recording_);
  EXPECT_NEAR(recording_.imu[3].gyro.z(), 1.05 * before.imu[3].gyro.z() + 0.2, 1e-12);
  PlantFault("accel_exchanged:axis=2", recording_);
  EXPECT_EQ(recording_.imu[3].accel.x(), before.imu[3].accel.y());
  EXPECT_EQ(recording_.imu[3].accel.z(), before.imu[3].accel.z());
  recording_ = before;
  PlantFault("imu_dead_axis:axis=2,of_gyro=1,value=0.5", recording_);
  EXPECT_EQ(recording_.imu[3].gyro.z(), 0.5);
  EXPECT_EQ(recording_.imu[3].accel, before.imu[3].accel);
  PlantFault("imu_dead_axis:axis=0", recording_);
  EXPECT_EQ(recording_.imu[3].accel.x(), 0);
  recording_ = before;
  PlantFault("accel_scaled:percent=-50", recording_);
  EXPECT_NEAR(recording_.imu[3].accel.norm(), 0.5 * before.imu[3].accel.norm(), 1e-9);
  recording_ = before;
  PlantFault("no_gravity", recording_);
  EXPECT_LT(recording_.imu[3].accel.norm(), 0.5);
  recording_ = before;
  for (std::size_t i = 0; i < recording_.imu.size(); ++i)
    recording_.imu[i].gyro.setConstant(0.01 * static_cast<double>(i));
  const double largest = recording_.imu.back().gyro.x();
  PlantFault("imu_saturated:share=0.5", recording_);
  EXPECT_NEAR(recording_.imu.back().gyro.x(), 0.5 * largest, 0.02);
  EXPECT_NEAR(recording_.imu[5].gyro.x(), 0.05, 1e-12);
}

TEST_F(FaultTest, ImagesAreAsDarkBrightAndDottedAsSaid) {
  const std::string all = ":at=0,length=9,";
  const auto pixels_of = [&](const std::string& fault) {
    RecordingCopy damaged = recording_;
    PlantFault(fault, damaged);
    cv::Mat pixels;
    ImageReader().Read(damaged.images[0][1].file, pixels);
    for (const ImageEdit& edit : damaged.images[0][1].edits)
      edit(pixels);
    return pixels;
  };
  const cv::Mat clean = pixels_of("faded" + all + "contrast=1");
  EXPECT_NEAR(cv::mean(pixels_of("underexposed" + all + "mean=12"))[0], 12, 0.6);
  EXPECT_NEAR(cv::countNonZero(pixels_of("clipped" + all + "share=0.3") == 255) /
                  static_cast<double>(clean.total()),
              0.3,
              0.05);
  EXPECT_NEAR(cv::mean(pixels_of("flicker:change=0.2"))[0], 0.8 * cv::mean(clean)[0], 1);
  cv::Scalar mean, sigma, sigma_clean;
  cv::meanStdDev(clean, mean, sigma_clean);
  cv::meanStdDev(pixels_of("faded" + all + "contrast=0.5"), mean, sigma);
  EXPECT_NEAR(sigma[0], 0.5 * sigma_clean[0], 1);
  cv::meanStdDev(pixels_of("blurred" + all + "sigma=3"), mean, sigma);
  EXPECT_LT(sigma[0], 0.8 * sigma_clean[0]);
  const cv::Mat changed = pixels_of("dots" + all + "grey=40,dots=100") != clean;
  EXPECT_NEAR(cv::countNonZero(changed), 400, 40);
}

TEST_F(FaultTest, AKnockedCameraSeesItsPointsElsewhere) {
  const CameraModel& camera = recording_.rig.cameras[1];
  const Vector3d ray(0.1, -0.2, 1);
  const Matrix3d R = ExpSO3(Vector3d(0.01, -0.02, 0.03)).toRotationMatrix();
  const auto draw = [&](const Vector2d& px) {
    cv::Mat image(camera.height(), camera.width(), CV_8UC1, cv::Scalar(0));
    cv::circle(image,
               {cvRound(px.x() * 16), cvRound(px.y() * 16)},
               4 * 16,
               255,
               cv::FILLED,
               cv::LINE_AA,
               4);
    return image;
  };
  cv::Mat turned = draw(*camera.Project(ray));
  Turned(camera, R)(turned);
  const cv::Mat expected = draw(*camera.Project(R.transpose() * ray));
  const cv::Moments m = cv::moments(turned), n = cv::moments(expected);
  EXPECT_NEAR(m.m10 / m.m00, n.m10 / n.m00, 0.1);
  EXPECT_NEAR(m.m01 / m.m00, n.m01 / n.m00, 0.1);

  AslDataset damaged = Written("knocked:at=0.25,camera=1,deg=1");
  cv::Mat left, right, left_before, right_before;
  AslDataset(source_ / "sequence").ReadPair(9, left_before, right_before);
  EXPECT_EQ(damaged.ReadPair(9, left, right), "");
  EXPECT_EQ(cv::norm(left, left_before, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(right, right_before, cv::NORM_INF), 0);
}

TEST_F(FaultTest, NothingMovesForAShareOfTheTime) {
  PlantFault("still:share=0.5", recording_);
  EXPECT_EQ(recording_.images[0][3].file, recording_.images[0][0].file);
  EXPECT_NE(recording_.images[0].back().file, recording_.images[0][0].file);
  EXPECT_LT(recording_.imu.front().gyro.norm(), 0.02);
}

TEST_F(FaultTest, MountLensAndNoiseOfTheCalibrationAreWhatIsWrong) {
  const StereoRig before = recording_.rig;
  const double density = recording_.imu_noise.accel_noise;
  PlantFault("cameras_turned:axis=1,deg=3", recording_);
  const Quaterniond turn = recording_.rig.T_BC[0].q * before.T_BC[0].q.conjugate();
  EXPECT_NEAR(turn.y(), std::sin(1.5 * kDegree), 1e-9);
  EXPECT_LT((recording_.rig.T_C1C0().p - before.T_C1C0().p).norm(), 1e-12);
  PlantFault("identity_T_BS", recording_);
  EXPECT_LT(recording_.rig.T_BC[0].p.norm(), 1e-12);
  EXPECT_LT((recording_.rig.T_C1C0().p - before.T_C1C0().p).norm(), 1e-12);
  PlantFault("no_distortion:share=0.5", recording_);
  EXPECT_NEAR(recording_.rig.cameras[1].intrinsics().coefficients[0],
              0.5 * before.cameras[1].intrinsics().coefficients[0],
              1e-12);
  PlantFault("densities:gyro=1,accel=100", recording_);
  EXPECT_NEAR(recording_.imu_noise.accel_noise, 100 * density, 1e-12);
}

TEST_F(FaultTest, EveryFaultCanBePlanted) {
  int num = 0;
  for (const std::string& line : Lines(ListFaults())) {
    if (line.starts_with("      ")) continue;
    RecordingCopy damaged = recording_;
    PlantFault(line.substr(2), damaged);  // with its defaults written out
    ++num;
  }
  EXPECT_GE(num, 45);
}

TEST_F(FaultTest, WhatIsNotKnownIsRefused) {
  const auto message = [&](const std::string& fault) {
    try {
      PlantFault(fault, recording_);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(message("gremlin"), HasSubstr("imu_glitch:"));
  EXPECT_THAT(message("black:lenght=3"), HasSubstr("'lenght=3'"));
  EXPECT_THAT(message("black:length=x"), HasSubstr("length=1"));
  EXPECT_THAT(message("imu_glitch:axis=3"), HasSubstr("axis is 0, 1 or 2"));
}

}  // namespace
}  // namespace facet
