// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/stereo_turn.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/frontend/feature_detector.h"
#include "facet/frontend/frontend_options.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/stereo_matcher.h"
#include "facet/frontend/temporal_tracker.h"
#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kPriorSigma = 0.5 * kDegree;
// Of a distance from the epipolar line.
constexpr double kSigma_px = 0.3;
// In units of sigma: wide at first, so that all good matches take part, then narrow.
constexpr double kLossWidths[] = {15, 5, 3};
constexpr int kNumSteps = 5;
// Careful calibrations drawn at random leave up to 0.5 px, usually 0.2 px.
constexpr double kLeastBefore_px = 0.55, kLargestShareAfter = 0.5;
constexpr int kMinMatches = 60;
// Cameras are swapped: so many matches of all pairs the other way round, and so much more often.
constexpr std::size_t kManySwapped = 80, kTimesMore = 5;

// Signed distance of the right ray from the epipolar line of the left one, on the plane z = 1.
double OffLine(const StereoRays& rays, const SE3& T_C1C0) {
  const Vector3d line = T_C1C0.p.cross(T_C1C0.q * Vector3d(rays.left.x(), rays.left.y(), 1));
  const double norm = std::max(std::hypot(line.x(), line.y()), 1e-12);
  return line.dot(Vector3d(rays.right.x(), rays.right.y(), 1)) / norm;
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
         after_px < kLargestShareAfter * before_px;
}

bool AreSwapped(std::size_t num_matches, std::size_t num_exchanged) {
  return num_exchanged >= std::max(kManySwapped, kTimesMore * num_matches);
}

std::vector<StereoRays> MatchWidely(const StereoRig& rig,
                                    const cv::Mat& left,
                                    const cv::Mat& right,
                                    double gate_px) {
  FrontendOptions options;
  options.stereo.max_epipolar_px = gate_px;
  ImagePyramid left_pyramid, right_pyramid;
  left_pyramid.Build(left, options.klt.num_levels);
  right_pyramid.Build(right, options.klt.num_levels);
  const TemporalTracker tracker(rig.cameras[0], options);
  StereoMatcher matcher(rig, options);
  FeatureDetector detector(options.detector, options.klt);
  std::vector<StereoRays> matches;
  for (const Vector2d& px :
       detector.Detect(left, left_pyramid.level(0), {}, options.max_features)) {
    Track track;
    if (!tracker.Begin(left_pyramid, px, track)) continue;
    const auto match = matcher.Match(track, left_pyramid, right_pyramid);
    if (!match) continue;
    const auto ray = rig.cameras[1].Undistort(match->px);
    if (ray) matches.push_back({track.ray.xy, ray->xy});
  }
  return matches;
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
      Matrix3d H = Matrix3d::Identity() / (kPriorSigma * kPriorSigma);
      Vector3d b = -turn.omega / (kPriorSigma * kPriorSigma);
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

}  // namespace facet
