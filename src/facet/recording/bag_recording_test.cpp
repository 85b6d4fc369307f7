// SPDX-License-Identifier: BSD-2-Clause
// Bags as recordings: the same events as from the folder that they were made of.
#include "facet/recording/bag_recording.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/asl_dataset.h"
#include "facet/io/errors.h"
#include "facet/recording/folder_recording.h"
#include "facet/recording/frame_decoder.h"
#include "facet/recording/open_recording.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/testing/recording/test_bags.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

/// "imu <stamp>", "pair <stamp>", "mono <stamp>".
std::vector<std::string> Events(Recording& recording) {
  std::vector<std::string> events;
  while (const auto event = recording.Next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      events.push_back("imu " + std::to_string(sample->t.ns));
    } else {
      const auto& frame = std::get<RecordedFrame>(*event);
      events.push_back((frame.HasRight() ? "pair " : "mono ") + std::to_string(frame.t.ns));
    }
  }
  return events;
}

class BagRecordingTest : public ::testing::Test {
 protected:
  BagRecordingTest() { WriteTestSequence(Sequence(), options_); }
  std::filesystem::path Sequence() const { return folder_ / "seq"; }

  std::vector<TestMessage> Messages() const {
    return MessagesOfSequence(Sequence(), MessageEncoding::kCdr);
  }
  std::unique_ptr<Recording> Open(const std::vector<TestMessage>& messages,
                                  bool with_calibration = true) const {
    WriteText(folder_ / "a.mcap", McapBytes(messages));
    RecordingOptions options;
    if (with_calibration) options.calibration.cameras = Sequence();
    return OpenRecording(folder_ / "a.mcap", options);
  }
  std::string Complaint(const std::vector<TestMessage>& messages,
                        bool with_calibration = true) const {
    try {
      Events(*Open(messages, with_calibration));
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }

  TempFolder folder_;
  TestSequenceOptions options_;
};

TEST_F(BagRecordingTest, GivesTheEventsOfTheFolder) {
  FolderRecording folder{AslDataset(Sequence())};
  const std::vector<std::string> expected = Events(folder);
  const auto recording = Open(Messages());
  EXPECT_EQ(recording->name(), "a");
  EXPECT_EQ(Events(*recording), expected);
  EXPECT_FALSE(recording->Next());
  EXPECT_THAT(recording->Warnings(), ::testing::IsEmpty());
  recording->Rewind();
  EXPECT_EQ(Events(*recording), expected);
  EXPECT_NEAR(recording->NumFrames({options_.first_ns}, {options_.first_ns + (1LL << 50)}), 12, 3);

  WriteText(folder_ / "a.bag",
            Ros1BagBytes(MessagesOfSequence(Sequence(), MessageEncoding::kRos1)));
  EXPECT_EQ(Events(*OpenRecording(folder_ / "a.bag", {{Sequence(), {}}, {}})), expected);
}

TEST_F(BagRecordingTest, ATimeOffsetMovesTheFramesAmongTheSamples) {
  for (int i = 0; i < 2; ++i) {
    const auto yaml = Sequence() / "mav0" / ("cam" + std::to_string(i)) / "sensor.yaml";
    ReplaceInFile(yaml, "rate_hz: 20", "timeshift_cam_imu: 0.0125");
  }
  FolderRecording folder{AslDataset(Sequence())};
  EXPECT_EQ(Events(*Open(Messages())), Events(folder));
}

TEST_F(BagRecordingTest, MessagesThatComeLateAreSortedIn) {
  FolderRecording folder{AslDataset(Sequence())};
  std::vector<TestMessage> messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic == "/cam0/image_raw") message.received.ns += 80000000;
    if (message.topic == "/cam1/image_raw") message.received.ns += 30000000;
  }
  std::ranges::stable_sort(messages, {}, &TestMessage::received);
  EXPECT_EQ(Events(*Open(messages)), Events(folder));
}

TEST_F(BagRecordingTest, PixelsAreThoseOfTheFolder) {
  FolderRecording folder{AslDataset(Sequence())};
  const auto bag = Open(Messages());
  const auto first_pair = [](Recording& recording) {
    FrameDecoder decoder(recording.calibration()->rig);
    cv::Mat left, right;
    while (const auto event = recording.Next()) {
      if (const auto* frame = std::get_if<RecordedFrame>(&*event)) {
        EXPECT_EQ(decoder.Decode(*frame, left, right), "");
        break;
      }
    }
    return std::pair(left, right);
  };
  const auto [left, right] = first_pair(folder);
  const auto [bag_left, bag_right] = first_pair(*bag);
  ASSERT_EQ(left.size(), bag_left.size());
  EXPECT_TRUE(std::equal(left.begin<char>(), left.end<char>(), bag_left.begin<char>()));
  EXPECT_TRUE(std::equal(right.begin<char>(), right.end<char>(), bag_right.begin<char>()));
}

