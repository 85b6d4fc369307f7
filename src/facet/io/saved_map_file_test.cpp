// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/saved_map_file.h"

#include <cmath>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "facet/base/random.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

CameraIntrinsics Lens() {
  CameraIntrinsics lens;
  lens.width = 752;
  lens.height = 480;
  lens.fx = lens.fy = 458;
  lens.cx = 367.2;
  lens.cy = 248.4;
  return lens;
}

SavedMap SmallMap() {
  SavedMap map;
  map.lenses = {Lens(), Lens()};
  map.lenses[1].distortion = DistortionModel::kDoubleSphere;
  map.lenses[1].coefficients = {-0.2, 0.6};
  map.graph.disparity_error_px = 0.03;
  for (int i = 0; i < 3; ++i) {
    map.graph.nodes.push_back({Vector3d(i, 2, 3), {0.1 * i, Vector3d(4, 5, i)}, i - 1});
    map.keyframes.push_back({FrameId{7 + i}, Timestamp{1000 + i}, i, i / 2});
  }
  for (int i = 0; i < 3; ++i) {
    GraphEdge edge;
    edge.first = i % 2;
    edge.second = i == 0 ? 1 : 2;  // two between neighbours, and a closure
    if (i == 2) edge.first = 0;
    edge.p_first = Vector3d(1, 0, i);
    edge.covariance = (1 + i) * Matrix4d::Identity();
    edge.is_closure = i == 2;
    edge.weight = 0.5;
    map.graph.edges.push_back(edge);
  }
  PlaceRecord place;
  place.node = 2;
  place.t = Timestamp{1002};
  place.session = 1;
  place.frame = FrameId{8};
  place.T_WB = {Quaterniond(0.5, 0.5, -0.5, 0.5), Vector3d(1, 2, 3)};
  place.sigma_tilt_rad = 0.01;
  place.points.resize(4);
  for (std::size_t i = 0; i < 4; ++i) {
    RecordPoint& point = place.points[i];
    point.p_C = Eigen::Vector3f(1, 2, static_cast<float>(i + 1));
    point.px = Eigen::Vector2f(100.5F, 20.25F);
    point.sigma_depth_m = 0.1F;
    for (RecordPatch& patch : point.patches) {
      patch.grey.fill(static_cast<std::uint8_t>(40 * i));
      patch.x = patch.y = 6.5F;
    }
    point.descriptors[2] = {i, 2, 3, ~std::uint64_t{0}};
  }
  map.places.push_back(place);
  return map;
}

class SavedMapFileTest : public ::testing::Test {
 protected:
  std::filesystem::path File() const { return folder_ / kSavedMapName; }
  std::string Bytes() const { return ReadText(File()); }

