// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/surface_registration.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr int kMaxIterations = 40;
constexpr int kGateIterations = 20;                  // until the gate has closed
constexpr double kFirstGate = 0.3, kLastGate = 0.1;  // [m]
constexpr double kSmallestEigenvalue = 1e-4;         // of the largest: below, a direction is open
constexpr double kConverged = 1e-7;                  // [m], and rad times the extent
constexpr std::size_t kMinPairs = 10;

struct NormalEquations {
  Matrix<6, 6> H = Matrix<6, 6>::Zero();  // order theta, p; about the centre of the points
  Vector<6> b = Vector<6>::Zero();
  std::size_t num_pairs = 0;
};

struct Shape {
  Vector3d centre = Vector3d::Zero();
  double extent = 1;  // rms distance from the centre: the unit in which turns are compared [m]
};

Shape ShapeOf(std::span<const Vector3d> points) {
  Shape shape;
  for (const Vector3d& p : points)
    shape.centre += p / static_cast<double>(points.size());
  double sum = 0;
  for (const Vector3d& p : points)
    sum += (p - shape.centre).squaredNorm();
  shape.extent = std::max(1e-3, std::sqrt(sum / static_cast<double>(points.size())));
  return shape;
}

NormalEquations Linearize(std::span<const Vector3d> points_M,
                          const TruthSurface& surface,
                          const SE3& T_GM,
                          const Shape& shape,
                          double gate) {
  NormalEquations equations;
  const Vector3d centre_G = T_GM * shape.centre;
  for (const Vector3d& p_M : points_M) {
    const Vector3d p_G = T_GM * p_M;
    const SurfacePoint nearest = surface.Closest(p_G);
    if (nearest.distance > gate || nearest.n.isZero()) continue;
    Vector<6> J;
    J << (p_G - centre_G).cross(nearest.n) / shape.extent, nearest.n;
    const double residual = nearest.n.dot(p_G - nearest.p);
    equations.H += J * J.transpose();
    equations.b += J * residual;
    ++equations.num_pairs;
  }
  return equations;
}

// Least squares in the directions that the data determine, zero in the others.
Vector<6> SolveDetermined(const NormalEquations& equations) {
  const Eigen::SelfAdjointEigenSolver<Matrix<6, 6>> eigen(equations.H);
  Vector<6> step = Vector<6>::Zero();
  for (int i = 0; i < 6; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value < kSmallestEigenvalue * eigen.eigenvalues()[5]) continue;
    step -= eigen.eigenvectors().col(i) * (eigen.eigenvectors().col(i).dot(equations.b) / value);
  }
  return step;
}

}  // namespace

SE3 RegisterToSurface(std::span<const Vector3d> points_M, const TruthSurface& surface) {
  SE3 T_GM;
  const Shape shape = ShapeOf(points_M);
  for (int i = 0; i < kMaxIterations; ++i) {
    const double closed = std::min(1.0, static_cast<double>(i) / kGateIterations);
    const double gate = kFirstGate * std::pow(kLastGate / kFirstGate, closed);
    const NormalEquations equations = Linearize(points_M, surface, T_GM, shape, gate);
    if (equations.num_pairs < kMinPairs) break;
    const Vector<6> step = SolveDetermined(equations);
    const Quaterniond turn = ExpSO3(step.head<3>() / shape.extent);
    const Vector3d centre_G = T_GM * shape.centre;
    T_GM = SE3(turn, centre_G - turn * centre_G + step.tail<3>()) * T_GM;
    T_GM.q.normalize();
    if (i >= kGateIterations && step.norm() < kConverged) break;
  }
  return T_GM;
}

}  // namespace facet