TEST_F(BagRecordingTest, CalibrationOfTheMessages) {
  std::vector<TestMessage> messages =
      CalibrationMessagesOfSequence(Sequence(), MessageEncoding::kCdr);
  std::ranges::copy(Messages(), std::back_inserter(messages));
  const auto recording = Open(messages, false);
  ASSERT_NE(recording->calibration(), nullptr);
  const StereoRig& rig = recording->calibration()->rig;
  const StereoRig expected = AslDataset(Sequence()).rig();
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(rig.cameras[i].intrinsics().fx, expected.cameras[i].intrinsics().fx);
    EXPECT_EQ(rig.cameras[i].intrinsics().cy, expected.cameras[i].intrinsics().cy);
    EXPECT_EQ(rig.cameras[i].intrinsics().coefficients,
              expected.cameras[i].intrinsics().coefficients);
    EXPECT_LT((rig.T_BC[i].p - expected.T_BC[i].p).norm(), 1e-12);
    EXPECT_LT(rig.T_BC[i].q.angularDistance(expected.T_BC[i].q), 1e-7);
  }
  EXPECT_THAT(recording->Warnings(), Contains(HasSubstr("noise densities")));

  // One of the two is not enough.
  std::erase_if(messages, [](const TestMessage& m) { return m.topic == "/tf_static"; });
  EXPECT_THAT(Complaint(messages, false),
              AllOf(HasSubstr("carries no calibration"),
                    HasSubstr("no static transform between the left camera (frame 'cam0')"),
                    HasSubstr("--calibration FILE")));
}

TEST_F(BagRecordingTest, WithoutCalibrationOnlyWhereNoneIsNeeded) {
  EXPECT_THAT(Complaint(Messages(), false), HasSubstr("no camera_info beside the left images"));
  RecordingOptions options;
  options.needs_calibration = false;
  const auto recording = OpenRecording(folder_ / "a.mcap", options);
  EXPECT_EQ(recording->calibration(), nullptr);
  FolderRecording folder{AslDataset(Sequence())};
  EXPECT_EQ(Events(*recording), Events(folder));
}

TEST_F(BagRecordingTest, OddStampsAreReported) {
  std::vector<TestMessage> messages = Messages();
  for (TestMessage& message : messages)
    message.received.ns += 100LL * 1000000000;
  EXPECT_THAT(Open(messages)->Warnings(), Contains(HasSubstr("recorded 100.000 s after")));

  messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic != "/imu0") message.received.ns += 300000000;
  }
  std::ranges::stable_sort(messages, {}, &TestMessage::received);
  EXPECT_THAT(Open(messages)->Warnings(), Contains(HasSubstr("calibrate the time offset")));

  messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic != "/imu0") continue;
    const Timestamp microseconds{message.received.ns / 1000};
    const ImuSample sample{microseconds, Vector3d::Zero(), Vector3d::Zero()};
    message.bytes = ImuBytes(MessageEncoding::kCdr, sample, "imu0");
  }
  EXPECT_THAT(Complaint(messages), HasSubstr("do not overlap in time"));
}

TEST_F(BagRecordingTest, StampsOfTheRecorderServeWhereHeadersHaveNone) {
  std::vector<TestMessage> messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic != "/imu0") continue;
    const ImuSample sample{{}, Vector3d::Zero(), Vector3d::Zero()};
    message.bytes = ImuBytes(MessageEncoding::kCdr, sample, "imu0");
  }
  FolderRecording folder{AslDataset(Sequence())};
  const auto recording = Open(messages);
  EXPECT_EQ(Events(*recording), Events(folder));
  EXPECT_THAT(recording->Warnings(), Contains(HasSubstr("/imu0: the messages have no stamps")));
}

TEST_F(BagRecordingTest, ImagesWithoutStampsArePairedByThoseOfTheRecorder) {
  std::vector<TestMessage> messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic == "/imu0") continue;
    if (message.topic == "/cam1/image_raw") message.received.ns += 2000000;
    message.bytes = ImageBytes(
        MessageEncoding::kCdr, {}, "cam", {160, 120, "mono8", std::string(160 * 120, 'x')});
  }
  std::ranges::stable_sort(messages, {}, &TestMessage::received);
  FolderRecording folder{AslDataset(Sequence())};
  const auto recording = Open(messages);
  EXPECT_EQ(Events(*recording), Events(folder));
  EXPECT_NEAR(recording->NumFrames({options_.first_ns}, {options_.first_ns + (1LL << 50)}), 12, 3);
}