  std::string ErrorWith(const std::string& bytes) const {
    std::ofstream(File(), std::ios::binary) << bytes;
    try {
      ReadSavedMap(folder_.path());
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }

  TempFolder folder_;
};

TEST_F(SavedMapFileTest, WhatIsWrittenIsRead) {
  const SavedMap map = SmallMap();
  WriteSavedMap(folder_.path(), map);
  const SavedMap read = ReadSavedMap(folder_.path());
  EXPECT_EQ(read.num_sessions(), 2);
  ASSERT_EQ(read.lenses.size(), 2u);
  EXPECT_EQ(read.lenses[0].cx, 367.2);
  EXPECT_EQ(read.lenses[1].distortion, DistortionModel::kDoubleSphere);
  EXPECT_EQ(read.lenses[1].coefficients, map.lenses[1].coefficients);
  EXPECT_EQ(read.graph.disparity_error_px, 0.03);
  ASSERT_EQ(read.keyframes.size(), 3u);
  EXPECT_EQ(read.keyframes[2].frame.value, 9);
  EXPECT_EQ(read.keyframes[2].t.ns, 1002);
  EXPECT_EQ(read.keyframes[2].segment, 2);
  EXPECT_EQ(read.keyframes[2].session, 1);
  EXPECT_EQ(read.graph.nodes[2].p_W, map.graph.nodes[2].p_W);
  EXPECT_EQ(read.graph.nodes[2].T_MW.p, map.graph.nodes[2].T_MW.p);
  EXPECT_EQ(read.graph.nodes[2].edge_to_previous, 1);
  ASSERT_EQ(read.graph.edges.size(), 3u);
  EXPECT_EQ(read.graph.edges[1].covariance, map.graph.edges[1].covariance);
  EXPECT_FALSE(read.graph.edges[1].is_closure);
  EXPECT_TRUE(read.graph.edges[2].is_closure);
  EXPECT_EQ(read.graph.edges[1].weight, 0.5);
  ASSERT_EQ(read.places.size(), 1u);
  EXPECT_EQ(read.places[0].T_WB.p, map.places[0].T_WB.p);
  EXPECT_EQ(read.places[0].T_WB.q.coeffs(), map.places[0].T_WB.q.coeffs());
  ASSERT_EQ(read.places[0].points.size(), 4u);
  EXPECT_EQ(read.places[0].points[3].p_C, map.places[0].points[3].p_C);
  EXPECT_EQ(read.places[0].points[3].patches[1].grey, map.places[0].points[3].patches[1].grey);
  EXPECT_EQ(read.places[0].points[3].descriptors, map.places[0].points[3].descriptors);
  WriteSavedMap(folder_.path() / "again", read);
  EXPECT_EQ(ReadText(folder_.path() / "again" / kSavedMapName), Bytes());
}

TEST_F(SavedMapFileTest, DamageIsRefusedWithItsReason) {
  WriteSavedMap(folder_.path(), SmallMap());
  const std::string good = Bytes();
  EXPECT_EQ(ErrorWith(good), "none");
  EXPECT_THAT(ErrorWith(""), HasSubstr("no map of Facet"));
  EXPECT_THAT(ErrorWith("PNG" + good), HasSubstr("no map of Facet"));
  EXPECT_THAT(ErrorWith(good.substr(0, good.size() - 1)), HasSubstr("not as long as it says"));
  EXPECT_THAT(ErrorWith(good + "x"), HasSubstr("not as long as it says"));
  std::string other = good;
  other[8] = 9;
  EXPECT_THAT(ErrorWith(other), HasSubstr("version 9"));
  other = good;
  other[good.size() / 2] ^= 1;
  EXPECT_THAT(ErrorWith(other), HasSubstr("checksum"));
}

TEST_F(SavedMapFileTest, FiveHundredMutationsAreRefused) {
  WriteSavedMap(folder_.path(), SmallMap());
  const std::string good = Bytes();
  Rng rng(1);
  const auto place = [&] {
    return std::min(static_cast<std::size_t>(rng.Uniform() * static_cast<double>(good.size())),
                    good.size() - 1);
  };
  for (int i = 0; i < 500; ++i) {
    std::string bytes = good;
    if (i % 3 == 0) bytes.resize(place());
    if (i % 3 == 1) bytes[place()] ^= static_cast<char>(1 << i % 8);
    if (i % 3 == 2) bytes.insert(place(), 1 + static_cast<std::size_t>(i % 5), 'x');
    EXPECT_THAT(ErrorWith(bytes), HasSubstr(kSavedMapName)) << i;
  }
}

// What a checksum does not see: damaged by a program, with the right sum.
TEST_F(SavedMapFileTest, MutationsWithTheRightChecksumAreRefusedOrHarmless) {
  constexpr std::size_t kHead = 24, kSizeAt = 12, kCrcAt = 20;
  WriteSavedMap(folder_.path(), SmallMap());
  const std::string good = Bytes();
  Rng rng(2);
  int num_refused = 0;
  for (int i = 0; i < 500; ++i) {
    std::string payload = good.substr(kHead);
    const auto at =
        std::min(static_cast<std::size_t>(rng.Uniform() * static_cast<double>(payload.size())),
                 payload.size() - 1);
    if (i % 4 == 0) payload.resize(at);
    if (i % 4 != 0) payload[at] = static_cast<char>(i % 4 == 1 ? 0xFF : payload[at] ^ (1 << i % 8));
    std::string bytes = good.substr(0, kHead) + payload;
    const std::uint64_t size = payload.size();
    const auto crc = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(payload.data()), payload.size()));
    bytes.replace(kSizeAt, sizeof size, reinterpret_cast<const char*>(&size), sizeof size);
    bytes.replace(kCrcAt, sizeof crc, reinterpret_cast<const char*>(&crc), sizeof crc);
    const std::string error = ErrorWith(bytes);
    if (error == "none") {
      MapGraph graph(ReadSavedMap(folder_.path()).graph);
      graph.Optimize();  // ends
    } else {
      EXPECT_THAT(error, HasSubstr(kSavedMapName));
      EXPECT_THAT(error, Not(HasSubstr("checksum")));
      ++num_refused;
    }
  }
  EXPECT_GT(num_refused, 130);
}

