// SPDX-License-Identifier: BSD-2-Clause
// The functions of make_messages.h with the messages of ROS 1; those of ROS 2 are tested by
// stand-ins, without ROS.
#include <boost/make_shared.hpp>
#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include "facet/robot/make_messages.h"

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
  const robot::ReceivedImage image = robot::ToRawImage(sensor_msgs::ImageConstPtr(message));
  message.reset();
  EXPECT_EQ(image.t_ns, 1403636584763555584);
  EXPECT_EQ(image.image.bytes, bytes);
  EXPECT_EQ(image.image.num_bytes, 6u);
  EXPECT_EQ(image.image.bytes[5], 6);
  EXPECT_TRUE(robot::ToCompressedImage(boost::make_shared<sensor_msgs::CompressedImage>())
                  .image.encoding.empty());
  EXPECT_FALSE(robot::ToRawImage(boost::make_shared<sensor_msgs::Image>()).image.encoding.empty());
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
  const auto message = robot::ToOdometry<nav_msgs::Odometry>(output, {});
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
  const auto marker = robot::ToMarker<visualization_msgs::Marker>(
      robot::MeshMarker(5, "map", 7, TwoTriangles()), {});
  EXPECT_EQ(marker.type, visualization_msgs::Marker::TRIANGLE_LIST);
  EXPECT_EQ(marker.action, visualization_msgs::Marker::ADD);
  EXPECT_EQ(marker.id, 7);
  EXPECT_EQ(marker.header.stamp.nsec, 5u);
  ASSERT_EQ(marker.points.size(), 6u);
  ASSERT_EQ(marker.colors.size(), 6u);
  EXPECT_EQ(marker.points[5].z, 2.5);
  EXPECT_EQ(marker.colors[1].g, 1);
  EXPECT_EQ(marker.pose.orientation.w, 1);
}

TEST(Ros1MessagesTest, ActionsAndTypesAreThoseOfRos) {
  using visualization_msgs::Marker;
  EXPECT_EQ(static_cast<int>(robot::Marker::kDelete), static_cast<int>(Marker::DELETE));
  EXPECT_EQ(static_cast<int>(robot::Marker::kDeleteAll), static_cast<int>(Marker::DELETEALL));
  EXPECT_EQ(static_cast<int>(robot::Marker::kLineStrip), static_cast<int>(Marker::LINE_STRIP));
  EXPECT_EQ(static_cast<int>(robot::Marker::kText), static_cast<int>(Marker::TEXT_VIEW_FACING));
}

TEST(Ros1MessagesTest, PointsHaveTheirFields) {
  const auto cloud = robot::ToPoints<sensor_msgs::PointCloud2>(TwoTriangles(), {});
  EXPECT_EQ(cloud.width, 4u);
  EXPECT_EQ(cloud.point_step, 16u);
  EXPECT_EQ(cloud.data.size(), 64u);
  ASSERT_EQ(cloud.fields.size(), 4u);
  EXPECT_EQ(cloud.fields[3].name, "rgb");
  EXPECT_EQ(cloud.fields[3].offset, 12u);
  EXPECT_EQ(cloud.fields[3].datatype, sensor_msgs::PointField::FLOAT32);
  EXPECT_EQ(robot::ToPoints<sensor_msgs::PointCloud2>(api::Mesh(), {}).fields.size(), 3u);
}

TEST(Ros1MessagesTest, CameraInfoHasAllItsNumbers) {
  sensor_msgs::CameraInfo message;
  message.width = 640;
  message.distortion_model = "plumb_bob";
  message.D = {1, 2, 3, 4, 5};
  message.K[4] = 7;
  message.R[8] = 8;
  message.P[11] = 9;
  const api::CameraInfo info = robot::ToCameraInfo(message);
  EXPECT_EQ(info.width, 640);
  EXPECT_EQ(info.distortion_model, "plumb_bob");
  EXPECT_EQ(info.D.size(), 5u);
  EXPECT_EQ(info.K[4], 7);
  EXPECT_EQ(info.R[8], 8);
  EXPECT_EQ(info.P[11], 9);
}

TEST(Ros1MessagesTest, PathTransformAndDiagnosticsAreComplete) {
  const auto path = robot::ToPath<nav_msgs::Path>({{5, {{{1, 2, 3}}, {{1, 0, 0, 0}}}}}, {});
  ASSERT_EQ(path.poses.size(), 1u);
  EXPECT_EQ(path.poses[0].header.stamp.nsec, 5u);
  EXPECT_EQ(path.poses[0].pose.position.y, 2);
  const auto transforms = robot::ToTransforms<tf2_msgs::TFMessage>(
      5, "odom", "base_link", {{{1, 2, 3}}, {{0, 0, 0, 1}}});
  ASSERT_EQ(transforms.transforms.size(), 1u);
  EXPECT_EQ(transforms.transforms[0].child_frame_id, "base_link");
  EXPECT_EQ(transforms.transforms[0].transform.rotation.z, 1);
  const auto diagnostics = robot::ToDiagnostics<diagnostic_msgs::DiagnosticArray>(
      {robot::Diagnosis::Level::kError, "no images", {{"pairs", "7"}}}, "facet");
  ASSERT_EQ(diagnostics.status.size(), 1u);
  EXPECT_EQ(diagnostics.status[0].level, 2);
  EXPECT_EQ(diagnostics.status[0].values.at(0).value, "7");
}

}  // namespace
}  // namespace ros1
}  // namespace facet
