// SPDX-License-Identifier: BSD-2-Clause
// What a lens does to its image that the few coefficients of its model cannot say: ten smooth
// fields, whose amounts are estimated with the calibration (docs/math.md, section 10.9).
#pragma once

#include <array>

#include "facet/calibration/smooth_field.h"
#include "facet/camera/stereo_rig.h"

namespace facet {

/// What is assumed of the root mean square over the image, 1-sigma. Real lenses have two to three
/// times as much, which is found as well; a prior as wide as that gains nothing
/// (docs/notebook/calibration_online.md).
inline constexpr double kLensMisfitPrior_px = 0.05;

/// Displacements of pixels by polynomials of third order, without those that focal lengths,
/// principal point, radial and tangential distortion or a turn of the camera explain. Orthogonal
/// over the image; each has a root mean square of 1 px over the image and both axes. They depend
/// on the size of the image only, so that one camera's amounts mean the same from run to run.
class LensModes {
 public:
  LensModes(int width, int height);
  explicit LensModes(const CameraModel& camera) : LensModes(camera.width(), camera.height()) {}

  /// Each mode's displacement at a pixel, as the image's derivative by the amounts [px].
  Matrix<2, kNumLensModes> At(const Vector2d& px) const;

  /// The sum of the modes, each with its amount.
  SmoothField Sum(const LensModeVector& amounts) const;

  /// The amounts whose sum is nearest to a displacement over the image. `f`: at a pixel.
  template <class Function>
  LensModeVector Nearest(const Function& f) const {
    constexpr int kColumns = 48, kRows = 32;
    LensModeVector sum = LensModeVector::Zero();
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const Vector2d px((width_ - 1) * (column + 0.5) / kColumns,
                          (height_ - 1) * (row + 0.5) / kRows);
        sum += At(px).transpose() * f(px);
      }
    }
    return sum / (2 * kColumns * kRows);
  }

 private:
  int width_, height_;
  // Rows: of each mode the displacement along x, then along y. Columns: of the monomials.
  Matrix<2 * kNumLensModes, kNumMonomials> coefficients_;
};

/// What the left and the right lens do beside their models.
using LensFields = std::array<SmoothField, 2>;

LensFields FieldsOf(const StereoRig& rig);

/// Where the model of the left or the right camera has what is measured at `px`.
inline Vector2d ByModel(const LensFields& beside_model, int camera, const Vector2d& px) {
  return px - beside_model[static_cast<std::size_t>(camera)].At(px);
}

}  // namespace facet
