// SPDX-License-Identifier: BSD-2-Clause
// Small made-up recordings of a camera that turns before a wall, in memory.
#include "facet/check/check_recording.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "facet/base/random.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;

/// Pixels in memory.
class MemoryImage : public EncodedImage {
 public:
  explicit MemoryImage(cv::Mat pixels) : pixels_(std::move(pixels)) {}
  cv::Size Decode(const cv::Size&, ImageReader&, cv::Mat& grey) const override {
    pixels_.copyTo(grey);
    return pixels_.size();
  }
  std::string Place() const override { return "memory"; }

 private:
  cv::Mat pixels_;
};

class MemoryRecording : public Recording {
 public:
  std::vector<RecordingEvent> events;
  StampCounts images_left_out, imu_left_out;
  bool is_damaged = false;

  const std::string& name() const override { return name_; }
  const Calibration* calibration() const override { return nullptr; }
  std::optional<RecordingEvent> Next() override {
    if (next_ == events.size() && is_damaged) throw InputError("memory: torn");
    if (next_ == events.size()) return std::nullopt;
    return events[next_++];
  }
  void Rewind() override { next_ = 0; }
  int NumFrames(Timestamp, Timestamp) const override {
    return static_cast<int>(
        std::ranges::count_if(events, [](const RecordingEvent& e) { return e.index() == 1; }));
  }
  std::vector<std::string> Warnings() const override { return {"something odd"}; }
  StampCounts ImagesLeftOut() const override { return images_left_out; }
  StampCounts ImuLeftOut() const override { return imu_left_out; }

 private:
  std::string name_ = "memory";
  std::size_t next_ = 0;
};

/// Blobs of all sizes, wider than what the camera sees.
cv::Mat Wall() {
  Rng rng(3);
  cv::Mat wall(400, 900, CV_8UC1, cv::Scalar(110));
  for (int i = 0; i < 4000; ++i) {
    const cv::Point centre(rng.Index(wall.cols), rng.Index(wall.rows));
    cv::circle(wall, centre, 1 + rng.Index(7), cv::Scalar(40 + rng.Index(160)), cv::FILLED);
  }
  return wall;
}

/// 8 s at 20 Hz beside an IMU of 200 Hz.
void Fill(MemoryRecording& recording) {
  static const cv::Mat wall = Wall();
  Rng rng(4);
  constexpr int kNumFrames = 160, kSamplesPerFrame = 10;
  const auto angle = [](double t_s) { return 0.5 * std::sin(1.5 * t_s); };
  for (int i = 0; i < kNumFrames * kSamplesPerFrame; ++i) {
    const double t_s = 0.005 * i;
    const Timestamp t = Timestamp{1000000000} + FromSeconds(t_s);
    const double rate = (angle(t_s + 0.001) - angle(t_s - 0.001)) / 0.002;
    ImuSample sample{t, 0.002 * rng.Normal3(), 0.02 * rng.Normal3()};
    sample.gyro.y() += rate;
    sample.accel.z() += kGravity;
    recording.events.emplace_back(sample);
    if (i % kSamplesPerFrame != 0) continue;
    cv::Mat pixels = wall(cv::Rect(290 + static_cast<int>(500 * angle(t_s)), 40, 320, 240)).clone();
    for (int k = 0; k < 2000; ++k)  // noise enough for images at rest to differ
      pixels.at<std::uint8_t>(rng.Index(240), rng.Index(320)) += 2;
    const auto image = std::make_shared<MemoryImage>(pixels);
    recording.events.emplace_back(RecordedFrame{t, t, image, image});
  }
}

std::vector<std::string> NamesOf(MemoryRecording& recording) {
  std::vector<std::string> names;
  for (const Finding& finding : CheckRecording(recording).findings) {
    // There is none in any of these.
    if (finding.name != "no_calibration") names.push_back(finding.name);
  }
  return names;
}

template <class Edit>
void EditPixels(MemoryRecording& recording, const Edit& edit) {
  int number = 0;
  for (RecordingEvent& event : recording.events) {
    auto* frame = std::get_if<RecordedFrame>(&event);
    if (frame == nullptr) continue;
    cv::Mat pixels;
    ImageReader reader;
    frame->left->Decode({}, reader, pixels);
    edit(pixels, number++);
    frame->left = std::make_shared<MemoryImage>(pixels);
  }
}

TEST(CheckRecordingTest, AGoodOneHasNoFindings) {
  MemoryRecording recording;
  Fill(recording);
  EXPECT_THAT(NamesOf(recording), IsEmpty());
  recording.Rewind();
  const CheckReport report = CheckRecording(recording);
  EXPECT_TRUE(report.Has("no_calibration"));
  EXPECT_EQ(report.num_frames, 160);
  EXPECT_EQ(report.num_looked_at, 160);
  EXPECT_EQ(report.num_imu, 1600);
  EXPECT_THAT(report.notes, Contains("something odd"));
}

TEST(CheckRecordingTest, StampsThatWereLeftOutAreCounted) {
  MemoryRecording recording;
  Fill(recording);
  recording.imu_left_out.num_backward = 16;
  recording.images_left_out.num_repeated = 3;
  EXPECT_THAT(NamesOf(recording), Contains("stamps_backward"));
  recording.Rewind();
  EXPECT_THAT(NamesOf(recording), Contains("stamps_repeated"));
}

TEST(CheckRecordingTest, DamageIsAFindingBehindWhatWasRead) {
  MemoryRecording recording;
  Fill(recording);
  recording.is_damaged = true;
  const CheckReport report = CheckRecording(recording);
  EXPECT_TRUE(report.Has("damaged"));
  EXPECT_EQ(report.num_frames, 160);
}

