// SPDX-License-Identifier: BSD-2-Clause
// More threads give the same bytes as one, on recordings.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "facet/testing/data_dir.h"
#include "facet/testing/folders.h"

namespace facet {
namespace {

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(ThreadsTest, MoreThreadsGiveTheSameBytesAsOne) {
  for (const char* name : {"rendered_room", "euroc_mh01_handheld"}) {
    const auto sequence = testing::DataDir(name);
    if (!sequence) GTEST_SKIP() << testing::MissingData(name);
    const std::filesystem::path folder = testing::BuildFolder() / "threads_test";
    for (const char* threads : {"1", "2", "3"}) {
      const std::string command = std::string(FACET_PROGRAM) + " run '" + sequence->string() +
                                  "' --pipeline SPR --duration 8 --quiet --threads " + threads +
                                  " --out '" + (folder / threads).string() + "'";
      ASSERT_EQ(std::system(command.c_str()), 0) << command;
    }
    for (const char* file :
         {"trajectory.tum", "keyframes.tum", "states.csv", "planes.csv", "mesh.ply", "map.ply"}) {
      const std::string one = ReadFile(folder / "1" / file);
      EXPECT_FALSE(one.empty()) << file;
      for (const char* threads : {"2", "3"})
        EXPECT_TRUE(one == ReadFile(folder / threads / file))
            << name << ' ' << file << ' ' << threads;
    }
    std::filesystem::remove_all(folder);
  }
}

}  // namespace
}  // namespace facet
