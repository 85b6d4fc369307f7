// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/stereo_turn.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include <Eigen/Cholesky>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// A turn about y moves points along their epipolar lines, nearly as depth does: what the matches
// say of it is a hundredth of a degree of chance, and each is a tenth of a pixel of disparity.
const Vector3d kPriorSigma = Vector3d(0.5, 0.005, 0.5) * kDegree;
// Of a distance from the epipolar line.
constexpr double kSigma_px = 0.3;
// In units of sigma: wide at first, so that all good matches take part, then narrow.
constexpr double kLossWidths[] = {15, 5, 3};
constexpr int kNumSteps = 5;
// Careful calibrations drawn at random usually leave 0.2 px.
constexpr double kLeastBefore_px = 0.5, kLargestShareAfter = 0.5;
// A turn leaves what the calibration had before it; right images of another moment, which some turn
// explains in part, leave more.
constexpr double kLargestAfter_px = 0.5;
constexpr int kMinMatches = 60;

// Sine of the angle, with its sign, from the epipolar plane of the left ray to the right one.
double OffLine(const StereoRays& rays, const SE3& T_C1C0) {
  const Vector3d normal = T_C1C0.p.cross(T_C1C0.q * rays.left);
  return normal.dot(rays.right) / std::max(normal.norm(), 1e-12);
}

double MedianOffLine(const StereoRig& rig, std::span<const StereoRays> matches) {
  if (matches.empty()) return 0;
  std::vector<double> distances;
  for (const StereoRays& rays : matches)
    distances.push_back(std::abs(OffLine(rays, rig.T_C1C0())));
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle * rig.cameras[1].mean_focal_px();
}

}  // namespace

bool StereoTurn::IsClear() const {
  return num_matches >= kMinMatches && before_px > kLeastBefore_px &&
         after_px < std::min(kLargestShareAfter * before_px, kLargestAfter_px);
}

StereoRig TurnedRig(const StereoRig& rig, const Vector3d& omega) {
  StereoRig turned = rig;
  turned.T_BC[1].q = (rig.T_BC[1].q * ExpSO3(omega)).normalized();
  return turned;
}

StereoTurn EstimateStereoTurn(const StereoRig& rig, std::span<const StereoRays> matches) {
  StereoTurn turn;
  turn.num_matches = static_cast<int>(matches.size());
  turn.before_px = MedianOffLine(rig, matches);
  const double sigma = kSigma_px / rig.cameras[1].mean_focal_px();
  constexpr double kStep = 1e-6;
  for (const double width : kLossWidths) {
    for (int step = 0; step < kNumSteps; ++step) {
      const SE3 T_C1C0 = TurnedRig(rig, turn.omega).T_C1C0();
      std::array<SE3, 3> moved;
      for (int k = 0; k < 3; ++k)
        moved[static_cast<std::size_t>(k)] =
            TurnedRig(rig, turn.omega + kStep * Vector3d::Unit(k)).T_C1C0();
      const Vector3d weights = kPriorSigma.cwiseAbs2().cwiseInverse();
      Matrix3d H = weights.asDiagonal();
      Vector3d b = -weights.cwiseProduct(turn.omega);
      for (const StereoRays& rays : matches) {
        const double e = OffLine(rays, T_C1C0);
        Vector3d J;
        for (int k = 0; k < 3; ++k)
          J[k] = (OffLine(rays, moved[static_cast<std::size_t>(k)]) - e) / kStep;
        const double squared = e * e / (sigma * sigma);
        const double weight = 1 / (sigma * sigma * (1 + squared / (width * width)));
        H += weight * J * J.transpose();
        b -= weight * e * J;
      }
      turn.omega += H.ldlt().solve(b);
    }
  }
  turn.after_px = MedianOffLine(TurnedRig(rig, turn.omega), matches);
  return turn;
}

std::string InWords(const StereoTurn& turn) {
  const Vector3d degrees = turn.omega / kDegree;
  char text[200];
  if (turn.along_px != 0) {
    std::snprintf(text,
                  sizeof(text),
                  "turned by %.2f, %.2f, %.2f deg about its x, y, z axes against before: for a "
                  "second disparities were %.1f px off for landmarks with "
                  "known depths (median of %d); the correction",
                  degrees.x(),
                  degrees.y(),
                  degrees.z(),
                  turn.along_px,
                  turn.num_matches);
    return text;
  }
  std::snprintf(text,
                sizeof(text),
                "turned by %.2f, %.2f, %.2f deg about its x, y, z axes against its calibration: "
                "matches were %.1f px beside their epipolar lines (median of %d) and are %.1f px "
                "with this correction",
                degrees.x(),
                degrees.y(),
                degrees.z(),
                turn.before_px,
                turn.num_matches,
                turn.after_px);
  return text;
}

}  // namespace facet
