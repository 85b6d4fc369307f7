// SPDX-License-Identifier: BSD-2-Clause
// The sum of all factors on one landmark.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "facet/calibration/calibration_vector.h"
#include "facet/estimator/window/window_plane.h"

namespace facet {

/// Linearised rows of one landmark, already squared: normal equations in (frames, planes,
/// landmark), ready to be eliminated (docs/math.md, section 4.2). Landmark order: two tangent
/// directions of the bearing (TangentBasis), inverse distance.
///
/// Every row has columns for the pose of its own frame and for the landmark only: the landmark's
/// step is expressed in the world, so the motion of its host does not appear. After elimination
/// this is the same reduced system as with host columns (section 3.2).
struct LandmarkBlock {
  struct View {
    int frame = 0;
    Matrix<6, 3> W;  ///< pose-landmark
    Matrix<6, 3> Y;  ///< W L^-T, filled by Eliminate
  };
  /// What a view says of its pose alone.
  struct PoseSquare {
    Matrix<6, 6> H;
    Vector<6> b;  ///< gradient
  };
  /// The row that ties the landmark to a plane, not squared: its products have rank one.
  struct PlaneView {
    int plane = 0;
    Vector3d J_plane;
    Vector3d J_landmark;
    double residual = 0;
    Vector3d z;  ///< L^-1 J_landmark, filled by Eliminate
  };
  /// Products with the 42 columns of lenses and stereo pair; only if the calibration is a variable.
  struct LensColumns {
    Matrix<kNumLensColumns, 3> W;  ///< calibration-landmark
    Matrix<kNumLensColumns, 3> Y;  ///< W L^-T, filled by Eliminate
    bool has_modes = true;         ///< otherwise the rows of the lenses' modes are zero
  };
  LandmarkBlock() = default;
  LandmarkBlock(LandmarkBlock&&) = default;
  LandmarkBlock& operator=(LandmarkBlock&&) = default;  ///< what is moved from is not used again

  int index = -1;  ///< of the landmark in the window
  /// In the block's own memory, or in that of someone who keeps many blocks.
  std::span<View> views;
  /// Of the same views. Only AddDiagonal needs them: who keeps many blocks lends one buffer to all.
  std::vector<PoseSquare> pose_squares;
  int num_views = 0;
  std::array<PlaneView, PlaneLinks::kMax> plane_views;
  int num_plane_views = 0;
  std::vector<LensColumns> lens;  ///< one or none
  Matrix3d V;                     ///< landmark-landmark
  Vector3d b;                     ///< gradient
  Matrix3d L;                     ///< Cholesky factor of the damped V, filled by Eliminate
  Vector3d y;                     ///< L^-1 b, filled by Eliminate
  double cost = 0;

  /// Empty, with room for so many views. Keeps the storage.
  void Clear(std::size_t max_views) {
    if (views.size() < max_views) {
      own_views_.resize(max_views);
      views = own_views_;
    }
    if (pose_squares.size() < max_views) pose_squares.resize(max_views);
    num_views = num_plane_views = 0;
    lens.clear();
    V.setZero();
    b.setZero();
    cost = 0;
  }

 private:
  std::vector<View> own_views_;
};

/// What all landmarks say of lenses and stereo pair, before their elimination.
struct LensSums {
  Matrix<kNumLensColumns, kNumLensColumns> H;     ///< lower triangle
  Vector<kNumLensColumns> b;                      ///< gradient
  std::vector<Matrix<kNumLensColumns, 6>> poses;  ///< calibration-pose, by frame

  void Clear(std::size_t num_frames) {
    H.setZero();
    b.setZero();
    poses.assign(num_frames, Matrix<kNumLensColumns, 6>::Zero());
  }
};

}  // namespace facet
