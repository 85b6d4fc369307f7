// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/csv_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::ElementsAre;

std::vector<std::vector<std::string>> ReadRows(const std::string& text) {
  TempFolder folder;
  WriteText(folder / "table.csv", text);
  CsvReader reader(folder / "table.csv");
  std::vector<std::vector<std::string>> rows;
  while (reader.Next())
    rows.emplace_back(reader.fields().begin(), reader.fields().end());
  return rows;
}

TEST(CsvReaderTest, CopesWithEveryHeaderAndLineEnd) {
  for (const char* head : {"",
                           "#timestamp [ns],x\n",
                           "# ts , x\r\n",
                           "timestamp,x\n",
                           "\xEF\xBB\xBF#t,x\n",
                           "%t\n\n"}) {
    EXPECT_THAT(ReadRows(std::string(head) + "1, a \r\n\r\n# note\n2,b"),
                ElementsAre(ElementsAre("1", "a"), ElementsAre("2", "b")))
        << head;
  }
}

TEST(CsvReaderTest, SplitsAtCommasOrBlanks) {
  EXPECT_THAT(ReadRows("1,,3,\n"), ElementsAre(ElementsAre("1", "", "3", "")));
  EXPECT_THAT(ReadRows(" 1  2\t3 \n"), ElementsAre(ElementsAre("1", "2", "3")));
}

TEST(CsvReaderTest, OnlyTheFirstRowMayBeAHeader) {
  EXPECT_EQ(ReadRows("1,2\nbroken,line\n").size(), 2u);
}

TEST(CsvReaderTest, KnowsItsLine) {
  TempFolder folder;
  WriteText(folder / "t.csv", "#head\n\n5,6\n");
  CsvReader reader(folder / "t.csv");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.line(), 3);
  EXPECT_EQ(reader.Where(), (folder / "t.csv").string() + ":3");
  EXPECT_FALSE(reader.Next());
}

TEST(CsvReaderTest, MissingFileAndFolderAreErrors) {
  TempFolder folder;
  EXPECT_THROW(CsvReader(folder / "nothing.csv"), InputError);
  EXPECT_THROW(CsvReader(folder.path()), InputError);
}

TEST(ParseTest, NumbersMustFillTheText) {
  EXPECT_EQ(ParseInteger("-17"), -17);
  EXPECT_EQ(ParseInteger("+17"), 17);
  EXPECT_FALSE(ParseInteger("17x"));
  EXPECT_FALSE(ParseInteger("1.0"));
  EXPECT_FALSE(ParseInteger(""));
  EXPECT_FALSE(ParseInteger("9223372036854775808"));
  EXPECT_EQ(ParseDouble("+1.5e3"), 1500.0);
  EXPECT_TRUE(std::isnan(*ParseDouble("nan")));
  EXPECT_FALSE(ParseDouble("+-1"));
  EXPECT_FALSE(ParseDouble("1,5"));
}

TEST(ParseTest, ScaledDecimalIsExact) {
  EXPECT_EQ(ParseScaledDecimal("1403636584.763555584", 9), 1403636584763555584);
  EXPECT_EQ(ParseScaledDecimal("1.403715529112143517e+09", 9), 1403715529112143517);
  EXPECT_EQ(ParseScaledDecimal("1403715529112143517.000000", 0), 1403715529112143517);
  EXPECT_EQ(ParseScaledDecimal("-0.0000000015", 9), -2);
  EXPECT_EQ(ParseScaledDecimal("0.00000000049", 9), 0);
  EXPECT_EQ(ParseScaledDecimal("5e-10", 9), 1);
  EXPECT_EQ(ParseScaledDecimal("5e-11", 9), 0);
  EXPECT_EQ(ParseScaledDecimal(".5", 1), 5);
  EXPECT_EQ(ParseScaledDecimal("7", 3), 7000);
  EXPECT_FALSE(ParseScaledDecimal("1403636584763555584", 9));
  EXPECT_FALSE(ParseScaledDecimal("nan", 9));
  EXPECT_FALSE(ParseScaledDecimal("1.2.3", 9));
  EXPECT_FALSE(ParseScaledDecimal("", 9));
  EXPECT_FALSE(ParseScaledDecimal("-", 9));
  EXPECT_FALSE(ParseScaledDecimal("1e", 9));
}

TEST(CsvReaderTest, DoesNotWaitForAPipe) {
  const TempFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  try {
    CsvReader reader(pipe);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("is a pipe or a device"));
  }
}

}  // namespace
}  // namespace facet
