// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/two_view_rotation.h"

#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr std::size_t kMinPairs = 20;
constexpr int kNumSteps = 40;
// In units of sigma: the loss begins wide, so that the start need not be near.
constexpr std::array<double, 4> kLossWidths = {100, 30, 8, 3};
// Solutions whose cost is less than this many times the best one's are not told apart.
constexpr double kAmbiguousCost = 1.5;

struct Motion {
  Quaterniond R;  // first from second
  Vector3d t;     // unit vector, in the first frame
};

double Cauchy(double squared, double width) {
  return width * width * std::log1p(squared / (width * width));
}

double CauchyWeight(double squared, double width) {
  return 1 / (1 + squared / (width * width));
}

// Rotation without translation: where the search begins.
Quaterniond RotationAlone(std::span<const BearingPair> pairs, double sigma) {
  Quaterniond R = Quaterniond::Identity();
  for (int step = 0; step < kNumSteps; ++step) {
    Matrix3d H = 1e-9 * Matrix3d::Identity();
    Vector3d b = Vector3d::Zero();
    for (const BearingPair& pair : pairs) {
      const Vector3d e = pair.first - R * pair.second;
      const Matrix3d J = R.toRotationMatrix() * Hat(pair.second);  // d e / d delta
      const double w = CauchyWeight(e.squaredNorm() / (sigma * sigma), kLossWidths[0]);
      H += w * J.transpose() * J;
      b -= w * J.transpose() * e;
    }
    R = (R * ExpSO3(H.ldlt().solve(b))).normalized();
  }
  return R;
}

// Distance of a pair from its epipolar plane [sigma], with the derivative to first order by the
// rotation (on the right) and by t along `basis`.
double EpipolarError(const BearingPair& pair,
                     const Motion& motion,
                     double sigma,
                     const Matrix<3, 2>& basis,
                     Vector<5>* J) {
  const Vector3d second = motion.R * pair.second;
  const Vector3d normal = motion.t.cross(pair.first);
  const double scale =
      1 / (sigma * std::sqrt(normal.squaredNorm() + motion.t.cross(second).squaredNorm() + 1e-6));
  if (J != nullptr) {
    J->head<3>() = -scale * (Hat(pair.second).transpose() * (motion.R.conjugate() * normal));
    J->tail<2>() = scale * (basis.transpose() * pair.first.cross(second));
  }
  return scale * normal.dot(second);
}

struct Solution {
  Motion motion;
  double cost = 0;
  Matrix3d covariance;  // of the rotation
};

double Cost(std::span<const BearingPair> pairs, const Motion& motion, double sigma, double width) {
  double cost = 0;
  for (const BearingPair& pair : pairs) {
    const double e = EpipolarError(pair, motion, sigma, Matrix<3, 2>::Zero(), nullptr);
    cost += Cauchy(e * e, width);
  }
  return cost;
}

Solution Refine(std::span<const BearingPair> pairs, Motion motion, double sigma) {
  Solution solution;
  Matrix<5, 5> H;
  for (const double width : kLossWidths) {
    double lambda = 1e-3, cost = Cost(pairs, motion, sigma, width);
    for (int step = 0; step < kNumSteps; ++step) {
      const Matrix<3, 2> basis = TangentBasis(motion.t);
      H.setZero();
      Vector<5> b = Vector<5>::Zero();
      for (const BearingPair& pair : pairs) {
        Vector<5> J;
        const double e = EpipolarError(pair, motion, sigma, basis, &J);
        const double w = CauchyWeight(e * e, width);
        H += w * J * J.transpose();
        b -= w * e * J;
      }
      Matrix<5, 5> damped = H;
      damped.diagonal() *= 1 + lambda;
      damped.diagonal().array() += 1e-6;
      const Vector<5> delta = damped.ldlt().solve(b);
      const Motion next{(motion.R * ExpSO3(delta.head<3>())).normalized(),
                        (motion.t + basis * delta.tail<2>()).normalized()};
      const double next_cost = Cost(pairs, next, sigma, width);
      if (!(next_cost < cost)) {
        lambda *= 10;
        if (lambda > 1e4) break;
        continue;
      }
      const bool is_done = cost - next_cost < 1e-5 * cost;
      motion = next;
      cost = next_cost;
      lambda = std::max(lambda / 10, 1e-6);
      if (is_done) break;
    }
    solution.cost = cost;
  }
  solution.motion = motion;
  H.diagonal().array() += 1e-6;
  const Matrix<5, 5> covariance = H.ldlt().solve(Matrix<5, 5>::Identity());
  const double excess = solution.cost / static_cast<double>(pairs.size());
  solution.covariance = std::max(1.0, excess) * covariance.topLeftCorner<3, 3>();
  return solution;
}

}  // namespace

std::optional<TwoViewRotation> EstimateTwoViewRotation(std::span<const BearingPair> pairs,
                                                       double sigma) {
  if (pairs.size() < kMinPairs) return std::nullopt;
  const Quaterniond start = RotationAlone(pairs, sigma);
  std::vector<Solution> solutions;
  for (const Vector3d& t : {Vector3d(1, 0, 0),
                            Vector3d(0, 1, 0),
                            Vector3d(0, 0, 1),
                            Vector3d(1, 1, 0),
                            Vector3d(1, -1, 0)}) {
    solutions.push_back(Refine(pairs, {start, t.normalized()}, sigma));
  }
  const Solution* best = &solutions.front();
  for (const Solution& solution : solutions) {
    if (solution.cost < best->cost) best = &solution;
  }
  TwoViewRotation result{LogSO3(best->motion.R), best->covariance};
  for (const Solution& solution : solutions) {
    if (solution.cost > kAmbiguousCost * best->cost) continue;
    const Vector3d other = LogSO3(best->motion.R.conjugate() * solution.motion.R);
    result.covariance += other * other.transpose();
  }
  return result;
}

}  // namespace facet