TEST_F(BagRecordingTest, CalibrationOfRectifiedImages) {
  std::vector<TestMessage> messages =
      CalibrationMessagesOfSequence(Sequence(), MessageEncoding::kCdr);
  std::ranges::copy(Messages(), std::back_inserter(messages));
  for (TestMessage& message : messages) {
    if (message.type == kImageType) message.topic.replace(6, std::string::npos, "image_rect");
  }
  EXPECT_THAT(Complaint(messages, false), HasSubstr("the images are rectified, but"));

  const Matrix3d R = Eigen::AngleAxisd(0.02, Vector3d::UnitY()).toRotationMatrix();
  for (TestMessage& message : messages) {
    if (message.type != kCameraInfoType) continue;
    CameraInfoMessage info = ReadCameraInfoMessage(
        {reinterpret_cast<const std::uint8_t*>(message.bytes.data()), message.bytes.size()},
        MessageEncoding::kCdr);
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.R.data()) = R;
    info.P = {111, 0, 81, 0, 0, 112, 61, 0, 0, 0, 1, 0};
    message.bytes = CameraInfoBytes(MessageEncoding::kCdr, info);
  }
  const auto recording = Open(messages, false);
  const StereoRig& rig = recording->calibration()->rig;
  const StereoRig raw = AslDataset(Sequence()).rig();
  for (std::size_t i = 0; i < 2; ++i) {
    const CameraIntrinsics& k = rig.cameras[i].intrinsics();
    EXPECT_EQ(k.fx, 111);
    EXPECT_EQ(k.fy, 112);
    EXPECT_EQ(k.cx, 81);
    EXPECT_EQ(k.cy, 61);
    EXPECT_EQ(k.distortion, DistortionModel::kNone);
    // What a raw camera sees in direction x, the rectified one sees in direction R x.
    EXPECT_LT((rig.T_BC[i].R() * R - raw.T_BC[i].R()).norm(), 1e-9);
    EXPECT_LT((rig.T_BC[i].p - raw.T_BC[i].p).norm(), 1e-12);
  }
}

/// As rosbag2 does in its compression mode "message".
TEST_F(BagRecordingTest, MessagesThatAreCompressedOneByOne) {
  std::vector<TestMessage> messages = Messages();
  for (TestMessage& message : messages)
    message.bytes = Compressed(Compression::kZstd, message.bytes);
  WriteDb3(folder_ / "bag/a_0.db3", messages);
  const std::string metadata =
      "rosbag2_bagfile_information:\n  compression_mode: MESSAGE\n  relative_file_paths: "
      "[a_0.db3]\n  compression_format: ";
  WriteText(folder_ / "bag/metadata.yaml", metadata + "zstd\n");
  FolderRecording folder{AslDataset(Sequence())};
  const std::vector<std::string> expected = Events(folder);
  for (const auto& path : {folder_ / "bag", folder_ / "bag/a_0.db3"})
    EXPECT_EQ(Events(*OpenRecording(path, {{Sequence(), {}}, {}})), expected);
  EXPECT_EQ(Events(*Open(messages)), expected) << "in MCAP";

  const auto damaged = std::find_if(messages.begin() + 90, messages.end(), [](const auto& m) {
    return m.topic == "/cam1/image_raw";
  });
  damaged->bytes.resize(damaged->bytes.size() / 2);
  const auto recording = Open(messages);
  const std::vector<std::string> events = Events(*recording);
  EXPECT_EQ(std::ranges::count_if(events, [](const auto& e) { return e.starts_with("mono"); }), 1);
  EXPECT_THAT(recording->Warnings(), Contains(HasSubstr("1 messages are damaged")));

  WriteText(folder_ / "bag/metadata.yaml", metadata + "lz5\n");
  try {
    OpenRecording(folder_ / "bag");
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("metadata.yaml:4"), HasSubstr("'lz5'")));
  }
}

TEST_F(BagRecordingTest, DamagedMessagesAreLeftOutAndCounted) {
  std::vector<TestMessage> messages = Messages();
  auto damaged = std::ranges::find(messages, "/cam1/image_raw", &TestMessage::topic);
  damaged = std::find_if(damaged + 1, messages.end(), [](const TestMessage& m) {
    return m.topic == "/cam1/image_raw";
  });
  damaged->bytes.resize(50);
  const auto recording = Open(messages);
  const std::vector<std::string> events = Events(*recording);
  EXPECT_EQ(std::ranges::count_if(events, [](const auto& e) { return e.starts_with("mono"); }), 1);
  EXPECT_THAT(
      recording->Warnings(),
      Contains(AllOf(HasSubstr("1 messages are damaged"), HasSubstr(": /cam1/image_raw: "))));
}

