// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/partial_folder.h"

#include <iterator>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/io/text_file.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

class PartialFolderTest : public ::testing::Test {
 protected:
  fs::path Target() const { return folder_ / "out"; }
  fs::path Partial() const { return folder_ / "out.partial"; }
  fs::path Interrupted(const std::string& number = "") const {
    return folder_ / ("out.interrupted" + number);
  }
  void LeaveBehind(const std::string& text = "1,2\n") const {
    PartialFolder folder(Target());
    WriteTextFile(Partial() / "summary.json", "{}\n");
    WriteTextFile(Partial() / "states.csv", text);
  }

  TempFolder folder_;
};

TEST_F(PartialFolderTest, IsThereUntilItIsRemoved) {
  std::optional<PartialFolder> folder(std::in_place, Target());
  EXPECT_EQ(folder->path(), Partial());
  folder->Replace("a.txt", [](const fs::path& file) { WriteTextFile(file, "old"); });
  folder->Replace("a.txt", [](const fs::path& file) { WriteTextFile(file, "new"); });
  EXPECT_EQ(ReadText(Partial() / "a.txt"), "new");
  EXPECT_EQ(std::distance(fs::directory_iterator(Partial()), {}), 1);
  folder->Remove();
  EXPECT_FALSE(fs::exists(Partial()));
}

TEST_F(PartialFolderTest, AFileThatCannotBeWrittenLeavesTheOldOne) {
  PartialFolder folder(Target());
  folder.Replace("a.txt", [](const fs::path& file) { WriteTextFile(file, "old"); });
  const auto fail = [](const fs::path& file) {
    WriteTextFile(file, "half");
    throw OutputError("disk full");
  };
  EXPECT_THROW(folder.Replace("a.txt", fail), OutputError);
  EXPECT_EQ(ReadText(Partial() / "a.txt"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(Partial()), {}), 1);
}

TEST_F(PartialFolderTest, WhatAKilledRunLeftIsKept) {
  EXPECT_EQ(KeepInterrupted(Target()), fs::path());
  LeaveBehind();
  EXPECT_EQ(KeepInterrupted(Target()), Interrupted());
  EXPECT_FALSE(fs::exists(Partial()));
  EXPECT_TRUE(fs::exists(Interrupted() / "summary.json"));
  LeaveBehind("3,4\n");
  EXPECT_EQ(KeepInterrupted(fs::path(Target().string() + "/")), Interrupted("-2"));
  EXPECT_EQ(ReadText(Interrupted() / "states.csv"), "1,2\n") << "the older one is not touched";
  EXPECT_EQ(ReadText(Interrupted("-2") / "states.csv"), "3,4\n");
}

TEST_F(PartialFolderTest, WhatWasCutOffGoes) {
  LeaveBehind("1,2\n3,4\n5,");
  WriteTextFile(Partial() / "trajectory.tum", "1 2");
  WriteTextFile(Partial() / ".new-mesh.ply", "half a mesh");
  const fs::path kept = KeepInterrupted(Target());
  EXPECT_EQ(ReadText(kept / "states.csv"), "1,2\n3,4\n");
  EXPECT_EQ(ReadText(kept / "trajectory.tum"), "");
  EXPECT_FALSE(fs::exists(kept / ".new-mesh.ply"));
}

TEST_F(PartialFolderTest, WhatALiveRunWritesIsLeftAlone) {
  const PartialFolder folder(Target());
  WriteTextFile(Partial() / "summary.json", "{}\n");
  EXPECT_EQ(KeepInterrupted(Target()), fs::path());
  EXPECT_TRUE(fs::exists(Partial() / "summary.json"));
  EXPECT_THROW(PartialFolder another(Target()), ConfigError);
}

TEST_F(PartialFolderTest, OtherPeoplesFoldersAreLeftAlone) {
  fs::create_directories(Partial());
  WriteTextFile(Partial() / "thesis.tex", "years");
  EXPECT_EQ(KeepInterrupted(Target()), fs::path());
  EXPECT_THROW(PartialFolder folder(Target()), ConfigError);
  EXPECT_EQ(ReadText(Partial() / "thesis.tex"), "years");
}

// The disk was full, or the process was killed while it began: the next run must not be in its way.
TEST_F(PartialFolderTest, OneWithoutASummaryHoldsNothing) {
  {
    PartialFolder folder(Target());
    for (const char* file : {"states.csv", "timing.csv", ".new-config.yaml"})
      WriteTextFile(Partial() / file, "");
  }
  EXPECT_EQ(KeepInterrupted(Target()), fs::path());
  EXPECT_FALSE(fs::exists(Partial()));
  PartialFolder again(Target());
}

TEST_F(PartialFolderTest, AnEmptyLeftOverIsNoResult) {
  fs::create_directories(Partial());
  EXPECT_EQ(KeepInterrupted(Target()), fs::path());
  EXPECT_FALSE(fs::exists(Partial()));
}

TEST_F(PartialFolderTest, LinesAreThereAtOnce) {
  PartialFolder folder(Target());
  LineFile lines(Partial() / "lines.csv", "a,b\n");
  EXPECT_EQ(ReadText(Partial() / "lines.csv"), "a,b\n");
  lines.Add("1,2\n3,4\n");
  lines.Add("");
  EXPECT_EQ(ReadText(Partial() / "lines.csv"), "a,b\n1,2\n3,4\n");
  EXPECT_THROW(LineFile(Partial() / "nowhere" / "lines.csv", ""), OutputError);
}

}  // namespace
}  // namespace facet
