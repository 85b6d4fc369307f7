// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/mcap_writer.h"

#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/io/errors.h"
#include "facet/recording/mcap_file.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

class McapWriterTest : public ::testing::TestWithParam<Compression> {
 protected:
  std::filesystem::path File() const { return folder_ / "a.mcap"; }
  TempFolder folder_;
};

std::vector<std::uint8_t> SomeBytes(int i) {
  Rng rng(static_cast<std::uint64_t>(i));
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(200000 + 7 * i));
  for (std::size_t k = 0; k < bytes.size() / 2; ++k)  // the other half is zero
    bytes[k] = static_cast<std::uint8_t>(rng.Index(256));
  return bytes;
}

TEST_P(McapWriterTest, WhatIsWrittenIsRead) {
  constexpr int kNum = 60;  // 12 MB: three chunks
  {
    McapWriter writer(File(), GetParam());
    const auto left = writer.AddChannel("/left", "sensor_msgs/Image", "uint8 x\n");
    const auto imu = writer.AddChannel("/imu", "sensor_msgs/Imu", "uint8 y\n");
    for (int i = 0; i < kNum; ++i)
      writer.AddMessage(i % 3 == 0 ? left : imu, Timestamp{1000000000LL * i + 7}, SomeBytes(i));
    EXPECT_FALSE(std::filesystem::exists(File())) << "it is not complete";
    writer.Commit();
  }
  EXPECT_FALSE(std::filesystem::exists(File().string() + ".partial"));
  McapFile file(File());
  EXPECT_THAT(file.Warnings(), ::testing::IsEmpty()) << "the summary is good";
  ASSERT_EQ(file.topics().size(), 2u);
  EXPECT_EQ(file.topics()[0].name, "/left");
  EXPECT_EQ(file.topics()[0].type, "sensor_msgs/Image");
  EXPECT_EQ(file.topics()[0].encoding, MessageEncoding::kCdr);
  EXPECT_EQ(file.topics()[0].num_messages, 20u);
  EXPECT_EQ(file.topics()[1].num_messages, 40u);
  EXPECT_EQ(file.IndexedDuration()->ns, 59000000000);
  for (int i = 0; i < kNum; ++i) {
    const auto message = file.Next();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->topic, i % 3 == 0 ? 0u : 1u);
    EXPECT_EQ(message->received.ns, 1000000000LL * i + 7);
    EXPECT_TRUE(std::ranges::equal(message->bytes, SomeBytes(i))) << i;
  }
  EXPECT_FALSE(file.Next());
  const auto size = std::filesystem::file_size(File());
  EXPECT_LT(size, GetParam() == Compression::kZstd ? 7u << 20 : 13u << 20);
}

TEST_P(McapWriterTest, WhatIsNotCompleteLeavesNothing) {
  {
    McapWriter writer(File(), GetParam());
    const auto left = writer.AddChannel("/left", "sensor_msgs/Image", "uint8 x\n");
    for (int i = 0; i < 30; ++i)
      writer.AddMessage(left, Timestamp{i}, SomeBytes(i));
  }
  const auto entries = std::filesystem::directory_iterator(folder_.path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 0);
}

TEST_P(McapWriterTest, PlacesThatCannotBeWrittenAreNamed) {
  EXPECT_THROW(McapWriter(folder_ / "nowhere/a.mcap", GetParam()), OutputError);
}

INSTANTIATE_TEST_SUITE_P(Kinds,
                         McapWriterTest,
                         ::testing::Values(Compression::kNone, Compression::kZstd));

/// Reads the chunk indices of the summary by hand: their offsets lead to chunks and to messages.
TEST(McapWriterIndexTest, IndicesLeadToChunksAndMessages) {
  const TempFolder folder;
  McapWriter writer(folder / "a.mcap", Compression::kNone);
  const auto left = writer.AddChannel("/left", "sensor_msgs/Image", "uint8 x\n");
  for (int i = 0; i < 30; ++i)
    writer.AddMessage(left, Timestamp{i}, SomeBytes(i));
  writer.Commit();
  const std::string bytes = ReadText(folder / "a.mcap");
  const auto number = [&]<class T>(std::uint64_t at, T) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
  };
  constexpr std::uint64_t kHeader = 9, kFooter = kHeader + 20 + 8;
  std::uint64_t at = number(bytes.size() - kFooter + kHeader, std::uint64_t{});
  int num_chunks = 0, num_messages = 0;
  for (; bytes[at] != '\x02'; at += kHeader + number(at + 1, std::uint64_t{})) {
    if (bytes[at] != '\x08') continue;
    ++num_chunks;
    const std::uint64_t content = at + kHeader;
    const auto chunk = number(content + 16, std::uint64_t{});
    EXPECT_EQ(bytes[chunk], '\x06');
    EXPECT_EQ(number(chunk + 1, std::uint64_t{}) + kHeader, number(content + 24, std::uint64_t{}));
    ASSERT_EQ(number(content + 32, std::uint32_t{}), 10u) << "one channel";
    const auto index = number(content + 38, std::uint64_t{});
    ASSERT_EQ(bytes[index], '\x07');
    const auto size = number(index + kHeader + 2, std::uint32_t{});
    const std::uint64_t records = chunk + kHeader + 8 + 8 + 8 + 4 + 4 + 8;
    for (std::uint64_t entry = index + kHeader + 6; entry < index + kHeader + 6 + size;
         entry += 16) {
      const std::uint64_t message = records + number(entry + 8, std::uint64_t{});
      EXPECT_EQ(bytes[message], '\x05');
      EXPECT_EQ(number(message + kHeader + 6, std::uint64_t{}), number(entry, std::uint64_t{}));
      ++num_messages;
    }
  }
  EXPECT_EQ(num_chunks, 2);
  EXPECT_EQ(num_messages, 30);
}

}  // namespace
}  // namespace facet
