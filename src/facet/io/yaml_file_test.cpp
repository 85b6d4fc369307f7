// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/yaml_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

std::string Message(const std::filesystem::path& file) {
  try {
    const YamlFile yaml(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string YamlErrorOf(const std::string& text) {
  const TempFolder folder;
  WriteText(folder / "a.yaml", text);
  return Message(folder / "a.yaml");
}

TEST(YamlFileTest, AliasesThatLeadBackToThemselvesAreRefused) {
  EXPECT_THAT(YamlErrorOf("a: &x\n  b: *x\n"), HasSubstr("a.yaml:"));
  EXPECT_THAT(YamlErrorOf("a: &x [1, *x]\n"), HasSubstr("nested too deeply"));
  std::string laughs = "a0: &a0 [x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    laughs += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int k = 1; k < 8; ++k)
      laughs += ", " + before;
    laughs += "]\n";
  }
  EXPECT_THAT(YamlErrorOf(laughs), HasSubstr("too large"));
  EXPECT_EQ(YamlErrorOf("a: &x 1\nb: *x\n"), "accepted");
}

TEST(YamlFileTest, AKeyMayStandOnce) {
  EXPECT_THAT(YamlErrorOf("a: 1\nb: 2\na: 3\n"), HasSubstr("a.yaml:3: 'a' appears twice"));
  EXPECT_THAT(YamlErrorOf("c:\n  d: 1\n  d: 2\n"), HasSubstr("'d' appears twice"));
  EXPECT_EQ(YamlErrorOf("a: {d: 1}\nb: {d: 2}\n"), "accepted");
}

TEST(YamlFileTest, OnlyRegularFilesOfAReasonableSizeAreRead) {
  const TempFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(Message(pipe), HasSubstr("cannot be read as a file"));
  EXPECT_THAT(Message("/dev/zero"), HasSubstr("cannot be read as a file"));
  EXPECT_THAT(Message(folder.path()), HasSubstr("cannot be read as a file"));
  WriteText(folder / "large.yaml", "# " + std::string(17 << 20, 'x') + "\n");
  EXPECT_THAT(Message(folder / "large.yaml"), HasSubstr("larger than 16 MB"));
}

}  // namespace
}  // namespace facet
