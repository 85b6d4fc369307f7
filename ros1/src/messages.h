// SPDX-License-Identifier: BSD-2-Clause
// From the messages of ROS 1 to plain data, and back. Bytes of images are not copied.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include "facet/robot/image_pairer.h"
#include "facet/robot/marker.h"
#include "facet/robot/node_parameters.h"
#include "facet/robot/robot_output.h"

namespace facet {
namespace ros1 {

using robot::FrameNames;

// ---- what comes

api::ImuSample ToSample(const sensor_msgs::Imu& message);
/// The message lives as long as what it gives.
robot::ReceivedImage ToImage(const sensor_msgs::ImageConstPtr& message);
robot::ReceivedImage ToImage(const sensor_msgs::CompressedImageConstPtr& message);
api::CameraInfo ToCameraInfo(const sensor_msgs::CameraInfo& message);

// ---- what is published

ros::Time ToTime(std::int64_t t_ns);
std_msgs::Header Header(std::int64_t t_ns, const std::string& frame);
geometry_msgs::Pose ToPose(const api::Pose& pose);
geometry_msgs::TransformStamped ToTransform(std_msgs::Header header,
                                            const std::string& child,
                                            const api::Pose& pose);
nav_msgs::Odometry ToOdometry(const robot::OdometryOutput& output, const FrameNames& frames);
geometry_msgs::PoseWithCovarianceStamped ToPose(const robot::PoseOutput& output,
                                                const FrameNames& frames);
nav_msgs::Path ToPath(const std::vector<robot::PathPose>& path, const FrameNames& frames);

visualization_msgs::Marker ToMarker(const robot::Marker& marker, const FrameNames& frames);
visualization_msgs::MarkerArray ToMarkers(const std::vector<robot::Marker>& markers,
                                          const FrameNames& frames);
/// The vertices: x y z and, where they have colours, rgb.
sensor_msgs::PointCloud2 ToPoints(std_msgs::Header header, const api::Mesh& mesh);

diagnostic_msgs::DiagnosticStatus ToStatus(const robot::Diagnosis& diagnosis,
                                           const std::string& node);

}  // namespace ros1
}  // namespace facet