// In a folder and in a bag.
TEST_F(BagRecordingTest, OneStampFarInTheFutureCostsWhatCarriesIt) {
  constexpr std::int64_t kYear = 365LL * 86400 * 1000000000;
  const std::pair<const char*, const char*> streams[] = {
      {"/cam0/image_raw", "cam0"}, {"/cam1/image_raw", "cam1"}, {"/imu0", "imu0"}};
  FolderRecording clean{AslDataset(Sequence())};
  const std::size_t num_clean = Events(clean).size();
  for (const auto& [topic, folder_name] : streams) {
    for (const int place : {0, 4}) {
      WriteTestSequence(Sequence(), options_);
      std::vector<TestMessage> messages = Messages();
      int number = 0;
      for (TestMessage& message : messages) {
        if (message.topic != topic || number++ != place) continue;
        const Timestamp t = message.received + Duration{kYear};
        message.bytes =
            message.topic == "/imu0"
                ? ImuBytes(MessageEncoding::kCdr, {t, Vector3d::Zero(), Vector3d::Zero()}, "imu0")
                : ImageBytes(MessageEncoding::kCdr,
                             t,
                             "cam",
                             {160, 120, "mono8", std::string(160 * 120, 'x')});
      }
      EditLines(Sequence() / "mav0" / folder_name / "data.csv",
                [&](std::vector<std::string>& lines) {
                  std::string& line = lines[static_cast<std::size_t>(1 + place)];
                  const std::int64_t ns = std::stoll(line.substr(0, 19)) + kYear;
                  line.replace(0, 19, std::to_string(ns));
                });
      const AslDataset dataset(Sequence());
      EXPECT_THAT(dataset.warnings(),
                  Contains(AllOf(HasSubstr(std::string(folder_name) +
                                           "/data.csv:" + std::to_string(2 + place) + ": 1 of "),
                                 HasSubstr("far away"))));
      FolderRecording folder{AslDataset(Sequence())};
      const auto bag = Open(messages);
      const std::vector<std::string> events = Events(*bag);
      EXPECT_EQ(events, Events(folder)) << topic << place;
      EXPECT_GE(events.size() + 1, num_clean) << topic << place;
      EXPECT_THAT(bag->Warnings(), Contains(HasSubstr("far away")));
    }
  }
}

TEST_F(BagRecordingTest, WhatCameBeforeTheDamageIsGiven) {
  FolderRecording folder{AslDataset(Sequence())};
  const std::vector<std::string> all = Events(folder);
  std::string bytes = McapBytes(Messages());
  WriteText(folder_ / "cut.mcap", bytes.substr(0, bytes.size() * 2 / 3));
  const auto recording = OpenRecording(folder_ / "cut.mcap", {{Sequence(), {}}, {}});
  std::size_t num = 0;
  bool has_ended = false;
  try {
    for (; recording->Next(); ++num) {
    }
  } catch (const InputError& error) {
    has_ended = true;
    EXPECT_THAT(error.what(), AllOf(HasSubstr("cut.mcap: at byte"), HasSubstr("truncated")));
  }
  EXPECT_TRUE(has_ended);
  EXPECT_GT(num, all.size() / 2);
  EXPECT_LT(num, all.size() * 3 / 4);
}

TEST_F(BagRecordingTest, SaysWhyARecordingCannotBeUsed) {
  std::vector<TestMessage> messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic != "/cam1/image_raw") continue;
    const Timestamp shifted = message.received + Duration{20000000};
    message.bytes = ImageBytes(
        MessageEncoding::kCdr, shifted, "cam1", {160, 120, "mono8", std::string(160 * 120, 'x')});
  }
  EXPECT_THAT(Complaint(messages), HasSubstr("no image of /cam1/image_raw has the stamp"));
  messages = Messages();
  for (TestMessage& message : messages) {
    if (message.topic != "/cam0/image_raw") continue;
    message.bytes = ImageBytes(
        MessageEncoding::kCdr, message.received, "cam0", {80, 60, "mono8", std::string(4800, 'x')});
  }
  EXPECT_THAT(Complaint(messages),
              AllOf(HasSubstr("80 x 60 pixels, the calibration of cam0 has 160 x 120"),
                    HasSubstr("at byte "),
                    HasSubstr(": /cam0/image_raw: ")));
  messages = Messages();
  std::erase_if(messages, [](const TestMessage& m) { return m.topic == "/imu0"; });
  EXPECT_THAT(Complaint(messages), HasSubstr("no topic of type sensor_msgs/Imu"));
}

}  // namespace
}  // namespace facet
