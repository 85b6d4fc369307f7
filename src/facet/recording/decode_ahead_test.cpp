// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/decode_ahead.h"

#include <atomic>
#include <new>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "facet/base/check.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr int kWidth = 64, kHeight = 48;

StereoRig SmallRig() {
  CameraIntrinsics lens;
  lens.width = kWidth;
  lens.height = kHeight;
  lens.fx = lens.fy = 50;
  lens.cx = 32;
  lens.cy = 24;
  StereoRig rig;
  rig.cameras = {CameraModel(lens), CameraModel(lens)};
  return rig;
}

enum class Kind { kGood, kDamaged, kTooLarge };

/// Takes its time, as a real one does, and counts.
class SlowImage : public EncodedImage {
 public:
  SlowImage(int value, Kind kind, std::atomic<int>& num_decoded)
      : value_(value), kind_(kind), num_decoded_(num_decoded) {}

  cv::Size Decode(const cv::Size& wanted, ImageReader& /*reader*/, cv::Mat& grey) const override {
    ++num_decoded_;
    if (kind_ == Kind::kDamaged) throw InputError(Place() + ": damaged");
    if (kind_ == Kind::kTooLarge) throw std::bad_alloc();
    if (grey.u != nullptr && grey.u->refcount > 1) grey.release();
    grey.create(wanted, CV_8UC1);
    for (int turn = 0; turn < 1 + value_ % 7; ++turn) {
      for (int y = 0; y < grey.rows; ++y) {
        for (int x = 0; x < grey.cols; ++x)
          grey.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value_ + x * y);
      }
    }
    return wanted;
  }
  std::string Place() const override { return "image " + std::to_string(value_); }

 private:
  int value_;
  Kind kind_;
  std::atomic<int>& num_decoded_;
};

class DecodeAheadTest : public ::testing::Test {
 protected:
  /// Some have no right image, some left or right ones are damaged.
  RecordedFrame Frame(int i, Kind left = Kind::kGood) {
    RecordedFrame frame;
    frame.t = Timestamp{i};
    if (i % 11 == 5) left = Kind::kDamaged;
    frame.left = std::make_shared<SlowImage>(i, left, num_decoded_);
    if (i % 7 != 3) {
      const Kind right = i % 5 == 2 ? Kind::kDamaged : Kind::kGood;
      frame.right = std::make_shared<SlowImage>(i + 100, right, num_decoded_);
    }
    return frame;
  }

  const StereoRig rig_ = SmallRig();
  std::atomic<int> num_decoded_ = 0;
};

bool AreEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && (a.empty() || cv::countNonZero(a != b) == 0);
}

void ExpectEqual(const DecodedFrame& a, const DecodedFrame& b, int i) {
  EXPECT_EQ(a.left_problem, b.left_problem) << i;
  EXPECT_EQ(a.right_problem, b.right_problem) << i;
  if (!a.left_problem.empty()) return;
  EXPECT_TRUE(AreEqual(a.left, b.left)) << i;
  EXPECT_TRUE(AreEqual(a.right, b.right)) << i;
}

TEST_F(DecodeAheadTest, GivesWhatOneThreadGivesInTheSameOrder) {
  constexpr int kNum = 120;
  for (const int num_threads : {1, 2, 5}) {
    FrameDecoder decoder(rig_);
    DecodeAhead ahead(rig_, num_threads);
    DecodedFrame expected, decoded;
    int num_added = 0;
    for (int i = 0; i < kNum; ++i) {
      while (num_added < kNum && ahead.num_under_way() < ahead.capacity())
        ahead.Add(Frame(num_added++));
      ahead.Take(decoded);
      decoder.Decode(Frame(i), expected);
      ExpectEqual(decoded, expected, i);
    }
    EXPECT_EQ(ahead.num_under_way(), 0);
  }
}

TEST_F(DecodeAheadTest, LeavesImagesAloneThatSomebodyKeeps) {
  DecodeAhead ahead(rig_, 2);
  DecodedFrame decoded;
  std::vector<std::pair<int, cv::Mat>> kept;
  int num_added = 0;
  for (int i = 0; i < 60; ++i) {
    while (ahead.num_under_way() < ahead.capacity())
      ahead.Add(Frame(num_added++));
    ahead.Take(decoded);
    if (decoded.left_problem.empty() && i % 3 == 0) kept.emplace_back(i, decoded.left);
  }
  FrameDecoder decoder(rig_);
  for (const auto& [i, left] : kept) {
    DecodedFrame expected;
    decoder.Decode(Frame(i), expected);
    EXPECT_TRUE(AreEqual(left, expected.left)) << i;
  }
}

TEST_F(DecodeAheadTest, TakesNoMoreFramesThanItsCapacity) {
  DecodeAhead ahead(rig_, 2);
  EXPECT_LE(ahead.capacity(), 8);
  for (int i = 0; i < ahead.capacity(); ++i)
    ahead.Add(Frame(i));
  EXPECT_THROW(ahead.Add(Frame(0)), CheckError);
  DecodedFrame decoded;
  ahead.Take(decoded);
  EXPECT_NO_THROW(ahead.Add(Frame(0)));
}

TEST_F(DecodeAheadTest, MayEndWithFramesUnderWay) {
  for (int trial = 0; trial < 20; ++trial) {
    DecodeAhead ahead(rig_, 1 + trial % 3);
    for (int i = 0; i < ahead.capacity(); ++i)
      ahead.Add(Frame(i));
  }
  const int num_at_end = num_decoded_;
  EXPECT_LE(num_at_end, 20 * 7 * 2) << "each image at most once";
}

TEST_F(DecodeAheadTest, WithoutMemoryTheFrameConcernedThrows) {
  DecodeAhead ahead(rig_, 2);
  ahead.Add(Frame(0));
  ahead.Add(Frame(1, Kind::kTooLarge));
  ahead.Add(Frame(4));
  DecodedFrame decoded;
  EXPECT_NO_THROW(ahead.Take(decoded));
  EXPECT_THROW(ahead.Take(decoded), std::bad_alloc);
  EXPECT_NO_THROW(ahead.Take(decoded));
  EXPECT_EQ(decoded.left.at<std::uint8_t>(0, 0), 4);
}

}  // namespace
}  // namespace facet
