// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/stereo_pairer.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

using ::testing::ElementsAre;

class StereoPairerTest : public ::testing::Test {
 protected:
  void Left(int t_ms) { Add(0, t_ms); }
  void Right(int t_ms) { Add(1, t_ms); }

  /// The frames that are settled: stamp of the left image, and of the right one if there is one.
  std::vector<std::string> Frames() {
    std::vector<std::string> frames;
    for (; pairer_.Front(); pairer_.Pop()) {
      const RecordedFrame& frame = *pairer_.Front();
      frames.push_back(frame.left->Place() + (frame.HasRight() ? "+" + frame.right->Place() : ""));
    }
    return frames;
  }

  StereoPairer pairer_{Duration{6000000}};
  int received_ms_ = 0;

 private:
  void Add(int camera, int t_ms) {
    received_ms_ = std::max(received_ms_, t_ms);
    pairer_.Add(camera,
                Timestamp{t_ms * 1000000LL},
                std::make_shared<FileImage>(std::to_string(t_ms)),
                Timestamp{received_ms_ * 1000000LL},
                1000);
  }
};

TEST_F(StereoPairerTest, NearestWithinTheTolerance) {
  Left(100);
  EXPECT_THAT(Frames(), ElementsAre()) << "its partner may come";
  Right(95);
  EXPECT_THAT(Frames(), ElementsAre()) << "a nearer one may come";
  Right(102);
  EXPECT_THAT(Frames(), ElementsAre("100+102"));
  Right(155);
  Left(150);
  EXPECT_THAT(Frames(), ElementsAre("150+155"));
  Left(200);
  Right(207);
  EXPECT_THAT(Frames(), ElementsAre("200"));
  Left(205);
  EXPECT_THAT(Frames(), ElementsAre("205+207"));
  EXPECT_THAT(
      pairer_.Warnings(),
      ElementsAre("1 left images have no right image", "1 right images have no left image"));
}

TEST_F(StereoPairerTest, BeginsWithTheFirstPairAndEndsWithMonoFrames) {
  Left(50);
  Left(100);
  Right(100);
  Left(150);
  EXPECT_THAT(Frames(), ElementsAre("100+100"));
  pairer_.End();
  EXPECT_THAT(Frames(), ElementsAre("150"));
  EXPECT_THAT(pairer_.Warnings(),
              ElementsAre("1 left images before the first stereo pair are not used",
                          "1 left images have no right image"));
}

TEST_F(StereoPairerTest, DoesNotWaitForeverForACameraThatHasStopped) {
  Left(100);
  Right(100);
  for (int t = 200; t <= 2300; t += 100)
    Left(t);
  EXPECT_THAT(Frames(), ElementsAre("100+100", "200")) << "2.1 s ago";
}

TEST_F(StereoPairerTest, ImagesOfNothingDoNotWaitInAnyNumber) {
  for (int i = 0; i < 300000; ++i) {
    pairer_.Add(1, Timestamp{i}, std::make_shared<FileImage>("x"), Timestamp{}, 0);
    if (pairer_.Warnings().empty()) continue;
    EXPECT_THAT(pairer_.Warnings(), ElementsAre("1 right images have no left image"));
    return;
  }
  FAIL() << "300000 images wait";
}

TEST_F(StereoPairerTest, DamagedStampsMayBeAnything) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  const auto image = std::make_shared<FileImage>("x");
  pairer_.Add(1, Timestamp{-kMax - 1}, image, Timestamp{kMax}, 0);
  pairer_.Add(1, Timestamp{kMax - 1}, image, Timestamp{-kMax}, 0);
  pairer_.Add(0, Timestamp{kMax}, image, Timestamp{kMax}, 0);
  pairer_.End();
  EXPECT_THAT(Frames(), ElementsAre("x+x"));
}

TEST_F(StereoPairerTest, LateImagesAreLeftOut) {
  Left(100);
  Right(100);
  Left(90);
  Left(100);
  Left(150);
  Right(150);
  EXPECT_THAT(Frames(), ElementsAre("100+100", "150+150"));
  EXPECT_THAT(pairer_.Warnings(),
              ElementsAre("2 images repeat a stamp or come too late and were left out"));
}

}  // namespace
}  // namespace facet
