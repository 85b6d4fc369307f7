// SPDX-License-Identifier: BSD-2-Clause
// A room whose walls are painted with squares of three sizes, and keyframes of flights through it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "facet/camera/camera_model.h"
#include "facet/camera/stereo_rig.h"
#include "facet/geometry/se3.h"
#include "facet/loop/place_record.h"
#include "facet/loop/saved_map.h"

namespace facet::testing {

/// 6 m x 5 m x 3 m about the origin.
class PaintedRoom {
 public:
  explicit PaintedRoom(std::uint64_t seed) : seed_(seed) {}

  /// How far the wall is along the ray, in lengths of the ray, from a place in the room.
  double Distance(const Vector3d& from_W, const Vector3d& ray_W) const {
    double nearest = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(ray_W[axis]) < 1e-9) continue;
      const double wall = ray_W[axis] > 0 ? kHalf[axis] : -kHalf[axis];
      nearest = std::min(nearest, (wall - from_W[axis]) / ray_W[axis]);
    }
    return nearest;
  }

  /// Each pixel is the mean of its four quarters.
  cv::Mat Picture(const CameraModel& camera, const SE3& T_WC) const {
    cv::Mat fine(2 * camera.height(), 2 * camera.width(), CV_8UC1);
    const Matrix3d R_WC = T_WC.R();
    const CameraIntrinsics& k = camera.intrinsics();  // without distortion
    for (int row = 0; row < fine.rows; ++row) {
      for (int column = 0; column < fine.cols; ++column) {
        const Vector3d ray_C(
            (0.5 * column - 0.25 - k.cx) / k.fx, (0.5 * row - 0.25 - k.cy) / k.fy, 1);
        fine.at<std::uint8_t>(row, column) = Grey(T_WC.p, R_WC * ray_C);
      }
    }
    cv::Mat picture;
    cv::resize(fine, picture, {camera.width(), camera.height()}, 0, 0, cv::INTER_AREA);
    return picture;
  }

  /// A keyframe from a true pose with an odometry that is off.
  KeyframeView View(std::int64_t number,
                    const CameraModel& camera,
                    const SE3& T_BC,
                    const SE3& T_trueB,
                    const SE3& T_WB) const {
    constexpr std::int64_t kInterval_ns = 500'000'000;
    KeyframeView view;
    view.frame = FrameId{number};
    view.t = Timestamp{number * kInterval_ns};
    view.camera = camera;
    view.T_WB = T_WB;
    view.T_BC = T_BC;
    view.sigma_theta.setConstant(2e-3);
    view.sigma_p.setConstant(2e-3 * (1.0 + static_cast<double>(number)));
    const SE3 T_trueC = T_trueB * T_BC;
    view.left = Picture(camera, T_trueC);
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(view.left, corners, 150, 0.01, 20);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector2d px(corners[i].x, corners[i].y);
      const auto bearing = camera.Unproject(px);
      if (!bearing) continue;
      const double distance = Distance(T_trueC.p, T_trueC.q * *bearing);
      view.points.push_back({LandmarkId{1000 * number + static_cast<std::int64_t>(i)},
                             px,
                             distance * *bearing,
                             0.01 * distance});
    }
    return view;
  }

 private:
  static constexpr std::array<double, 3> kHalf = {3, 2.5, 1.5};

  std::uint8_t Grey(const Vector3d& from_W, const Vector3d& ray_W) const {
    const Vector3d p = from_W + Distance(from_W, ray_W) * ray_W;
    int wall = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(std::abs(p[axis]) - kHalf[axis]) < 1e-6) wall = 2 * axis + (p[axis] > 0 ? 1 : 0);
    }
    const double u = wall / 2 == 0 ? p.y() : p.x(), v = wall / 2 == 2 ? p.y() : p.z();
    double grey = 30;
    for (const double side_m : {0.06, 0.2, 0.6}) {
      const auto column = static_cast<std::int64_t>(std::floor(u / side_m));
      const auto row = static_cast<std::int64_t>(std::floor(v / side_m));
      std::uint64_t z = seed_ * 0x9E3779B97F4A7C15ULL + static_cast<std::uint64_t>(wall) * 8191 +
                        static_cast<std::uint64_t>(column) * 0xBF58476D1CE4E5B9ULL +
                        static_cast<std::uint64_t>(row) * 0x94D049BB133111EBULL;
      z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
      z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
      grey += static_cast<double>(z >> 58);  // 0 to 63
    }
    return static_cast<std::uint8_t>(grey);
  }

  std::uint64_t seed_;
};

/// Without distortion.
inline CameraModel SmallCamera() {
  CameraIntrinsics k;
  k.width = 376;
  k.height = 240;
  k.fx = k.fy = 230;
  k.cx = 187.5;
  k.cy = 119.5;
  return CameraModel(k);
}

/// z of the camera along x of the body, y down.
inline SE3 LooksAhead() {
  Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Quaterniond(R), Vector3d(0.05, 0, 0)};
}

/// Two small cameras, 11 cm apart.
inline StereoRig SmallRig() {
  StereoRig rig;
  rig.cameras = {SmallCamera(), SmallCamera()};
  rig.T_BC = {LooksAhead(), LooksAhead()};
  rig.T_BC[1].p.y() -= 0.11;
  return rig;
}

/// The same places once more as those of a second run, 20 m away: rooms that look alike.
inline SavedMap Twice(const SavedMap& once) {
  const auto num_nodes = static_cast<int>(once.graph.nodes.size());
  const auto num_edges = static_cast<int>(once.graph.edges.size());
  SavedMap twice = once;
  twice.lenses.push_back(once.lenses[0]);
  for (std::size_t i = 0; i < once.keyframes.size(); ++i) {
    GraphNode& node = twice.graph.nodes.emplace_back(once.graph.nodes[i]);
    node.T_MW.p += Vector3d(20, 0, 0);
    if (node.edge_to_previous >= 0) node.edge_to_previous += num_edges;
    twice.keyframes.emplace_back(once.keyframes[i]).session = 1;
  }
  for (GraphEdge edge : once.graph.edges) {
    edge.first += num_nodes;
    edge.second += num_nodes;
    twice.graph.edges.push_back(edge);
  }
  for (PlaceRecord place : once.places) {
    place.node += num_nodes;
    place.session = 1;
    twice.places.push_back(place);
  }
  return twice;
}

}  // namespace facet::testing
