// SPDX-License-Identifier: BSD-2-Clause
// The readers of ROS 1 bags, MCAP files and databases on files that are written by hand.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "facet/io/errors.h"
#include "facet/recording/open_recording.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/testing/recording/test_bags.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Messages of two topics with bytes that tell them apart.
std::vector<TestMessage> SomeMessages() {
  std::vector<TestMessage> messages;
  for (int i = 0; i < 50; ++i) {
    const bool is_imu = i % 3 != 0;
    messages.push_back(
        {is_imu ? "/imu" : "/left",
         is_imu ? kImuType : kImageType,
         Timestamp{1000000000LL * i + 7},
         std::string(static_cast<std::size_t>(100 + 10 * i), static_cast<char>('a' + i % 26))});
  }
  return messages;
}

struct ReadMessage {
  std::string topic, type, bytes;
  Timestamp received;
};

std::vector<ReadMessage> ReadAll(MessageSource& source) {
  std::vector<ReadMessage> read;
  while (const auto message = source.Next()) {
    const Topic& topic = source.topics()[message->topic];
    read.push_back({topic.name,
                    topic.type,
                    std::string(message->bytes.begin(), message->bytes.end()),
                    message->received});
  }
  return read;
}

void ExpectSame(const std::vector<ReadMessage>& read, const std::vector<TestMessage>& written) {
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].topic, written[i].topic);
    EXPECT_EQ(read[i].type, written[i].type);
    EXPECT_EQ(read[i].received, written[i].received);
    EXPECT_EQ(read[i].bytes, written[i].bytes);
  }
}

struct BagCase {
  std::string name;
  bool is_mcap;
  TestBagOptions options;
};

