// SPDX-License-Identifier: BSD-2-Clause
// Full state of a frame between keyframes, at a fraction of the cost of the window: the last
// keyframe (the reference) is free within its covariance, the landmarks are held to its pose, the
// frame is tied to the reference by the IMU and to the landmarks by its observations
// (docs/math.md, section 4.4).
#pragma once

#include <memory_resource>
#include <unordered_map>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/factors/landmark_block.h"
#include "facet/estimator/window/frame_geometry.h"
#include "facet/estimator/window/frame_observations.h"

namespace facet {

/// What the landmarks say of the motion that the IMU alone predicts.
struct InnovationTest {
  int num_tested = 0;         ///< observations of landmarks whose place is known
  int num_contradicting = 0;  ///< of them
  /// Of those tested, landmarks that have agreed with the IMU at several keyframes before.
  int num_witnesses = 0;
  int num_contradicting_witnesses = 0;
  /// By observation: it was tested, and its landmark is where it should be.
  std::vector<char> agrees;
  /// By observation: its landmark has moved, or is mistaken for another one.
  std::vector<char> contradicts;
  std::vector<char> is_witness;  ///< by observation
};

struct FrameUpdateResult {
  bool ok = false;
  int num_used = 0;  ///< observations of known landmarks
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
};

/// Not thread-safe.
class FrameUpdater {
 public:
  FrameUpdater(const StereoRig& rig, const SolverOptions& options, const BiasWalk& walk)
      : geometry_(rig), options_(options), walk_(walk) {}

  /// Takes the newest frame of the window as reference, with its marginal covariance, and the
  /// landmarks that it sees.
  void SetReference(const SlidingWindow& window,
                    const Matrix<15, 15>& covariance,
                    const FactorNoise& noise);

  /// Which left pixels are further from where the landmarks of the window must be seen than pixel
  /// noise, landmark and prediction together allow. The prediction is that of the IMU alone, `imu`,
  /// from the reference to the frame.
  InnovationTest TestInnovations(const std::vector<PreparedObservation>& observations,
                                 const ImuLink& imu) const;

  /// `x`: the predicted state of the frame, which is updated. `imu`: from the reference to it.
  /// `noise`: as for the reference.
  FrameUpdateResult Update(const std::vector<PreparedObservation>& observations,
                           const ImuLink& imu,
                           const FactorNoise& noise,
                           NavState& x);

 private:
  /// A landmark of the window, held in the world as d_W + rho (p_WH - p).
  struct HeldLandmark {
    Vector3d d_W;
    Matrix<3, 2> B_W;
    double rho;
    Vector3d p_WH;
    Matrix3d covariance;  // of the two bearing directions and rho
    bool is_projection;
    bool is_witness;
    bool is_seen;  // in the reference
  };
  struct Match {
    const HeldLandmark* landmark;
    const WindowObservation* observation;
  };
  /// Two rows of one camera, whitened by the pixel noise alone.
  struct Rows {
    Vector2d r;
    Matrix<2, 6> J_pose;
    Matrix<2, 3> J_landmark;
  };
  /// Where the frame is, as the landmarks see it.
  struct View {
    SE3 T_HB;
    Matrix3d R_BH, R_BW;
  };
  /// What all of them say about the pose of the frame.
  struct PoseSystem {
    Matrix<6, 6> H = Matrix<6, 6>::Zero();
    Vector<6> b = Vector<6>::Zero();
  };
  /// Normal equations of the reference (columns 0 to 14) and the frame.
  struct System {
    Matrix<30, 30> H;
    Vector<30> b;
  };

  LandmarkInformation InformationOn(const WindowLandmark& landmark,
                                    const SlidingWindow& window,
                                    const FactorNoise& noise);
  View ViewOf(const NavState& reference, const NavState& frame, const ImuLink& imu) const;
  /// Of the direction h of the camera, by the present calibration, in sigmas.
  Vector2d ErrorOf(const WindowObservation& observation, int camera, const Vector3d& h) const;
  /// False if the landmark is not predicted near the measured ray.
  bool Linearize(const Match& match, int camera, const View& view, double scale, Rows& rows) const;
  std::vector<Match> FindMatches(const std::vector<PreparedObservation>& observations) const;
  /// Median of the norms of the whitened left errors.
  double MedianError(const std::vector<Match>& matches, const View& view);
  void AddVision(const std::vector<Match>& matches,
                 const NavState& reference,
                 const NavState& frame,
                 const View& view,
                 const FactorNoise& noise,
                 System& system) const;
  void AddRows(const Rows& rows,
               const Matrix3d& landmark_covariance,
               double width,
               PoseSystem& pose) const;
  static void AddRelativePose(const PoseSystem& pose, const Matrix<6, 6>& G, System& system);
  static void AddImu(const ImuLink& imu,
                     const NavState& reference,
                     const NavState& frame,
                     System& system);

  FrameGeometry geometry_;
  SolverOptions options_;
  BiasWalk walk_;
  NavState reference_;
  /// Of what carries on into the motion: its place and heading do not, the landmarks share them.
  Matrix<15, 15> reference_motion_covariance_ = Matrix<15, 15>::Zero();
  Matrix<15, 15> reference_information_ = Matrix<15, 15>::Zero();
  std::pmr::unsynchronized_pool_resource landmark_memory_;  // kept from keyframe to keyframe
  std::pmr::unordered_map<LandmarkId, HeldLandmark> landmarks_{&landmark_memory_};
  LandmarkBlock block_;
  std::vector<double> errors_;  // buffer of MedianError
};

}  // namespace facet