TEST(CheckRecordingTest, HolesOfTheStreamsAreNamed) {
  MemoryRecording recording;
  Fill(recording);
  const Timestamp begin = Timestamp{1000000000} + FromSeconds(3);
  std::erase_if(recording.events, [&](const RecordingEvent& event) {
    const auto* sample = std::get_if<ImuSample>(&event);
    return sample != nullptr && sample->t > begin && ToSeconds(sample->t - begin) < 0.1;
  });
  EXPECT_THAT(NamesOf(recording), Contains("imu_gap"));
  recording.Rewind();
  std::erase_if(recording.events, [&](const RecordingEvent& event) {
    const auto* frame = std::get_if<RecordedFrame>(&event);
    return frame != nullptr && frame->t > begin && ToSeconds(frame->t - begin) < 0.5;
  });
  EXPECT_THAT(NamesOf(recording), Contains("image_gap"));
}

TEST(CheckRecordingTest, UnitsOfTheAccelerometerAreNamed) {
  MemoryRecording recording;
  Fill(recording);
  for (RecordingEvent& event : recording.events) {
    if (auto* sample = std::get_if<ImuSample>(&event)) sample->accel /= kGravity;
  }
  const CheckReport report = CheckRecording(recording);
  ASSERT_TRUE(report.Has("accel_scale"));
  EXPECT_THAT(report.findings.back().what, ::testing::HasSubstr("in g"));
}

TEST(CheckRecordingTest, TheEndOfARangeIsNamed) {
  MemoryRecording recording;
  Fill(recording);
  for (RecordingEvent& event : recording.events) {
    if (auto* sample = std::get_if<ImuSample>(&event))
      sample->gyro = sample->gyro.cwiseMin(0.7).cwiseMax(-0.7);
  }
  EXPECT_THAT(NamesOf(recording), Contains("imu_saturated"));
}

TEST(CheckRecordingTest, ADeadAxisIsNamed) {
  MemoryRecording recording;
  Fill(recording);
  Rng rng(5);
  for (RecordingEvent& event : recording.events) {
    auto* sample = std::get_if<ImuSample>(&event);
    if (sample == nullptr) continue;
    sample->gyro += 0.05 * rng.Normal3();
    sample->accel += 0.2 * rng.Normal3();
  }
  EXPECT_THAT(NamesOf(recording), Not(Contains("imu_dead_axis")));
  recording.Rewind();
  for (RecordingEvent& event : recording.events) {
    if (auto* sample = std::get_if<ImuSample>(&event)) sample->accel.x() = 0;
  }
  const CheckReport report = CheckRecording(recording);
  const auto dead = std::ranges::find(report.findings, "imu_dead_axis", &Finding::name);
  ASSERT_NE(dead, report.findings.end());
  EXPECT_THAT(dead->what, ::testing::HasSubstr("axis x of the accelerometer"));
}

TEST(CheckRecordingTest, WhatIsWrongWithImagesIsNamed) {
  struct Case {
    const char* name;
    void (*edit)(cv::Mat& pixels, int number);
  };
  const Case cases[] = {
      {"too_dark", [](cv::Mat& p, int) { p.convertTo(p, CV_8U, 0.1); }},
      {"too_bright", [](cv::Mat& p, int) { p.convertTo(p, CV_8U, 2.6); }},
      {"flicker", [](cv::Mat& p, int i) { p.convertTo(p, CV_8U, i % 2 == 0 ? 1 : 0.8); }},
      {"unequal_brightness", [](cv::Mat& p, int) { p.convertTo(p, CV_8U, 0.4); }},
      {"blur",
       [](cv::Mat& p, int) {
         cv::GaussianBlur(p, p, {0, 0}, 3);
       }},
      {"no_texture", [](cv::Mat& p, int) { p.convertTo(p, CV_8U, 0.02, 100); }},
      {"covered", [](cv::Mat& p, int) { p.rowRange(160, 240).setTo(12); }},
      {"fixed_pattern",
       [](cv::Mat& p, int) {
         Rng rng(8);
         for (int k = 0; k < 600; ++k)
           p(cv::Rect(rng.Index(318), rng.Index(238), 2, 2)) += 50;
       }},
      {"image_noise",
       [](cv::Mat& p, int i) {
         cv::RNG rng(static_cast<std::uint64_t>(i) + 1);
         cv::Mat noise(p.size(), CV_16S), sum;
         rng.fill(noise, cv::RNG::NORMAL, 0, 15);
         p.convertTo(sum, CV_16S);
         sum += noise;
         sum.convertTo(p, CV_8U);
       }},
      {"images_repeated",
       [](cv::Mat& p, int i) {
         static cv::Mat last;
         if (i % 10 == 5) last.copyTo(p);
         last = p.clone();
       }},
  };
  for (const Case& c : cases) {
    MemoryRecording recording;
    Fill(recording);
    EditPixels(recording, c.edit);
    EXPECT_THAT(NamesOf(recording), Contains(c.name));
  }
}

TEST(CheckRecordingTest, StandingStillIsNamed) {
  MemoryRecording recording;
  Fill(recording);
  cv::Mat first;
  EditPixels(recording, [&](cv::Mat& pixels, int number) {
    if (number == 0) first = pixels.clone();
    first.copyTo(pixels);
    pixels.at<std::uint8_t>(5, number % 300) += 3;
  });
  for (RecordingEvent& event : recording.events) {
    if (auto* sample = std::get_if<ImuSample>(&event)) sample->gyro.setConstant(0.001);
  }
  const std::vector<std::string> names = NamesOf(recording);
  EXPECT_THAT(names, Contains("standing_still"));
  EXPECT_THAT(names, Not(Contains("images_repeated")));
}

}  // namespace
}  // namespace facet
