// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_error.h"

#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "facet/base/check.h"
#include "facet/calibration/calibration_groups.h"
#include "facet/calibration/lens_modes.h"

namespace facet {

namespace {

// Where the right camera sees what is at infinity behind a left pixel.
class FarPoints {
 public:
  explicit FarPoints(const StereoRig& rig) : rig_(rig), beside_model_(FieldsOf(rig)) {}

  std::optional<Vector2d> RightPixel(const Vector2d& px) const {
    const std::optional<Vector3d> ray = rig_.cameras[0].Unproject(ByModel(beside_model_, 0, px));
    if (!ray) return std::nullopt;
    const std::optional<Vector2d> by_model = rig_.cameras[1].Project(rig_.T_C1C0().q * *ray);
    if (!by_model) return std::nullopt;
    return Vector2d(*by_model + beside_model_[1].At(*by_model));
  }

 private:
  const StereoRig& rig_;
  LensFields beside_model_;
};

void CompareDisparities(const StereoRig& estimate, const StereoRig& truth, CalibrationError& out) {
  const FarPoints by_truth(truth), by_estimate(estimate);
  constexpr int kPlaces = 24;  // along each side of the image
  const CameraModel& left = truth.cameras[0];
  Vector2d sum = Vector2d::Zero(), squares = Vector2d::Zero();
  int num = 0;
  for (int i = 0; i < kPlaces; ++i) {
    for (int j = 0; j < kPlaces; ++j) {
      const Vector2d px((i + 0.5) * left.width() / kPlaces, (j + 0.5) * left.height() / kPlaces);
      const auto is = by_truth.RightPixel(px), seems = by_estimate.RightPixel(px);
      if (!is || !seems || !truth.cameras[1].IsInside(*is, 0)) continue;
      const Vector2d error = *seems - *is;
      sum += error;
      squares += error.cwiseAbs2();
      ++num;
    }
  }
  if (num == 0) return;
  out.disparity_mean_px = sum.x() / num;
  out.disparity_rms_px = std::sqrt(squares.x() / num);
  out.vertical_rms_px = std::sqrt(squares.y() / num);
}

std::optional<double> NeesOf(const CalibrationVector& all_errors, const CalibrationMatrix& of_all) {
  std::vector<int> estimated;
  for (const auto& [first, size] : kCalibrationGroups) {
    if (AreHeld(of_all, first, size)) continue;
    for (int k = 0; k < size; ++k)
      estimated.push_back(first + k);
  }
  if (estimated.empty()) return std::nullopt;
  const MatrixXd covariance = of_all(estimated, estimated);
  const VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const VectorXd z = scale.cwiseProduct(all_errors(estimated));
  return z.dot(correlation.ldlt().solve(z)) / static_cast<double>(estimated.size());
}

}  // namespace

CalibrationError CompareCalibrations(const StereoRig& estimate, const StereoRig& truth) {
  CalibrationError out;
  out.error = CalibrationDifference(truth, estimate);
  CompareDisparities(estimate, truth, out);
  if (estimate.covariance) {
    FACET_CHECK(estimate.covariance->rows() == kNumCalibration);
    CalibrationMatrix covariance = *estimate.covariance;
    covariance.diagonal().segment<3>(kMountRotation).array() += std::pow(estimate.axes_sigma, 2);
    out.nees = NeesOf(out.error, covariance);
  }
  return out;
}

}  // namespace facet