class BagFilesTest : public ::testing::TestWithParam<BagCase> {
 protected:
  std::string Bytes() const {
    return GetParam().is_mcap ? McapBytes(SomeMessages(), GetParam().options)
                              : Ros1BagBytes(SomeMessages(), GetParam().options);
  }
  std::filesystem::path Write(const std::string& bytes) const {
    WriteText(folder_ / "a.bag", bytes);
    return folder_ / "a.bag";
  }
  std::string Complaint(const std::string& bytes) const {
    const auto file = Write(bytes);
    try {
      const auto source = OpenMessages(file);
      ReadAll(*source);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  TempFolder folder_;
};

TEST_P(BagFilesTest, GivesTheMessagesInOrderAndAgainAfterRewind) {
  const auto source = OpenMessages(Write(Bytes()));
  EXPECT_EQ(source->Kind(), GetParam().is_mcap ? "MCAP" : "ROS 1 bag");
  ASSERT_EQ(source->topics().size(), 2u);
  for (const Topic& topic : source->topics()) {
    EXPECT_EQ(topic.num_messages, topic.name == "/imu" ? 33u : 17u);
    EXPECT_EQ(topic.encoding, GetParam().is_mcap ? MessageEncoding::kCdr : MessageEncoding::kRos1);
  }
  ASSERT_TRUE(source->IndexedDuration());
  EXPECT_EQ(source->IndexedDuration()->ns, 49000000000);
  ExpectSame(ReadAll(*source), SomeMessages());
  EXPECT_FALSE(source->Next());
  source->Rewind();
  EXPECT_THAT(source->PlaceOf(*source->Next()), HasSubstr("a.bag: at byte "));
  source->Rewind();
  ExpectSame(ReadAll(*source), SomeMessages());
}

TEST_P(BagFilesTest, TruncatedFilesGiveWhatIsThereAndSayWhereTheyEnd) {
  const std::string bytes = Bytes();
  const std::string cut = bytes.substr(0, bytes.size() * 3 / 5);
  const auto source = OpenMessages(Write(cut));
  std::size_t num_read = 0;
  try {
    while (source->Next())
      ++num_read;
    EXPECT_FALSE(GetParam().options.has_index) << "no complaint";
  } catch (const InputError& error) {
    EXPECT_THAT(
        error.what(),
        AllOf(HasSubstr("a.bag: at byte "), HasSubstr("truncated"), HasSubstr("--duration")));
  }
  EXPECT_GE(num_read, 1u);
  EXPECT_LT(num_read, SomeMessages().size());
}

TEST_P(BagFilesTest, AbsurdSizesAreNoticedBeforeMemoryIsTaken) {
  std::string bytes = Bytes();
  const std::string first = std::string(1, GetParam().is_mcap ? '\x05' : '\x02');
  // The length of the first record behind the magic.
  const std::size_t at = GetParam().is_mcap ? 9 : 13;
  for (std::size_t i = at; i < at + 4; ++i)
    bytes[i] = '\xEE';
  EXPECT_THAT(Complaint(bytes), HasSubstr("at byte "));
}

// Raw data of a ROS 1 bag have no checksum; those of MCAP are tested below.
class CompressedBagFilesTest : public BagFilesTest {};

TEST_P(CompressedBagFilesTest, FlippedBitsAreNoticed) {
  std::string bytes = Bytes();
  bytes[bytes.size() / 3] = static_cast<char>(bytes[bytes.size() / 3] ^ 0x10);
  EXPECT_THAT(Complaint(bytes), AllOf(HasSubstr("at byte "), HasSubstr("damaged")));
}

INSTANTIATE_TEST_SUITE_P(
    Kinds,
    BagFilesTest,
    ::testing::Values(BagCase{"ros1", false, {}},
                      BagCase{"ros1_lz4", false, {.compression = Compression::kLz4}},
                      BagCase{"ros1_bz2", false, {.compression = Compression::kBz2}},
                      BagCase{"ros1_unindexed", false, {.has_index = false}},
                      BagCase{
                          "ros1_unchunked", false, {.messages_per_chunk = 0, .has_index = false}},
                      BagCase{"mcap", true, {}},
                      BagCase{"mcap_lz4", true, {.compression = Compression::kLz4}},
                      BagCase{"mcap_zstd", true, {.compression = Compression::kZstd}},
                      BagCase{"mcap_without_summary", true, {.has_index = false}},
                      BagCase{"mcap_counts_first", true, {.are_counts_first = true}},
                      BagCase{"mcap_unchunked", true, {.messages_per_chunk = 0}}),
    [](const ::testing::TestParamInfo<BagCase>& one) { return one.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Kinds,
    CompressedBagFilesTest,
    ::testing::Values(BagCase{"ros1_lz4", false, {.compression = Compression::kLz4}},
                      BagCase{"ros1_bz2", false, {.compression = Compression::kBz2}},
                      BagCase{"mcap_lz4", true, {.compression = Compression::kLz4}},
                      BagCase{"mcap_zstd", true, {.compression = Compression::kZstd}}),
    [](const ::testing::TestParamInfo<BagCase>& one) { return one.param.name; });

TEST(McapFileTest, FlippedBitsInRawChunksAreNoticedByTheChecksum) {
  const TempFolder folder;
  std::string bytes = McapBytes(SomeMessages());
  bytes[bytes.size() / 3] = static_cast<char>(bytes[bytes.size() / 3] ^ 1);
  WriteText(folder / "a.mcap", bytes);
  const auto source = OpenMessages(folder / "a.mcap");
  try {
    ReadAll(*source);
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("damaged chunk"), HasSubstr("checksum")));
  }
}

TEST(Db3FileTest, GivesTheMessagesInOrder) {
  const TempFolder folder;
  WriteDb3(folder / "a.db3", SomeMessages());
  const auto source = OpenMessages(folder / "a.db3");
  EXPECT_EQ(source->Kind(), "ROS 2 bag (sqlite3)");
  ExpectSame(ReadAll(*source), SomeMessages());
  EXPECT_FALSE(source->Next()) << "it must not begin again";
  source->Rewind();
  EXPECT_THAT(source->PlaceOf(*source->Next()), HasSubstr("a.db3: message 1"));
  source->Rewind();
  ExpectSame(ReadAll(*source), SomeMessages());
  EXPECT_EQ(source->IndexedDuration()->ns, 49000000000);
}

TEST(Db3FileTest, NothingIsWrittenBesideADatabaseWithAWriteAheadLog) {
  const TempFolder folder;
  const auto file = folder / "a 100%25 #1?.db3";
  WriteDb3(file, SomeMessages());
  std::string bytes = ReadText(file);
  bytes[18] = bytes[19] = 2;  // "uses a write-ahead log"
  WriteText(file, bytes);
  const auto source = OpenMessages(file);
  ASSERT_TRUE(source->Next());
  const auto entries = std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 1);
  EXPECT_EQ(ReadText(file), bytes);
}

TEST(Db3FileTest, SaysBehindWhichMessageADatabaseIsDamaged) {
  const TempFolder folder;
  std::vector<TestMessage> messages = SomeMessages();
  for (TestMessage& message : messages)
    message.bytes.resize(5000, 'x');
  WriteDb3(folder / "a.db3", messages);
  std::string bytes = ReadText(folder / "a.db3");
  for (std::size_t i = bytes.size() / 2; i < bytes.size(); ++i)
    bytes[i] = '\x55';
  WriteText(folder / "a.db3", bytes);
  try {
    ReadAll(*OpenMessages(folder / "a.db3"));
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("a.db3"), HasSubstr("copy the file again")));
  }
}

TEST(Db3FileTest, OtherDatabasesAreNoBags) {
  const TempFolder folder;
  WriteDb3(folder / "a.db3", SomeMessages());
  ReplaceInFile(folder / "a.db3", "CREATE TABLE topics", "CREATE TABLE xopics");
  EXPECT_THROW(OpenMessages(folder / "a.db3"), InputError);
}

