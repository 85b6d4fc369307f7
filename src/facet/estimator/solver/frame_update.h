// SPDX-License-Identifier: BSD-2-Clause
// Full state of a frame between keyframes, at a fraction of the cost of the window: the last
// keyframe (the reference) is free within its covariance, the landmarks are held to its pose, the
// frame is tied to the reference by the IMU and to the landmarks by its observations (docs/math.md,
// section 4.4).
#pragma once

#include <unordered_map>
#include <vector>

#include "facet/estimator/estimator_options.h"
#include "facet/estimator/factors/vision_factor.h"

namespace facet {

/// One observation, prepared for the estimator.
struct PreparedObservation {
  LandmarkId landmark;
  WindowObservation observation;  ///< `frame` is not used here
};

struct FrameUpdateResult {
  bool ok = false;
  int num_used = 0;  ///< observations of known landmarks
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();
};

/// Not thread-safe.
class FrameUpdater {
 public:
  FrameUpdater(const StereoRig& rig, const SolverOptions& options)
      : FrameUpdater(rig, options, options.robust()) {}
  FrameUpdater(const StereoRig& rig, const SolverOptions& options, const RobustOptions& robust)
      : geometry_(rig), options_(options), robust_(robust) {}

  /// Takes the newest frame of the window as reference, with its marginal covariance, and the
  /// landmarks that it sees.
  void SetReference(const SlidingWindow& window, const Matrix<15, 15>& covariance);

  /// `frame` holds the predicted state and the IMU interval since the reference; its state is
  /// updated.
  FrameUpdateResult Update(const std::vector<PreparedObservation>& observations,
                           WindowFrame& frame);

  void set_robust(const RobustOptions& robust) { robust_ = robust; }

  const WindowFrame& reference() const { return reference_; }

 private:
  /// A landmark of the window, held in the world as d_W + rho (p_WH - p).
  struct HeldLandmark {
    Vector3d d_W;
    Matrix<3, 2> B_W;
    double rho;
    Vector3d p_WH;
    Matrix3d covariance;  // of the two bearing directions and rho
    bool is_projection;
  };
  struct Match {
    const HeldLandmark* landmark;
    const WindowObservation* observation;
  };
  using System = std::pair<Matrix<30, 30>, Vector<30>>;

  /// Median of the norms of the whitened left errors.
  double MedianError(const std::vector<Match>& matches,
                     const WindowFrame& reference,
                     const WindowFrame& frame);
  void AddVision(const std::vector<Match>& matches,
                 const WindowFrame& reference,
                 const WindowFrame& frame,
                 double width,
                 System& system) const;
  void AddImu(const WindowFrame& reference, const WindowFrame& frame, System& system) const;

  FrameGeometry geometry_;
  SolverOptions options_;
  RobustOptions robust_;
  WindowFrame reference_;
  Matrix<15, 15> reference_information_ = Matrix<15, 15>::Zero();
  std::unordered_map<LandmarkId, HeldLandmark> landmarks_;
  std::vector<double> errors_;  // buffer of MedianError
};

}  // namespace facet