// A right checksum over what cannot be: written by a program with an error, or on purpose.
TEST_F(SavedMapFileTest, WhatCannotBeIsRefused) {
  const auto error_of = [&](auto change) {
    SavedMap map = SmallMap();
    change(map);
    WriteSavedMap(folder_.path(), map);
    return ErrorWith(Bytes());
  };
  EXPECT_THAT(error_of([](SavedMap& m) { m.places[0].node = 3; }), HasSubstr("at no node"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.places[0].session = 2; }), HasSubstr("not of its node"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.edges[0].second = 0; }), HasSubstr("an edge"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.edges[1].second = 3; }), HasSubstr("an edge"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.edges[1].covariance.setZero(); }),
              HasSubstr("covariance"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.edges[1].covariance(0, 1) = 5; }),
              HasSubstr("covariance"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.edges[1].covariance *= 1e-20; }),
              HasSubstr("covariance"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.edges[1].p_first.x() = 1e160; }),
              HasSubstr("out of this world"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.edges[2].weight = -1; }), HasSubstr("weight"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.lenses.clear(); }), HasSubstr("no runs"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.keyframes[0].session = 1; }), HasSubstr("of no run"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.keyframes[2].session = 2; }), HasSubstr("of no run"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.lenses[0].fx = -1; }), HasSubstr("lens"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.places.clear(); }), HasSubstr("no places"));
  EXPECT_THAT(error_of([](SavedMap& m) {
                m.keyframes[2].t = m.places[0].t =
                    Timestamp{std::numeric_limits<std::int64_t>::max()};
              }),
              HasSubstr("stamp"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.graph.nodes[0].edge_to_previous = 1; }),
              HasSubstr("no edge"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.places[0].T_WB.q.coeffs().setZero(); }),
              HasSubstr("rotation"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.places[0].T_WB.p.x() = std::nan(""); }),
              HasSubstr("finite"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.places[0].points[1].p_C.setZero(); }),
              HasSubstr("nowhere"));
  EXPECT_THAT(error_of([](SavedMap& m) { m.places[0].points[1].patches[0].x = 14; }),
              HasSubstr("patch"));
}

TEST_F(SavedMapFileTest, WhereThereIsNoneTheErrorSaysHowToMakeOne) {
  try {
    ReadSavedMap(folder_.path() / "nowhere");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--save-map"));
  }
}

TEST_F(SavedMapFileTest, AFolderThatCannotBeMadeIsAnOutputError) {
  std::ofstream(folder_ / "file") << "x";
  EXPECT_THROW(WriteSavedMap(folder_ / "file" / "map", SmallMap()), OutputError);
}

}  // namespace
}  // namespace facet
