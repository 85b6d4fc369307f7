// SPDX-License-Identifier: BSD-2-Clause
// Reprojection of one landmark into all frames that see it, linearised and ready to be eliminated.
// Equations (3.x) of docs/math.md.
//
// Every row has columns for the pose of its own frame and for the landmark only: the landmark's
// step is expressed in the world, so the motion of its host does not appear. After elimination this
// is the same reduced system as with host columns.
#pragma once

#include <array>
#include <vector>

#include "facet/estimator/factors/robust_options.h"
#include "facet/estimator/window/sliding_window.h"

namespace facet {

/// Poses of the frames as the vision rows need them; refreshed before each linearisation.
class FrameGeometry {
 public:
  struct Pose {
    Matrix3d R_BW;
    Vector3d p_WB;
    Matrix3d R_WC0;
    Vector3d p_WC0;
    Matrix3d R_CW[2];  ///< of the left and the right camera
    Vector3d p_WC[2];
  };

  explicit FrameGeometry(const StereoRig& rig);

  /// Takes the current estimates (and the frozen ones, for the Jacobians) of all frames.
  void Update(const std::vector<WindowFrame>& frames);

  const Pose& current(int frame) const { return current_[frame]; }
  const Pose& frozen(int frame) const { return frozen_[frame]; }

  Matrix3d R_CB[2];
  Vector3d p_BC[2];

 private:
  std::vector<Pose> current_;
  std::vector<Pose> frozen_;
};

/// Linearised rows of one landmark, already squared: normal equations in (frames, landmark).
/// Landmark order: two tangent directions of the bearing (TangentBasis), inverse distance.
struct LandmarkBlock {
  struct View {
    int frame = 0;
    Matrix<6, 6> H;  ///< pose-pose
    Vector<6> b;     ///< gradient
    Matrix<6, 3> W;  ///< pose-landmark
    Matrix<6, 3> Y;  ///< W L^-T, filled by Eliminate
  };
  /// The row that ties the landmark to a plane, not squared: its products have rank one.
  struct PlaneView {
    int plane = 0;
    Vector3d J_plane;
    Vector3d J_landmark;
    double residual = 0;
    Vector3d z;  ///< L^-1 J_landmark, filled by Eliminate
  };
  int index = -1;  ///< of the landmark in the window
  std::vector<View> views;
  int num_views = 0;
  std::array<PlaneView, PlaneLinks::kMax> plane_views;
  int num_plane_views = 0;
  Matrix3d V;  ///< landmark-landmark
  Vector3d b;  ///< gradient
  Matrix3d L;  ///< Cholesky factor of the damped V, filled by Eliminate
  Vector3d y;  ///< L^-1 b, filled by Eliminate
  double cost = 0;
};

/// Residual of one camera of one observation, in sigmas of the front end; empty if the point is not
/// in front of it.
std::optional<Vector2d> WhitenedError(const FrameGeometry& geometry,
                                      const WindowLandmark& landmark,
                                      const WindowObservation& observation,
                                      int camera);

/// Times the above: the residual in the sigmas that count. Not 1 for the landmarks of pipeline SP
/// only, whose noise is that of the paper's projection factors.
double NoiseScale(const WindowLandmark& landmark,
                  const WindowObservation& observation,
                  int camera,
                  const RobustOptions& robust);

/// Fills `block` (reusing its storage): reprojections and distances to planes (docs/math.md,
/// section 6; paper, equation (9)).
void LinearizeLandmark(const FrameGeometry& geometry,
                       const std::vector<WindowPlane>& planes,
                       const WindowLandmark& landmark,
                       const RobustOptions& robust,
                       LandmarkBlock& block);

/// Robust cost of one landmark: sum of rho(|r|).
double LandmarkCost(const FrameGeometry& geometry,
                    const std::vector<WindowPlane>& planes,
                    const WindowLandmark& landmark,
                    const RobustOptions& robust);

/// Factorises V (damped by lambda times its diagonal) and prepares Y of all views.
void Eliminate(double lambda, LandmarkBlock& block);

}  // namespace facet
