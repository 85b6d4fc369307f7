// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/landmark_depth.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

// Angular noise of one ray that the decision about parallax assumes [rad], about half a pixel.
constexpr double kRaySigma = 1e-3;
// Good enough for a start: depth known to a fifth, or far away for certain.
constexpr double kMinSnr = 5.0;
constexpr double kFarSigma = 0.005;  // 1/m
// Away from the axis a distance is known worse than the noise of its pixels says: planes that
// believe that noise there cost accuracy. It counts as if it were the same on the plane z = 1; but
// no smaller cosine of the angle from the axis than this.
constexpr double kLeastCosine = 0.1;

}  // namespace

bool InitializeDepth(const FrameGeometry& geometry, WindowLandmark& landmark) {
  // For every ray f_t: f_t x (R_tH f + rho t_tH) = 0, linear in rho.
  double cc = 0, ac = 0;
  bool stereo = false;
  for (const WindowObservation& obs : landmark.observations) {
    if (obs.frame == landmark.host) landmark.bearing_H = geometry.MeasuredBearing(obs, 0);
  }
  const FrameGeometry::Pose& host = geometry.current(landmark.host);
  const Vector3d d_W = host.R_WC0 * landmark.bearing_H;
  for (const WindowObservation& obs : landmark.observations) {
    const FrameGeometry::Pose& target = geometry.current(obs.frame);
    for (int c = 0; c < (obs.has_right ? 2 : 1); ++c) {
      if (obs.frame == landmark.host && c == 0) continue;
      const Vector3d ray = geometry.MeasuredBearing(obs, c);
      const Vector3d direction = geometry.R_CB[c] * (target.R_BW * d_W);
      const Vector3d baseline =
          geometry.R_CB[c] * (target.R_BW * (host.p_WC0 - target.p_WB) - geometry.p_BC[c]);
      const Vector3d a = ray.cross(direction);
      const Vector3d b = ray.cross(baseline);
      cc += b.squaredNorm();
      ac += a.dot(b);
    }
    stereo |= obs.has_right;
  }
  if (cc < 1e-8) return false;
  const double rho = std::max(-ac / cc, 0.0);
  const double sigma = kRaySigma / std::sqrt(cc);
  if (!stereo && rho < kMinSnr * sigma && sigma > kFarSigma) return false;
  landmark.inverse_distance = rho;
  landmark.has_depth = true;
  return true;
}

void InitializeDepths(const FrameGeometry& geometry, SlidingWindow& window) {
  for (WindowLandmark& landmark : window.landmarks()) {
    if (!landmark.has_depth) InitializeDepth(geometry, landmark);
  }
}

double InverseDistanceInformation(const WindowLandmark& landmark,
                                  const Vector3d& ray_W,
                                  const std::vector<CameraCentres>& centres) {
  const Vector3d& host_W = centres[landmark.host][0];
  double information = 0;
  for (const WindowObservation& observation : landmark.observations) {
    for (int camera = 0; camera < (observation.has_right ? 2 : 1); ++camera) {
      const Vector3d baseline_W = centres[observation.frame][camera] - host_W;
      const double across2 = baseline_W.squaredNorm() - std::pow(baseline_W.dot(ray_W), 2);
      const MeasuredRay& ray = observation.rays[camera];
      const double cosine = std::max(ray.bearing.z(), kLeastCosine);
      information += across2 * ray.AngleInformation() * cosine * cosine * cosine;
    }
  }
  return information;
}

}  // namespace facet
