// SPDX-License-Identifier: BSD-2-Clause
// A landmark seen by the cameras of one frame (docs/math.md, equations (3.1) to (3.4)). Pixel noise
// is in WindowObservation::rays; where the match has a noise of its own, the right pixel
// counts by how far it is from the left one (section 3.4); Geman and McClure's loss, or for the
// landmarks of pipeline SP the paper's noise and Tukey's loss (section 4.1).
#pragma once

#include <array>
#include <optional>

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/factors/hosted_point.h"
#include "facet/estimator/factors/landmark_block.h"
#include "facet/estimator/factors/robust_loss.h"

namespace facet {

struct LensRow;
struct VisionRow;

/// One landmark in one stereo frame. A view of the window, as in factor.h, but one that adds up in
/// a LandmarkBlock.
class ReprojectionFactor {
 public:
  ReprojectionFactor(const FrameGeometry& geometry,
                     const WindowLandmark& landmark,
                     const WindowObservation& observation,
                     const FactorNoise& noise)
      : geometry_(geometry), landmark_(landmark), observation_(observation), noise_(noise) {}

  /// Of the left and the right camera; of the left one only if only that one sees the landmark.
  using Errors = std::array<std::optional<Vector2d>, 2>;

  /// Residuals in sigmas of the front end; empty if the point is not near the measured ray, or out
  /// of the lens's view. Of the right camera, if the match has a noise of its own: what the match
  /// is off.
  Errors ErrorsOf(const HostedPoint& point) const { return FromPixelErrors(PixelErrors(point)); }

  /// Times the above: the residual in the sigmas that count. Not 1 for the landmarks of pipeline SP
  /// only, whose noise is that of the paper's projection factors.
  double NoiseScale(int camera) const;

  /// Robust cost of all cameras that see the landmark.
  double Cost(const HostedPoint& point) const;

  /// Adds the rows of both cameras to the block, as one more view; and their columns of lenses and
  /// stereo pair to `lens`, unless it is null.
  void AddTo(const LinearizedPoint& point, LandmarkBlock& block, LensSums* lens = nullptr) const;

 private:
  bool HasMatchNoise() const {
    return observation_.has_right && observation_.sigma_match_px > 0 && !landmark_.is_projection;
  }
  int num_cameras() const { return observation_.has_right ? 2 : 1; }
  RobustLoss Loss(const std::optional<Vector2d>& error, int camera) const;
  Errors PixelErrors(const HostedPoint& point) const;
  Errors FromPixelErrors(const Errors& pixels) const;
  bool MakeCameraRows(const LinearizedPoint& point,
                      int camera,
                      double weight,
                      const std::optional<Vector2d>& error,
                      VisionRow* rows,
                      LensRow* lens) const;

  const FrameGeometry& geometry_;
  const WindowLandmark& landmark_;
  const WindowObservation& observation_;
  const FactorNoise& noise_;
};

/// ReprojectionFactor::Error of the landmark where it is.
std::optional<Vector2d> ReprojectionError(const FrameGeometry& geometry,
                                          const WindowLandmark& landmark,
                                          const WindowObservation& observation,
                                          int camera);

}  // namespace facet
