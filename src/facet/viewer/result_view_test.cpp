// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/result_view.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "facet/io/errors.h"
#include "facet/io/result_writer.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/viewer/standalone_page.h"
#include "facet/viewer/view_message.h"

namespace facet {
namespace {

TriangleMesh OneFace() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 1}, {2, 0, 1}, {0, 3, 1}};
  mesh.normals.assign(3, {0, 0, 1});
  mesh.colours.assign(3, {1, 2, 3});
  mesh.faces = {{0, 1, 2}};
  mesh.plane_ids = {4};
  return mesh;
}

RunRecord SmallRun() {
  RunRecord run;
  run.frames.resize(100);
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    run.frames[i].t = {static_cast<std::int64_t>(1000000 * i)};
    run.frames[i].has_pose = i > 2;
    run.frames[i].status = "ok";
  }
  run.keyframes = {{{5000000}, SE3()}};
  run.mesh = run.map = OneFace();
  run.planes.emplace(1);
  return run;
}

std::map<int, int> NumByType(const ViewBoard& board) {
  std::map<int, int> num;
  std::uint64_t number = 0;
  while (const auto next = board.NextAfter(number)) {
    std::uint16_t type = 0;
    std::memcpy(&type, next->message->data() + 6, sizeof(type));
    ++num[type];
    number = next->number;
  }
  return num;
}

TEST(ResultView, APlainResultBecomesMessagesAndDownloads) {
  const TempFolder folder;
  WriteResult(folder.path(), SmallRun());
  std::filesystem::create_directories(folder.path() / "meshes");
  for (const char* name : {"7", "1403636579763555584", "9999999999999999999", "evil"}) {
    const std::string file = std::string(name) + ".ply";
    std::filesystem::copy(folder.path() / "map.ply", folder.path() / "meshes" / file);
  }
  const ResultView view({folder.path()}, nullptr);
  ViewBoard board;
  view.PostTo(board);
  EXPECT_EQ((*board.NextAfter(0)->message)[6], 1);  // hello comes first
  const std::map<int, int> expected = {{1, 1}, {2, 2}, {4, 2}, {5, 1}, {6, 1}};
  EXPECT_EQ(NumByType(board), expected);
  std::map<std::string, std::string> files;
  for (const ViewDownload& download : view.Downloads())
    files[download.name] = download.make();
  EXPECT_EQ(files["a/map.glb"].substr(0, 4), "glTF");
  EXPECT_EQ(files["a/map.ply"].substr(0, 3), "ply");
  EXPECT_EQ(files["a/horizon-7.facet"].substr(0, 4), "FCTV");
  EXPECT_TRUE(files.contains("a/horizon-1403636579763555584.facet"));
  EXPECT_FALSE(files.contains("a/horizon-9999999999999999999.facet")) << "is no stamp";
  EXPECT_FALSE(files.contains("a/horizon-evil.facet"));
}

TEST(ResultView, TwoResultsAreToldApartByTheirSource) {
  const TempFolder first, second;
  WriteResult(first.path(), SmallRun());
  WriteResult(second.path(), SmallRun());
  const ResultView view({first.path(), second.path()}, nullptr);
  ViewBoard board;
  view.PostTo(board);
  int num_second = 0;
  std::uint64_t number = 0;
  while (const auto next = board.NextAfter(number)) {
    num_second += (*next->message)[8];
    number = next->number;
  }
  EXPECT_EQ(num_second, 6);
}

TEST(ResultView, APageWithItsDataInsideNeedsNothingElse) {
  const TempFolder folder;
  WriteResult(folder.path(), SmallRun());
  const std::string page = StandalonePage(ResultView({folder.path()}, nullptr));
  EXPECT_TRUE(page.starts_with("<!doctype html>"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
  EXPECT_EQ(page.find("page.js\""), std::string::npos);
  EXPECT_EQ(page.find("page.css\""), std::string::npos);
  int num_messages = 0;
  for (std::size_t i = 0; (i = page.find("\"application/x-facet\">RkNUV", i)) != std::string::npos;
       ++i)
    ++num_messages;
  EXPECT_EQ(num_messages, 7);
}

TEST(ResultView, ADamagedSummaryIsNamed) {
  const TempFolder folder;
  WriteResult(folder.path(), SmallRun());
  std::ofstream(folder.path() / "summary.json") << "{\"frames\": ";
  try {
    const ResultView view({folder.path()}, nullptr);
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("summary.json: is damaged"), std::string::npos)
        << error.what();
  }
}

// Nobody may ever write to it: the view must not wait.
TEST(ResultView, APipeIsRefused) {
  for (const char* name :
       {"mesh.ply", "map.ply", "keyframes.tum", "summary.json", "states.csv", "timing.csv"}) {
    const TempFolder folder;
    WriteResult(folder.path(), SmallRun());
    std::filesystem::remove(folder.path() / name);
    ASSERT_EQ(mkfifo((folder.path() / name).c_str(), 0600), 0);
    EXPECT_THROW(ResultView({folder.path()}, nullptr), InputError) << name;
  }
}

TEST(ResultView, WhatIsNoResultIsRefused) {
  const TempFolder folder;
  EXPECT_THROW(ResultView({folder.path()}, nullptr), InputError);
  EXPECT_THROW(ResultView({folder.path() / "none"}, nullptr), InputError);
}

}  // namespace
}  // namespace facet
