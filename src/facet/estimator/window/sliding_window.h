// SPDX-License-Identifier: BSD-2-Clause
// The data of the fixed-lag smoother: frames, landmarks, the links between them and the prior.
// Plain data with the few operations that keep it consistent; the mathematics lives elsewhere.
#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/estimator/factors/imu_factor.h"
#include "facet/geometry/plane.h"
#include "facet/map/observation.h"
#include "facet/map/plane_relation.h"
#include "facet/map/plane_sighting.h"

namespace facet {

/// One stereo frame in the window.
///
/// Variables that appear in the prior are "frozen": their Jacobians are always taken at `lin`
/// (first-estimate Jacobians), and the estimate is x = lin (+) delta. For the others lin == x.
struct WindowFrame {
  FrameId id;
  bool is_keyframe = false;
  bool is_reported = false;  ///< the front end chose it as keyframe: its final pose is an output
  bool has_invented_imu =
      false;               ///< no samples since the frame before: constant velocity stands in
  bool has_motion = true;  ///< velocity and biases are variables; otherwise only the pose is
  bool pose_frozen = false;
  bool motion_frozen = false;
  NavState x;
  NavState lin;
  Vector<15> delta = Vector<15>::Zero();  ///< only the frozen parts are used

  /// IMU from the previous frame to this one; used while both have motion.
  ImuPreintegration imu;
  Matrix<15, 15> imu_sqrt_info = Matrix<15, 15>::Zero();
  bool has_imu_link = false;

  /// Applies a step in the tangent space of the pose and, if the frame has motion, of the rest.
  void ApplyStep(const Vector<15>& step);
};

/// One plane in the window: n . (p - anchor) = offset. The anchor is a constant near the surface,
/// so that normal and offset are hardly correlated wherever the origin is.
struct WindowPlane {
  PlaneId id;
  Vector3d anchor_W = Vector3d::Zero();
  Vector3d n = Vector3d::UnitZ();  ///< unit normal in W
  double offset = 0;               ///< [m]
  double row_sigma_m = 0.02;       ///< 1-sigma of the rows that hold landmarks on it (WeighPlanes)

  /// Once the prior touches it, Jacobians are taken at n_lin, and n = n_lin (+) delta.
  bool frozen = false;
  /// Known well enough to linearise about for good: only then may the prior touch it.
  bool settled = false;
  Vector3d n_lin = Vector3d::UnitZ();
  Vector3d delta = Vector3d::Zero();  ///< two tangent directions at n_lin [rad], offset [m]

  WindowPlane() = default;
  WindowPlane(PlaneId plane_id, const Plane& plane, const Vector3d& anchor)
      : id(plane_id),
        anchor_W(anchor),
        n(plane.n),
        offset(plane.d - plane.n.dot(anchor)),
        n_lin(plane.n) {}

  Plane plane() const { return {n, offset + n.dot(anchor_W)}; }
  double SignedDistance(const Vector3d& p_W) const { return n.dot(p_W - anchor_W) - offset; }

  /// Two tangent directions (TangentBasis of n_lin), offset.
  void ApplyStep(const Vector3d& step);
  void Freeze();
};

/// A relation in force. It is expressed relative to one frame, so that neither a common translation
/// nor a common turn about gravity changes anything (docs/math.md, section 8).
struct WindowRelation {
  PlaneRelation relation;               ///< Canonical()
  FrameId frame;                        ///< in the window; its heading carries the relation along
  Vector3d point_B = Vector3d::Zero();  ///< held to that frame: where offsets are compared
};

/// The planes a landmark lies on: an edge has two, a corner three.
struct PlaneLinks {
  static constexpr int kMax = 3;
  int count = 0;
  std::array<int, kMax> index{};  ///< into SlidingWindow::planes

