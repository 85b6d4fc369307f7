// SPDX-License-Identifier: BSD-2-Clause
// What a robot's middleware is told: plain numbers in the order and the frames that ROS has, and
// nothing of ROS itself. Frames: odom is the world of Facet (z up), base the robot's own frame.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "facet/facet.h"

namespace facet {
namespace robot {

/// 6 x 6, row by row, in the order of nav_msgs and geometry_msgs: x y z, then rotation about the
/// fixed axes x y z.
using Covariance6 = std::array<double, 36>;

/// nav_msgs/Odometry, at the stamp of an IMU sample.
struct OdometryOutput {
  std::int64_t t_ns = 0;
  api::Pose T_odom_base;
  api::Vec3 v_base{{0, 0, 0}};  ///< of the base's origin, along its own axes [m/s]
  api::Vec3 w_base{{0, 0, 0}};  ///< along its own axes [rad/s]
  Covariance6 pose_covariance{{}}, twist_covariance{{}};  ///< of the pose: along odom's axes
};

/// The causal pose of one stereo pair, at the stamp of its left image.
struct PoseOutput {
  std::int64_t t_ns = 0;
  api::Pose T_odom_base;
  Covariance6 covariance{{}};
};

struct PathPose {
  std::int64_t t_ns = 0;
  api::Pose T_odom_base;
};

/// A part of the map that has changed. `id` is the same for the same part of space.
struct MapPartOutput {
  std::int32_t id = 0;
  api::Mesh mesh;  ///< without faces: it is to be removed
};

struct PlanesOutput {
  std::int64_t t_ns = 0;
  std::vector<api::Plane> planes;     ///< all there are
  std::vector<std::int64_t> removed;  ///< ids that were in the output before and are no more
};

enum class LogLevel { kInfo, kWarning, kError };

/// The middleware's side. The functions are called on several threads, each of them on one at a
/// time; none may call RobotNode, but for `Wants...`, nor wait for it.
class RobotListener {
 public:
  virtual ~RobotListener() = default;

  /// On the thread that adds IMU samples, once for each: must return at once.
  virtual void OnOdometry(const OdometryOutput& odometry) = 0;
  /// On the estimator's thread: short.
  virtual void OnPose(const PoseOutput& pose) = 0;
  virtual void OnPath(const std::vector<PathPose>& path) = 0;
  /// Where odom lies in the map: at the begin the identity, but for who is looked for in the map of
  /// earlier runs; then whenever a place is recognised. A heading and a position.
  virtual void OnMapTransform(const api::Pose& T_map_odom) = 0;
  /// On a thread of their own.
  virtual void OnMesh(const api::Mesh& horizon) = 0;
  virtual void OnMap(std::int64_t t_ns, const std::vector<MapPartOutput>& parts) = 0;
  virtual void OnPlanes(const PlanesOutput& planes) = 0;
  /// Everything begins again: path, mesh, map and planes are void.
  virtual void OnClear() = 0;
  virtual void OnLog(LogLevel level, const std::string& text) = 0;

  /// Whether anybody listens: what nobody wants is not made.
  virtual bool WantsOdometry() const { return true; }
  virtual bool WantsMesh() const { return true; }
  virtual bool WantsScene() const { return true; }  ///< map and planes
};

/// diagnostic_msgs/DiagnosticStatus.
struct Diagnosis {
  enum class Level { kOk = 0, kWarning = 1, kError = 2 };
  Level level = Level::kOk;
  std::string summary;
  std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace robot
}  // namespace facet
