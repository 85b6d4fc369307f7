// SPDX-License-Identifier: BSD-2-Clause
#include "facet/publish/publisher.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/io/errors.h"
#include "facet/publish/mcap_recorder.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using Json = nlohmann::json;

Timestamp At(int frame) {
  return {1'000'000'000 + 50'000'000LL * frame};
}

VioOutput OutputOf(int frame) {
  VioOutput output;
  output.t = At(frame);
  output.has_pose = frame >= 2;
  output.is_keyframe = frame % 4 == 0;
  output.state.T_WB.p.x() = frame;
  return output;
}

VioOutput WithScene(VioOutput output) {
  auto mesh = std::make_shared<MeshSnapshot>();
  mesh->mesh.vertices = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
  mesh->mesh.faces = {{0, 1, 2}};
  output.mesh = mesh;
  auto update = std::make_shared<SceneUpdate>();
  update->planes.resize(2);
  output.scene_update = update;
  return output;
}

class PublisherTest : public ::testing::Test {
 protected:
  void Publish(int num_frames) {
    Publisher publisher(EurocRig(), {}, {[this](const PublishedMessage& m) { got_.push_back(m); }});
    const cv::Mat image(48, 64, CV_8UC1, 100.0);
    for (int i = 0; i < num_frames; ++i) {
      publisher.AddImage(At(i), image);
      publisher.Add(i == 4 ? WithScene(OutputOf(i)) : OutputOf(i));
    }
    publisher.Finish();
    EXPECT_EQ(publisher.num_dropped(), 0);
    publisher.Add(OutputOf(num_frames));  // after the end
  }
  std::vector<PublishedMessage> Of(Channel channel) const {
    std::vector<PublishedMessage> of;
    std::ranges::copy_if(got_, std::back_inserter(of), [&](const PublishedMessage& message) {
      return message.channel == channel;
    });
    return of;
  }

  std::vector<PublishedMessage> got_;
};

TEST_F(PublisherTest, EveryFrameHasAStateAndEveryPoseItsTransform) {
  Publish(10);
  EXPECT_EQ(Of(Channel::kState).size(), 10u);
  EXPECT_EQ(Of(Channel::kPose).size(), 8u);
  EXPECT_EQ(Of(Channel::kTransforms).size(), 8u + 3u) << "the camera's, at first and on keyframes";
  EXPECT_EQ(Json::parse(Of(Channel::kPose)[3].json)["pose"]["position"]["x"], 5);
  EXPECT_EQ(Of(Channel::kPose)[3].t, At(5));
  EXPECT_EQ(Of(Channel::kImage).size(), 5u) << "ten of a second";
  EXPECT_EQ(Of(Channel::kMesh).size(), 1u);
  EXPECT_EQ(Json::parse(Of(Channel::kPlanes)[0].json)["entities"].size(), 2u);
}

TEST_F(PublisherTest, ALongPathIsThinned) {
  Publish(150);
  EXPECT_EQ(Json::parse(Of(Channel::kPath)[0].json)["poses"].size(), 1u);
  EXPECT_EQ(Json::parse(Of(Channel::kPath)[1].json)["poses"].size(), 21u);
  got_.clear();
  constexpr int kNumFrames = 6000, kNumAtOnce = 100;
  std::atomic<int> num_states = 0;
  Publisher publisher(EurocRig(), {}, {[&](const PublishedMessage& message) {
                        got_.push_back(message);
                        num_states += message.channel == Channel::kState ? 1 : 0;
                      }});
  for (int i = 0; i < kNumFrames; ++i) {
    publisher.Add(OutputOf(i));
    while (i % kNumAtOnce == 0 && num_states <= i)
      std::this_thread::yield();
  }
  publisher.Finish();
  const Json last = Json::parse(Of(Channel::kPath).back().json);
  EXPECT_LE(last["poses"].size(), 2000u);
  EXPECT_GT(last["poses"].size(), 1000u);
  EXPECT_EQ(publisher.num_dropped(), 0);
  double previous = -1;
  for (const Json& pose : last["poses"]) {
    EXPECT_GT(pose["position"]["x"], previous) << "in order";
    previous = pose["position"]["x"];
  }
}

TEST_F(PublisherTest, AsksForTheSceneOnceInASecond) {
  Publisher publisher(EurocRig(), {}, {});
  int num_asked = 0;
  for (int i = 0; i < 60; ++i)
    num_asked += publisher.WantsSceneUpdate(At(i)) ? 1 : 0;
  EXPECT_EQ(num_asked, 3);
}

TEST_F(PublisherTest, WhatASinkThrowsIsToldAtTheEndAndStopsNobodyElse) {
  int num_tried = 0;
  Publisher publisher(EurocRig(),
                      {},
                      {[&](const PublishedMessage&) {
                         ++num_tried;
                         throw OutputError("disk full");
                       },
                       [this](const PublishedMessage& m) { got_.push_back(m); }});
  for (int i = 0; i < 5; ++i)
    publisher.Add(OutputOf(i));
  EXPECT_THROW(publisher.Finish(), OutputError);
  EXPECT_EQ(num_tried, 1);
  EXPECT_EQ(Of(Channel::kState).size(), 5u);
}

TEST_F(PublisherTest, ARecordingThatEndsEarlyKeepsWhatItHas) {
  TempFolder folder;
  {
    McapRecorder recorder(folder / "run.mcap");
    recorder.Add({Channel::kPose, "", At(0), "{}"});
    EXPECT_TRUE(std::filesystem::exists(folder / "run.mcap.partial"));
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "run.mcap.partial"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.mcap"));
  McapRecorder recorder(folder / "run.mcap");
  for (int i = 0; i < 100; ++i) {
    recorder.Add({Channel::kPose, "", At(i), "{}"});
    if (i == 60) {
      EXPECT_GT(std::filesystem::file_size(folder / "run.mcap.partial"), 1000u) << "by the second";
    }
  }
  recorder.Commit();
  EXPECT_TRUE(std::filesystem::exists(folder / "run.mcap"));
  EXPECT_THROW(McapRecorder(folder / "nowhere" / "run.mcap"), OutputError);
}

}  // namespace
}  // namespace facet
