// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/view_board.h"

#include <vector>

#include <gtest/gtest.h>

namespace facet {
namespace {

std::vector<std::string> AllAfter(const ViewBoard& board, std::uint64_t number) {
  std::vector<std::string> messages;
  while (const auto next = board.NextAfter(number)) {
    messages.push_back(*next->message);
    number = next->number;
  }
  return messages;
}

TEST(ViewBoard, ALateClientGetsTheNewestOfEachSlotInTheOrderOfPosting) {
  ViewBoard board;
  board.Post("hello", "h");
  board.Post("mesh", "m1");
  board.Post("planes", "p1");
  board.Post("mesh", "m2");
  EXPECT_EQ(AllAfter(board, 0), (std::vector<std::string>{"h", "p1", "m2"}));
}

TEST(ViewBoard, ASlowClientSkipsWhatWasReplaced) {
  ViewBoard board;
  board.Post("mesh", "m0");
  const auto first = board.NextAfter(0);
  ASSERT_TRUE(first);
  for (int i = 1; i <= 1000; ++i)
    board.Post("mesh", "m" + std::to_string(i));
  EXPECT_EQ(AllAfter(board, first->number), (std::vector<std::string>{"m1000"}));
  EXPECT_EQ(board.num_slots(), 1u);
  EXPECT_EQ(board.num_bytes(), 5u);
  EXPECT_EQ(*first->message, "m0");  // still whole for the one who sends it
}

TEST(ViewBoard, WhatComesFirstIsFollowedByEverythingElseAnew) {
  ViewBoard board;
  board.Post("hello", "h1");
  board.Post("mesh", "m");
  board.Post("planes", "p");
  const std::uint64_t newest = 3;
  board.PostFirst("hello", "h2");
  const std::vector<std::string> all = {"h2", "m", "p"};
  EXPECT_EQ(AllAfter(board, 0), all);
  EXPECT_EQ(AllAfter(board, newest), all);
  board.Remove("planes");
  EXPECT_EQ(board.num_bytes(), 3u);
}

TEST(ViewBoard, ARemovedSlotIsEmpty) {
  ViewBoard board;
  board.Post("mesh", "m");
  board.Remove("mesh");
  board.Remove("mesh");
  EXPECT_FALSE(board.NextAfter(0));
  EXPECT_EQ(board.num_bytes(), 0u);
}

}  // namespace
}  // namespace facet
