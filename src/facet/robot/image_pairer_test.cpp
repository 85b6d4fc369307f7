// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/image_pairer.h"

#include <string>

#include <gtest/gtest.h>

namespace facet::robot {
namespace {

constexpr int kLeft = 0, kRight = 1;

/// "10/10 20/-" for pairs of stamps.
class PairerTest : public ::testing::Test {
 protected:
  std::string Add(int camera, std::int64_t t_ns) {
    std::string text;
    for (const ImagePair& pair : pairer_.Add(camera, {t_ns, {}, nullptr})) {
      text += (text.empty() ? "" : " ") + std::to_string(pair.left.t_ns) + "/" +
              (pair.right ? std::to_string(pair.right->t_ns) : "-");
    }
    return text;
  }
  ImagePairer pairer_{3};
};

TEST_F(PairerTest, ImagesOfOneStampAreAPairInEitherOrder) {
  EXPECT_EQ(Add(kLeft, 10), "");
  EXPECT_EQ(Add(kRight, 10), "10/10");
  EXPECT_EQ(Add(kRight, 20), "");
  EXPECT_EQ(Add(kLeft, 20), "20/20");
  EXPECT_EQ(pairer_.counts().lone_left + pairer_.counts().lone_right, 0);
}

TEST_F(PairerTest, TheNearestWithinTheToleranceIsTaken) {
  Add(kRight, 7);
  Add(kRight, 9);
  Add(kRight, 12);
  EXPECT_EQ(Add(kLeft, 10), "10/9");
  EXPECT_EQ(pairer_.counts().lone_right, 1);
  EXPECT_EQ(Add(kLeft, 20), "");
  EXPECT_EQ(Add(kRight, 24), "20/-");
}

TEST_F(PairerTest, ALeftImageWithoutPartnerComesAloneButNotBeforeTheFirstPair) {
  Add(kLeft, 10);
  Add(kLeft, 20);
  EXPECT_EQ(Add(kRight, 20), "20/20");
  Add(kLeft, 30);
  Add(kLeft, 40);
  EXPECT_EQ(Add(kRight, 40), "30/- 40/40");
  EXPECT_EQ(pairer_.counts().lone_left, 2);
}

TEST_F(PairerTest, WhatWaitsIsBounded) {
  Add(kLeft, 10);
  Add(kRight, 10);
  int num_alone = 0;
  for (int i = 2; i < 102; ++i)
    num_alone += Add(kLeft, 10 * i).empty() ? 0 : 1;
  EXPECT_EQ(num_alone, 90) << "ten wait";
  for (int i = 200; i < 300; ++i)
    Add(kRight, 10 * i);
  EXPECT_GE(pairer_.counts().lone_right, 89);
}

TEST_F(PairerTest, ALeftImageDoesNotWaitLongForARightCameraThatHasDied) {
  constexpr std::int64_t k10Hz = 100'000'000;
  Add(kLeft, k10Hz);
  EXPECT_NE(Add(kRight, k10Hz), "");
  EXPECT_EQ(Add(kLeft, 2 * k10Hz), "");
  EXPECT_EQ(Add(kLeft, 3 * k10Hz), "");
  EXPECT_EQ(Add(kLeft, 4 * k10Hz), "");
  EXPECT_EQ(Add(kLeft, 5 * k10Hz), "200000000/-");
}

TEST_F(PairerTest, StampsThatDoNotRiseAreLeftOut) {
  Add(kLeft, 10);
  Add(kLeft, 10);
  Add(kLeft, 5);
  EXPECT_EQ(pairer_.counts().repeated, 2);
  EXPECT_EQ(Add(kRight, 10), "10/10");
}

}  // namespace
}  // namespace facet::robot
