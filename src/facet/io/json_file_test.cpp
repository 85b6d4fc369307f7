// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/json_file.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

std::string Nested(int depth) {
  return std::string(depth, '[') + std::string(depth, ']');
}

std::string MessageOf(const std::string& text) {
  const TempFolder folder;
  const std::filesystem::path file = folder.path() / "a.json";
  std::ofstream(file) << text;
  try {
    ReadJsonObject(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(JsonFile, TextThatIsNoJsonIsNull) {
  EXPECT_EQ(ParseJson("{\"a\": [1, 2]}")["a"][1], 2);
  EXPECT_TRUE(ParseJson("{\"a\": ").is_null());
  EXPECT_TRUE(ParseJson("").is_null());
  EXPECT_TRUE(ReadJsonFile("/nonexistent").is_null());
}

TEST(JsonFile, DepthHasALimit) {
  EXPECT_TRUE(ParseJson(Nested(100)).is_array());
  EXPECT_TRUE(ParseJson(Nested(101)).is_null());
  EXPECT_TRUE(ParseJson(Nested(10'000'000)).is_null());
  // Brackets in strings are no lists.
  const std::string brackets = "[\"\\\"" + std::string(1000, '[') + "\"]";
  EXPECT_EQ(ParseJson(brackets)[0].get<std::string>().size(), 1001u);
}

// Waiting for a pipe, or reading a device to its end, would never end.
TEST(JsonFile, WhatIsNoFileIsNoJson) {
  const TempFolder folder;
  const auto pipe = folder / "pipe.json";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::filesystem::create_symlink("/dev/zero", folder / "zeros.json");
  for (const char* name : {"pipe.json", "zeros.json", "nothing.json", "."}) {
    EXPECT_TRUE(ReadJsonFile(folder / name).is_null()) << name;
    EXPECT_THROW(ReadJsonObject(folder / name), InputError) << name;
  }
}

TEST(JsonFile, AnObjectThatIsDamagedIsNamed) {
  EXPECT_EQ(MessageOf("{\"frames\": 3}"), "accepted");
  EXPECT_THAT(MessageOf("{\"frames\": 3"), HasSubstr("a.json: is damaged: not JSON from byte 13"));
  EXPECT_THAT(MessageOf(""), HasSubstr("a.json: is damaged: not JSON"));
  EXPECT_THAT(MessageOf("[1]"), HasSubstr("a JSON object is expected"));
  EXPECT_THAT(MessageOf("{\"a\": " + Nested(1'000'000) + "}"), HasSubstr("too deep"));
  EXPECT_THROW(ReadJsonObject("/nonexistent"), InputError);
}

}  // namespace
}  // namespace facet
