// SPDX-License-Identifier: BSD-2-Clause
// Reprojection of one landmark into several frames, written independently of reprojection_factor,
// for its tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "facet/estimator/factors/landmark_factors.h"
#include "facet/geometry/so3.h"
#include "facet/testing/estimator/test_window.h"

namespace facet::testing {

inline constexpr double kWidth = 2.0;

// A point of the world in homogeneous coordinates: X = y / rho.
struct WorldPoint {
  Vector3d y;
  double rho;
};

// One camera of one observation.
struct Measurement {
  int frame, camera;
  MeasuredRay ray;
};

// Residuals of one landmark, written independently of the code under test.
struct Problem {
  StereoRig rig;
  std::vector<SE3> poses;
  WindowLandmark landmark;
  std::vector<Measurement> measurements;

  SE3 Camera(const SE3& T_WB, int camera) const { return T_WB * rig.T_BC[camera]; }

  Vector2d Residual(const Measurement& m, const SE3& T_WB, const WorldPoint& point) const {
    const SE3 T_WC = Camera(T_WB, m.camera);
    // In a frame whose z axis is the bearing the plane that touches the sphere is z = 1.
    const Matrix3d R = Quaterniond::FromTwoVectors(m.ray.bearing, Vector3d::UnitZ()).matrix();
    const Vector3d h = R * (T_WC.q.conjugate() * (point.y - point.rho * T_WC.p));
    return (m.ray.whitening * R.transpose()).leftCols<2>() * (h.head<2>() / h.z());
  }

  /// The point of bearing + tangent step and inverse distance + step in a host at T_WB.
  WorldPoint FromHost(const SE3& T_WB, const Vector3d& step) const {
    const SE3 T_WH = Camera(T_WB, 0);
    const Vector3d f = landmark.bearing_H + TangentBasis(landmark.bearing_H) * step.head<2>();
    const double rho = landmark.inverse_distance + step.z();
    return {T_WH.q * f + rho * T_WH.p, rho};
  }
  const SE3& host() const { return poses[landmark.host]; }

  double Cost(const std::vector<SE3>& moved, const WorldPoint& point) const {
    double cost = 0;
    for (const Measurement& m : measurements) {
      const double s2 = Residual(m, moved[m.frame], point).squaredNorm();
      cost += 0.5 * s2 * kWidth * kWidth / (kWidth * kWidth + s2);
    }
    return cost;
  }
  double RootWeight(const Measurement& m) const {
    const double s2 = Residual(m, poses[m.frame], FromHost(host(), Vector3d::Zero())).squaredNorm();
    return kWidth * kWidth / (kWidth * kWidth + s2);
  }
};

struct ProblemOptions {
  bool at_infinity = false;
  bool stereo = true;
  double noise = 1.0;  ///< of measurements, in sigmas
};

inline Problem MakeProblem(const ProblemOptions& options, Rng& rng) {
  TestWindowOptions window_options;
  window_options.num_landmarks = 1;
  window_options.miss_share = 0;
  window_options.right_share = options.stereo ? 0.7 : 0;
  Problem problem;
  TestWindow test;
  do {
    test = MakeTestWindow(window_options, rng);
  } while (test.points.empty() || test.window.landmarks()[0].observations.size() < 4);
  problem.rig = test.rig;
  for (const NavState& x : test.truth)
    problem.poses.push_back(x.T_WB);
  problem.landmark = test.window.landmarks()[0];
  WindowLandmark& landmark = problem.landmark;
  // Any frame may be the host, also one in the middle.
  landmark.host =
      landmark.observations[rng.Index(static_cast<int>(landmark.observations.size()))].frame;
  const Vector3d p_H = problem.Camera(problem.host(), 0).Inverse() * test.points[0];
  landmark.bearing_H = p_H.normalized();
  landmark.inverse_distance = options.at_infinity ? 0 : 1 / p_H.norm();
  const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
  for (WindowObservation& o : landmark.observations) {
    for (int c = 0; c < (o.has_right ? 2 : 1); ++c) {
      const SE3 T_WC = problem.Camera(problem.poses[o.frame], c);
      SetMeasurement(T_WC.q.conjugate() * (point.y - point.rho * T_WC.p), c, 0.5, o);
      const double x = rng.Normal(), y = rng.Normal();
      ShiftMeasurement(options.noise * OneSigmaOnPlane(o.rays[c]) * Vector2d(x, y), c, o);
      problem.measurements.push_back({o.frame, c, o.rays[c]});
    }
  }
  return problem;
}

inline FrameGeometry GeometryOf(const Problem& problem) {
  std::vector<WindowFrame> frames(problem.poses.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].x.T_WB = problem.poses[i];
  FrameGeometry geometry(problem.rig);
  geometry.Update(frames);
  return geometry;
}

inline LandmarkBlock Linearized(const Problem& problem) {
  LandmarkBlock block;
  LinearizeLandmark(GeometryOf(problem), {}, problem.landmark, NoiseOfWidth(kWidth), block);
  return block;
}

inline SE3 Moved(const SE3& T_WB, const Vector<6>& d) {
  return T_WB.Retract(d.head<3>(), d.tail<3>());
}

// Derivative with a five-point stencil, good to about 1e-11 of the value.
template <class F>
MatrixXd Derivative(const F& f, int dim) {
  constexpr double kStep = 1e-3;
  MatrixXd J;
  for (int k = 0; k < dim; ++k) {
    const VectorXd e = kStep * VectorXd::Unit(dim, k);
    const VectorXd column = (8 * (f(e) - f(-e)) - (f(2 * e) - f(-2 * e))) / (12 * kStep);
    if (k == 0) J.resize(column.size(), dim);
    J.col(k) = column;
  }
  return J;
}

// The same for a scalar.
template <class F>
VectorXd Gradient(const F& f, int dim) {
  constexpr double kStep = 1e-3;
  VectorXd gradient(dim);
  for (int k = 0; k < dim; ++k) {
    const VectorXd e = kStep * VectorXd::Unit(dim, k);
    gradient(k) = (8 * (f(e) - f(-e)) - (f(2 * e) - f(-2 * e))) / (12 * kStep);
  }
  return gradient;
}

inline double RelativeError(const MatrixXd& a, const MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / (1e-3 + b.cwiseAbs().maxCoeff());
}

inline std::vector<Problem> Problems(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Problem> problems;
  for (int run = 0; run < 5; ++run) {
    for (const bool at_infinity : {false, true}) {
      for (const bool stereo : {false, true}) {
        // Most rows beyond the width of the loss, or within.
        for (const double noise : {0.5, 2.5})
          problems.push_back(MakeProblem({at_infinity, stereo, noise}, rng));
      }
    }
  }
  return problems;
}

}  // namespace facet::testing
