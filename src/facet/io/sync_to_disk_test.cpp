// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/sync_to_disk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

TEST(SyncToDiskTest, FilesAndFoldersKeepWhatTheyHold) {
  const TempFolder folder;
  fs::create_directories(folder / "a" / "b");
  WriteText(folder / "a" / "b" / "file", "text");
  SyncToDisk(folder / "a");
  SyncToDisk(folder / "a" / "b" / "file");
  EXPECT_EQ(ReadText(folder / "a" / "b" / "file"), "text");
}

TEST(SyncToDiskTest, WhatIsNotThereIsAnError) {
  const TempFolder folder;
  try {
    SyncToDisk(folder / "missing");
    FAIL() << "no error";
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(),
                ::testing::HasSubstr("missing: cannot be brought to the disk: No such"));
  }
}

}  // namespace
}  // namespace facet