TEST(OpenMessagesTest, SplitBagsAreReadOneFileAfterTheOther) {
  const TempFolder folder;
  const std::vector<TestMessage> all = SomeMessages();
  const std::vector<TestMessage> first(all.begin(), all.begin() + 20);
  const std::vector<TestMessage> second(all.begin() + 20, all.end());
  WriteText(folder / "bag/x_2.mcap", McapBytes(first));
  WriteText(folder / "bag/x_10.mcap", McapBytes(second));
  const auto source = OpenMessages(folder / "bag");
  EXPECT_EQ(source->Kind(), "MCAP, 2 files");
  ExpectSame(ReadAll(*source), all);
  source->Rewind();
  ExpectSame(ReadAll(*source), all);

  WriteText(folder / "bag/metadata.yaml",
            "rosbag2_bagfile_information:\n  relative_file_paths: [x_10.mcap]\n");
  ExpectSame(ReadAll(*OpenMessages(folder / "bag")), second);
}

TEST(OpenMessagesTest, APartThatCannotBeOpenedEndsTheRecording) {
  const TempFolder folder;
  const std::vector<TestMessage> all = SomeMessages();
  const std::vector<TestMessage> first(all.begin(), all.begin() + 20);
  WriteText(folder / "bag/x_0.mcap", McapBytes(first));
  WriteText(folder / "bag/x_1.mcap", "");
  WriteText(folder / "bag/x_2.mcap", McapBytes(first));
  const auto source = OpenMessages(folder / "bag");
  for (int pass = 0; pass < 2; ++pass, source->Rewind()) {
    for (std::size_t i = 0; i < first.size(); ++i)
      ASSERT_TRUE(source->Next());
    try {
      source->Next();
      FAIL() << "no exception";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("x_1.mcap: the file is empty"));
    }
  }
  std::filesystem::remove(folder / "bag/x_0.mcap");
  EXPECT_THROW(OpenMessages(folder / "bag"), InputError);
}

TEST(OpenMessagesTest, APartWithoutMessagesIsNoDamage) {
  const TempFolder folder;
  WriteText(folder / "bag/x_0.mcap", McapBytes(SomeMessages()));
  const std::string magic("\x89MCAP0\r\n", 8);
  const std::string end =
      std::string("\x0F\4\0\0\0\0\0\0\0\0\0\0\0", 13) + '\2' + '\x14' + std::string(7 + 20, '\0');
  WriteText(folder / "bag/x_1.mcap", magic + end + magic);
  ExpectSame(ReadAll(*OpenMessages(folder / "bag")), SomeMessages());
  std::filesystem::remove(folder / "bag/x_0.mcap");
  try {
    OpenMessages(folder / "bag");
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("there is no message in it"));
  }
}

TEST(OpenMessagesTest, NoRecordingHasAnyNumberOfTopics) {
  std::vector<Topic> topics;
  Topic topic;
  for (int i = 0; i < 10000; ++i) {
    topic.name = std::to_string(i);
    topic.num_messages = 3;
    EXPECT_EQ(FindOrAddTopic(topics, topic), static_cast<std::size_t>(i));
  }
  topic.name = "77";
  EXPECT_EQ(FindOrAddTopic(topics, topic), 77u);
  EXPECT_EQ(topics[77].num_messages, 0u);
  topic.type = "other";
  EXPECT_THROW(FindOrAddTopic(topics, topic), InputError);
}

TEST(OpenMessagesTest, SaysWhatIsWrongWithOtherFiles) {
  const TempFolder folder;
  const auto complaint = [&](const std::string& name) -> std::string {
    try {
      OpenMessages(folder / name);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(complaint("nothing.bag"), HasSubstr("no such folder or file"));
  WriteText(folder / "empty.bag", "");
  EXPECT_THAT(complaint("empty.bag"), HasSubstr("the file is empty"));
  WriteText(folder / "text.bag", "hello, hello, hello");
  EXPECT_THAT(complaint("text.bag"), AllOf(HasSubstr("at byte 0"), HasSubstr("damaged")));
  WriteText(folder / "text.txt", "hello, hello, hello");
  EXPECT_THAT(complaint("text.txt"), HasSubstr("unknown kind"));
  WriteText(folder / "a.mcap.zstd", "hello");
  EXPECT_THAT(complaint("a.mcap.zstd"), HasSubstr("zstd -d"));
  ASSERT_EQ(mkfifo((folder / "pipe.mcap").c_str(), 0600), 0);
  EXPECT_THAT(complaint("pipe.mcap"), HasSubstr("neither a file nor a folder"));
  WriteText(folder / "old.bag", "#ROSBAG V1.2\n and more");
  EXPECT_THAT(complaint("old.bag"), HasSubstr("rosbag fix"));
  WriteText(folder / "bag/metadata.yaml", "rosbag2_bagfile_information: {version: 4}\n");
  EXPECT_THAT(complaint("bag"), HasSubstr("relative_file_paths"));
}

}  // namespace
}  // namespace facet
