// SPDX-License-Identifier: BSD-2-Clause
#include "messages.h"

#include <cstring>

#include <boost/make_shared.hpp>
#include <gtest/gtest.h>

namespace facet {
namespace ros1 {
namespace {

api::Mesh TwoTriangles() {
  api::Mesh mesh;
  mesh.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 2.5}}};
  mesh.faces = {{{0, 1, 2}}, {{0, 2, 3}}};
  mesh.colours = {{{255, 0, 0}}, {{0, 255, 0}}, {{0, 0, 255}}, {{1, 2, 3}}};
  return mesh;
}

TEST(Ros1MessagesTest, AnImageIsNotCopiedAndKeepsItsMessage) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->header.stamp = ros::Time(1403636584, 763555584);
  message->encoding = "mono8";
  message->width = message->step = 3;
  message->height = 2;
  message->data = {1, 2, 3, 4, 5, 6};
  const std::uint8_t* bytes = message->data.data();
  const robot::ReceivedImage image = ToImage(sensor_msgs::ImageConstPtr(message));
  message.reset();
  EXPECT_EQ(image.t_ns, 1403636584763555584);
  EXPECT_EQ(image.image.bytes, bytes);
  EXPECT_EQ(image.image.num_bytes, 6u);
  EXPECT_EQ(image.image.bytes[5], 6);
  EXPECT_TRUE(ToImage(boost::make_shared<sensor_msgs::CompressedImage>()).image.encoding.empty());
  EXPECT_FALSE(ToImage(boost::make_shared<sensor_msgs::Image>()).image.encoding.empty());
}

TEST(Ros1MessagesTest, StampsOfOdometryAreThoseOfTheSample) {
  robot::OdometryOutput output;
  output.t_ns = 1403636584763555584;
  output.T_odom_base = {{{1, 2, 3}}, {{0.5, 0.5, -0.5, 0.5}}};
  output.v_base = {{4, 5, 6}};
  output.w_base = {{7, 8, 9}};
  for (std::size_t i = 0; i < 36; ++i) {
    output.pose_covariance[i] = static_cast<double>(i);
    output.twist_covariance[i] = static_cast<double>(100 + i);
  }
  const nav_msgs::Odometry message = ToOdometry(output, {});
  EXPECT_EQ(message.header.stamp.toNSec(), 1403636584763555584u);
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_EQ(message.pose.pose.position.z, 3);
  EXPECT_EQ(message.pose.pose.orientation.w, 0.5);
  EXPECT_EQ(message.pose.pose.orientation.y, -0.5);
  EXPECT_EQ(message.twist.twist.linear.y, 5);
  EXPECT_EQ(message.twist.twist.angular.x, 7);
  EXPECT_EQ(message.pose.covariance[35], 35);
  EXPECT_EQ(message.twist.covariance[1], 101);
}

TEST(Ros1MessagesTest, AMeshIsAListOfTriangles) {
  const visualization_msgs::Marker marker =
      ToMarker(robot::MeshMarker(5, "map", 7, TwoTriangles()), {});
  EXPECT_EQ(marker.type, visualization_msgs::Marker::TRIANGLE_LIST);
  EXPECT_EQ(marker.action, visualization_msgs::Marker::ADD);
  EXPECT_EQ(marker.id, 7);
  ASSERT_EQ(marker.points.size(), 6u);
  ASSERT_EQ(marker.colors.size(), 6u);
  EXPECT_EQ(marker.points[5].z, 2.5);
  EXPECT_EQ(marker.colors[1].g, 1);
  EXPECT_EQ(marker.pose.orientation.w, 1);
  const visualization_msgs::Marker none = ToMarker(robot::MeshMarker(5, "map", 7, api::Mesh()), {});
  EXPECT_EQ(none.action, visualization_msgs::Marker::DELETE);
}

TEST(Ros1MessagesTest, PointsHaveTheirColours) {
  const sensor_msgs::PointCloud2 cloud = ToPoints(Header(5, "odom"), TwoTriangles());
  EXPECT_EQ(cloud.width, 4u);
  EXPECT_EQ(cloud.point_step, 16u);
  ASSERT_EQ(cloud.data.size(), 64u);
  float z = 0;
  std::uint32_t rgb = 0;
  std::memcpy(&z, &cloud.data[3 * 16 + 8], 4);
  std::memcpy(&rgb, &cloud.data[3 * 16 + 12], 4);
  EXPECT_EQ(z, 2.5F);
  EXPECT_EQ(rgb, 0x010203u);
  EXPECT_EQ(ToPoints(Header(5, "odom"), api::Mesh()).data.size(), 0u);
}

TEST(Ros1MessagesTest, PlanesAreOutlinesAndLabelsAndGoAgain) {
  api::Plane plane;
  plane.id = 3;
  plane.label = "floor";
  plane.outline = {{{0, 0, 0}}, {{2, 0, 0}}, {{2, 2, 0}}, {{0, 2, 0}}};
  const auto markers = ToMarkers(robot::PlaneMarkers({5, {plane}, {8}}), {}).markers;
  ASSERT_EQ(markers.size(), 4u);
  EXPECT_EQ(markers[0].points.size(), 5u) << "closed";
  EXPECT_EQ(markers[1].text, "floor 3");
  EXPECT_EQ(markers[1].pose.position.x, 1);
  EXPECT_EQ(markers[2].id, 8);
  EXPECT_EQ(markers[3].action, visualization_msgs::Marker::DELETE);
}

}  // namespace
}  // namespace ros1
}  // namespace facet
