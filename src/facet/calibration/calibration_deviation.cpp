// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/calibration_deviation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/geometry/angles.h"

namespace facet {

namespace {

// In units of what a careful calibration leaves, and of what is still uncertain.
constexpr double kGross = 5, kCertain = 4;

constexpr const char* kFarPoints =
    "far points in the right image (a turn of that camera about y, or a principal point)";

// A linear function of the deviations.
struct Quantity {
  CalibrationPart part;
  std::string what, unit;
  CalibrationVector gradient = CalibrationVector::Zero();
};

/// By how many pixels each coefficient moves points at the left and the right edge away from the
/// middle.
Vector4d OutwardsAtEdge(const CameraModel& camera) {
  const CameraIntrinsics& k = camera.intrinsics();
  Vector4d outwards = Vector4d::Zero();
  for (const double side : {-1.0, 1.0}) {
    const Vector2d px(0.5 * (1 + side) * (k.width - 1), k.cy);
    const auto ray = camera.Unproject(px);
    if (!ray) continue;
    outwards += 0.5 * side * IntrinsicsJacobian(k, *ray, px).row(0).tail<4>().transpose();
  }
  return outwards;
}

void AddLens(const StereoRig& rig, int camera, std::vector<Quantity>& out) {
  const CameraModel& model = rig.cameras[static_cast<std::size_t>(camera)];
  const CameraIntrinsics& k = model.intrinsics();
  const std::string of = camera == 0 ? " of the left camera" : " of the right camera";
  const int first = camera * kNumIntrinsics;
  Quantity focal{CalibrationPart::kLenses, "focal length" + of, "%"};
  focal.gradient(first) = 50 / k.fx;
  focal.gradient(first + 1) = 50 / k.fy;
  out.push_back(std::move(focal));
  for (int axis = 0; axis < 2; ++axis) {
    Quantity point{
        CalibrationPart::kLenses, std::string("principal point") + of + " in " + "xy"[axis], "px"};
    point.gradient(first + 2 + axis) = 1;
    out.push_back(std::move(point));
  }
  Quantity distortion{CalibrationPart::kDistortion, "distortion at the edge" + of, "px"};
  distortion.gradient.segment<4>(first + 4) = OutwardsAtEdge(model);
  out.push_back(std::move(distortion));
}

void AddAxes(CalibrationPart part,
             const std::string& what,
             const std::string& unit,
             int first,
             double scale,
             std::vector<Quantity>& out) {
  for (int axis = 0; axis < 3; ++axis) {
    Quantity quantity{part, what + ' ' + "xyz"[axis], unit};
    quantity.gradient(first + axis) = scale;
    out.push_back(std::move(quantity));
  }
}

/// By how much the right pixel of a far point lies farther to the right, given its left pixel. A
/// turn about y and the principal points do the same, so that each of them alone is known badly.
Quantity FarPoints(const StereoRig& rig) {
  const double f = rig.cameras[1].intrinsics().fx;
  Quantity far{CalibrationPart::kLenses, kFarPoints, "px"};
  far.gradient(kNumIntrinsics + 2) = 1;
  far.gradient(2) = -f / rig.cameras[0].intrinsics().fx;
  far.gradient(kStereoRotation + 1) = f;
  return far;
}

std::vector<Quantity> QuantitiesOf(const StereoRig& rig) {
  std::vector<Quantity> out;
  AddLens(rig, 0, out);
  AddLens(rig, 1, out);
  AddAxes(CalibrationPart::kLenses,
          "right camera against the left one about",
          "deg",
          kStereoRotation,
          1 / kDegree,
          out);
  out.push_back(FarPoints(rig));
  const Vector3d t = rig.T_C1C0().p;
  Quantity baseline{CalibrationPart::kBaseline, "baseline", "%"};
  baseline.gradient.segment<3>(kStereoTranslation) = 100 * t / t.squaredNorm();
  out.push_back(std::move(baseline));
  AddAxes(
      CalibrationPart::kMount, "cameras on the IMU about", "deg", kMountRotation, 1 / kDegree, out);
  AddAxes(CalibrationPart::kMount, "cameras on the IMU along", "mm", kMountTranslation, 1e3, out);
  Quantity clock{CalibrationPart::kClock, "time offset", "ms"};
  clock.gradient(kTimeOffset) = 1e3;
  out.push_back(std::move(clock));
  AddAxes(CalibrationPart::kGyroscope, "scale of the gyroscope about", "%", kGyroScale, 100, out);
  return out;
}

double SigmaOf(const CalibrationVector& gradient, const CalibrationMatrix& covariance) {
  return std::sqrt(std::max(gradient.dot(covariance * gradient), 0.0));
}

}  // namespace

std::vector<CalibrationDeviation> CalibrationDeviations(const StereoRig& nominal,
                                                        const CalibrationVector& delta,
                                                        const CalibrationMatrix& covariance,
                                                        const CalibrationMatrix& prior) {
  std::vector<CalibrationDeviation> out;
  for (Quantity& q : QuantitiesOf(nominal)) {
    out.push_back({q.part,
                   std::move(q.what),
                   std::move(q.unit),
                   q.gradient.dot(delta),
                   SigmaOf(q.gradient, covariance),
                   SigmaOf(q.gradient, prior)});
  }
  return out;
}

std::vector<CalibrationDeviation> GrossDeviations(const StereoRig& nominal,
                                                  const CalibrationVector& delta,
                                                  const CalibrationMatrix& covariance,
                                                  const CalibrationMatrix& prior) {
  std::vector<CalibrationDeviation> out = CalibrationDeviations(nominal, delta, covariance, prior);
  std::erase_if(out, [](const CalibrationDeviation& d) {
    const double size = std::abs(d.value);
    return !(size > kGross * d.prior_sigma && size > kCertain * d.sigma);
  });
  // Not beside what they follow from.
  const auto num_of_lenses = std::count_if(
      out.begin(), out.end(), [](const auto& d) { return d.part == CalibrationPart::kLenses; });
  if (num_of_lenses > 1)
    std::erase_if(out, [](const CalibrationDeviation& d) { return d.what == kFarPoints; });
  return out;
}

std::string InWords(const std::vector<CalibrationDeviation>& deviations) {
  std::string text;
  for (const CalibrationDeviation& d : deviations) {
    char value[40];
    std::snprintf(value, sizeof(value), " %+.2g ", d.value);
    text += (text.empty() ? "" : ", ") + d.what + value + d.unit;
  }
  return text;
}

}  // namespace facet
