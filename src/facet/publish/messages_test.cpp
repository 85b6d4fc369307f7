// SPDX-License-Identifier: BSD-2-Clause
// What the texts say; that they follow their schemas is tested by viewer/foxglove/test.mjs.
#include "facet/publish/messages.h"

#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/publish/channels.h"
#include "facet/viewer/base64.h"

namespace facet {
namespace {

using Json = nlohmann::json;

constexpr Timestamp kStamp{1'403'715'273'262'142'976};

SE3 Pose() {
  return {Quaterniond(0.5, 0.5, -0.5, 0.5), Vector3d(1, 2.5, -3)};
}

TEST(MessagesTest, EverySchemaIsThere) {
  for (const ChannelNames& names : kChannels) {
    const Json schema = Json::parse(SchemaText(names.schema), nullptr, false);
    ASSERT_TRUE(schema.is_object()) << names.schema;
    EXPECT_EQ(schema["title"], names.schema);
  }
  EXPECT_TRUE(SchemaText("foxglove.Nothing").empty());
}

TEST(MessagesTest, APose) {
  const Json pose = Json::parse(PoseMessage(kStamp, Pose()));
  EXPECT_EQ(pose["timestamp"]["sec"], 1403715273);
  EXPECT_EQ(pose["timestamp"]["nsec"], 262142976);
  EXPECT_EQ(pose["frame_id"], kWorldFrame);
  EXPECT_EQ(pose["pose"]["position"]["y"], 2.5);
  EXPECT_EQ(pose["pose"]["orientation"]["w"], 0.5);
  EXPECT_EQ(pose["pose"]["orientation"]["y"], -0.5);
  const Json transform = Json::parse(TransformMessage(kStamp, kBodyFrame, kCameraFrame, Pose()));
  EXPECT_EQ(transform["parent_frame_id"], kBodyFrame);
  EXPECT_EQ(transform["child_frame_id"], kCameraFrame);
  EXPECT_EQ(transform["translation"]["z"], -3);
}

TEST(MessagesTest, AStateHasItsCovarianceRowByRow) {
  VioOutput output;
  output.t = kStamp;
  output.has_pose = true;
  output.status = TrackingStatus::kDegraded;
  output.reason = "say \"when\"\n";
  output.state.T_WB = Pose();
  output.state.v_WB = Vector3d(0.1, std::numeric_limits<double>::quiet_NaN(), 0.3);
  output.causal.covariance(3, 3) = 0.25;
  output.causal.covariance(3, 6) = output.causal.covariance(6, 3) = 0.125;
  const Json state = Json::parse(StateMessage(output));
  EXPECT_EQ(state["status"], "degraded");
  EXPECT_EQ(state["reason"], "say _when__");
  EXPECT_EQ(state["velocity"]["x"], 0.1);
  EXPECT_EQ(state["velocity"]["y"], 0) << "JSON has no nan";
  EXPECT_EQ(state["covariance"].size(), 225u);
  EXPECT_EQ(state["covariance"][3 * 15 + 3], 0.25);
  EXPECT_EQ(state["covariance"][3 * 15 + 6], 0.125);
  output.has_pose = false;
  EXPECT_EQ(Json::parse(StateMessage(output))["position"]["x"], 0);
}

TEST(MessagesTest, AMeshReplacesTheOneOfItsName) {
  TriangleMesh mesh;
  mesh.vertices = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 0.125, 0)};
  mesh.colours = {{255, 0, 51}, {0, 0, 0}, {0, 0, 0}};
  mesh.faces = {{0, 1, 2}};
  const Json scene = Json::parse(MeshSceneMessage(kStamp, "horizon", mesh));
  EXPECT_TRUE(scene["deletions"].empty());
  const Json& entity = scene["entities"][0];
  EXPECT_EQ(entity["id"], "horizon");
  EXPECT_EQ(entity["triangles"][0]["points"][2]["y"], 0.125);
  EXPECT_EQ(entity["triangles"][0]["colors"][0]["b"].get<float>(), 0.2f);
  EXPECT_EQ(entity["triangles"][0]["indices"], Json({0, 1, 2}));
  const Json empty = Json::parse(MeshSceneMessage(kStamp, "horizon", {}));
  EXPECT_TRUE(empty["entities"].empty());
  EXPECT_EQ(empty["deletions"][0]["type"], 0);
  EXPECT_EQ(empty["deletions"][0]["id"], "horizon");
}

TEST(MessagesTest, PlanesAreOutlinesWithTheirNames) {
  PlaneRecord floor;
  floor.id = PlaneId{7};
  floor.label = PlaneLabel::kFloor;
  floor.outline_W = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
  const Json scene = Json::parse(PlanesSceneMessage(kStamp, std::vector{floor, floor}));
  EXPECT_EQ(scene["deletions"][0]["type"], 1);
  ASSERT_EQ(scene["entities"].size(), 2u);
  EXPECT_EQ(scene["entities"][0]["lines"][0]["points"].size(), 3u);
  EXPECT_EQ(scene["entities"][0]["texts"][0]["text"], "floor 7");
}

TEST(MessagesTest, APathAndAnImage) {
  const std::vector<StampedPose> poses = {{kStamp, Pose()}, {kStamp, SE3()}};
  EXPECT_EQ(Json::parse(PathMessage(kStamp, poses))["poses"].size(), 2u);
  EXPECT_EQ(Json::parse(PathMessage(kStamp, {}))["poses"].size(), 0u);
  const Json image = Json::parse(ImageMessage(kStamp, "abcd"));
  EXPECT_EQ(image["format"], "jpeg");
  EXPECT_EQ(image["data"], "YWJjZA==");
}

// RFC 4648, section 10.
TEST(MessagesTest, Base64) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

}  // namespace
}  // namespace facet