  bool Contains(int plane) const;
  /// False if it is there already or there is no room.
  bool Add(int plane);
  void Remove(int plane);
};

/// One landmark in one stereo frame, in undistorted normalised coordinates.
struct WindowObservation {
  int frame = 0;  ///< index into SlidingWindow::frames
  bool has_right = false;
  /// [0] left, [1] right: measured x/z, y/z and the whitening 1/sigma * (d xy / d px)^-1.
  Vector2d xy[2] = {Vector2d::Zero(), Vector2d::Zero()};
  Matrix2d sqrt_info[2] = {Matrix2d::Zero(), Matrix2d::Zero()};
  double sigma_px[2] = {1, 1};  ///< 1-sigma of the pixels that sqrt_info was made with
};

/// A point as bearing and inverse distance in the left camera of its host frame.
struct WindowLandmark {
  LandmarkId id;
  int host = 0;                                 ///< index into SlidingWindow::frames
  bool has_depth = false;                       ///< false until stereo or parallax gave a distance
  Vector3d bearing_H = Vector3d::UnitZ();       ///< unit vector in the host's left camera
  double inverse_distance = 0;                  ///< 1/m, >= 0
  std::vector<WindowObservation> observations;  ///< in order of time; at most one per frame
  PlaneLinks planes;
  bool is_projection = false;  ///< pipeline SP: the paper's projection noise and loss

  /// A point this far away is not tied to planes: its distance means nothing.
  static constexpr double kMinPlaneInverseDistance = 0.02;
  bool IsOnPlanes() const {
    return planes.count > 0 && has_depth && inverse_distance > kMinPlaneInverseDistance;
  }
};

/// Quadratic prior 1/2 d^T H d + b^T d over frozen variables, d = delta of those variables.
struct MarginalPrior {
  struct Block {
    FrameId frame;
    bool is_motion = false;  ///< 9 columns v b_g b_a, otherwise 6 columns theta p
    int offset = 0;
    PlaneId plane{};  ///< valid: 3 columns of this plane, and no frame

    bool IsPlane() const { return plane.IsValid(); }
    int size() const { return IsPlane() ? 3 : is_motion ? 9 : 6; }
  };
  std::vector<Block> blocks;
  MatrixXd H;
  VectorXd b;
  int dim() const { return static_cast<int>(b.size()); }
};

/// Wide prior of the first frame; fixes origin and heading. Part of the MarginalPrior later.
struct StartPrior {
  bool active = false;
  FrameId frame;
  SE3 T_WB;  ///< position and heading that are kept
  double sigma_position = 1e-3, sigma_yaw = 1e-3;
  double sigma_velocity = 3, sigma_gyro_bias = 0.2, sigma_accel_bias = 0.2;
};

class SlidingWindow {
 public:
  std::vector<WindowFrame> frames;  ///< oldest first
  std::vector<WindowPlane> planes;
  std::vector<WindowRelation> relations;
  std::vector<PlaneSighting> sightings;  ///< of these frames and planes
  MarginalPrior prior;
  StartPrior start_prior;

  const std::vector<WindowLandmark>& landmarks() const { return landmarks_; }
  std::vector<WindowLandmark>& landmarks() { return landmarks_; }

  /// Null if the landmark is not in the window.
  WindowLandmark* Find(LandmarkId id);
  /// Index of the frame, or -1.
  int IndexOf(FrameId id) const;
  int IndexOf(PlaneId id) const;

  WindowLandmark& AddLandmark(LandmarkId id, int host);

  /// Removes the landmarks for which `flags[i]` is set.
  void RemoveLandmarks(const std::vector<char>& flags);

  /// Removes a frame: every observation in it goes; landmarks hosted there move to their next
  /// observation, those without any observation go. The prior must not contain the frame.
  void RemoveFrame(int index);

  /// Removes a plane, the links to it, its relations and its sightings. The prior must not contain
  /// it.
  void RemovePlane(int index);

  /// False if the relation exists, or a plane of it does not, or there is no frame to tie it to.
  bool AddRelation(const PlaneRelation& relation);

  /// Ties the relation to the newest frame but the one with index `leaving`, at a point between its
  /// planes.
  void AttachRelation(WindowRelation& relation, int leaving = -1) const;

  /// Where the landmark is in the world; its inverse distance must not be 0.
  Vector3d PositionOf(const WindowLandmark& landmark) const;

  /// Moves a landmark to the frame of its first remaining observation, keeping its place in the
  /// world.
  void Rehost(WindowLandmark& landmark, int new_host);

  void Clear();

  /// Left camera of the rig on the body; needed for re-hosting.
  SE3 T_BC0;

 private:
  void RebuildIndex();

  std::vector<WindowLandmark> landmarks_;
  std::unordered_map<LandmarkId, int> index_;
};

}  // namespace facet
