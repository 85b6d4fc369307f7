// SPDX-License-Identifier: BSD-2-Clause
// The calibration of two cameras with a board: intrinsics of both and the transform between them,
// estimated together with the poses of the board by least squares. What such a calibration finds
// for made-up views, and how uncertain that is.
#pragma once

#include <optional>

#include "facet/calibration/board_views.h"
#include "facet/calibration/rig_parameters.h"
#include "facet/calibration/smooth_field.h"

namespace facet {

struct BoardCalibrationOptions {
  BoardOptions board;
  /// White noise of a detected corner, 1-sigma of each coordinate.
  double corner_noise_px = 0.2;
  /// Root mean square over the image of what a lens does that its model cannot say, in units of
  /// `corner_noise_px`: a SmoothField in each camera.
  double misfit_share = 0.75;
};

/// Where the corners of a view were found: pixels in the order of BoardView::corners.
struct DetectedView {
  std::array<std::vector<Vector2d>, 2> corners;
};

/// The corners of all views as a detector finds them: projected by the exact rig, displaced by a
/// field of each camera, with noise.
std::vector<DetectedView> DetectCorners(const StereoRig& exact,
                                        const std::vector<BoardView>& views,
                                        const BoardCalibrationOptions& options,
                                        Rng& rng);

/// The rig that explains the corners best. `start` and the poses of the views are where the search
/// begins. Coefficients of distortion that the lens models do not have stay zero. The left camera
/// stays where it is in the body. Empty if the search leaves what a camera can be.
std::optional<StereoRig> CalibrateWithBoard(const StereoRig& start,
                                            std::vector<BoardView> views,
                                            const std::vector<DetectedView>& detected);

/// Joint covariance of the parameters that CalibrateWithBoard finds, over noise and fields, for one
/// set of made-up views (the same for every call). It scales with the square of `corner_noise_px`.
/// Rows of coefficients that a lens model does not have are zero. Empty if the cameras do not see
/// the same things in front of them (MakeUpBoardViews).
std::optional<RigMatrix> BoardCalibrationCovariance(const StereoRig& rig,
                                                    const BoardCalibrationOptions& options = {});

}  // namespace facet
