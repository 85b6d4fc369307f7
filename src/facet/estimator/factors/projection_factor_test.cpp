// SPDX-License-Identifier: BSD-2-Clause
// Landmarks of pipeline SP: the paper's projection noise, in pixels, and Tukey's loss.
#include <gtest/gtest.h>

#include "facet/testing/estimator/test_landmark.h"

namespace facet {
namespace {

using testing::GeometryOf;
using testing::Gradient;
using testing::Measurement;
using testing::Problem;
using testing::WorldPoint;

constexpr double kPixelSigma = 0.5;  // of the measurements of MakeProblem
const FactorNoise kNoise = testing::NoiseOfWidth(testing::kWidth);

// The paper's cost of the landmark, written once more.
double Cost(const Problem& problem, const std::vector<SE3>& poses, const WorldPoint& point) {
  const double c = kNoise.projection.tukey_sigma;
  double cost = 0;
  for (const Measurement& m : problem.measurements) {
    const double s = problem.Residual(m, poses[m.frame], point).norm() * kPixelSigma /
                     kNoise.projection.sigma_px;
    const double inside = 1 - std::min(s / c, 1.0) * std::min(s / c, 1.0);
    cost += c * c / 6 * (1 - inside * inside * inside);
  }
  return cost;
}

// Reweighting keeps the gradient of the robust cost; mono and stereo rows, some beyond the limit.
TEST(ProjectionFactorTest, GradientIsThatOfThePapersCost) {
  Rng rng(1);
  int num_beyond = 0;
  for (const double noise : {1.0, 4.0, 12.0}) {
    for (int run = 0; run < 10; ++run) {
      Problem problem = testing::MakeProblem({false, run % 2 == 0, noise}, rng);
      problem.landmark.is_projection = true;
      LandmarkBlock block;
      LinearizeLandmark(GeometryOf(problem), {}, problem.landmark, kNoise, block);
      const WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
      EXPECT_NEAR(block.cost, Cost(problem, problem.poses, point), 1e-9 * (1 + block.cost));
      EXPECT_NEAR(LandmarkCost(GeometryOf(problem), {}, problem.landmark, kNoise),
                  block.cost,
                  1e-9 * (1 + block.cost));
      const VectorXd gradient = Gradient(
          [&](const VectorXd& d) {
            return Cost(problem, problem.poses, problem.FromHost(problem.host(), 0.1 * d));
          },
          3);
      EXPECT_LT((0.1 * block.b - gradient).norm(), 1e-5 * (1 + gradient.norm()));
      for (int v = 0; v < block.num_views; ++v) {
        const VectorXd pose_gradient = Gradient(
            [&](const VectorXd& d) {
              std::vector<SE3> moved = problem.poses;
              SE3& T_WB = moved[static_cast<std::size_t>(block.views[v].frame)];
              T_WB = testing::Moved(T_WB, 0.1 * d);
              return Cost(problem, moved, point);
            },
            6);
        EXPECT_LT((0.1 * block.pose_squares[v].b - pose_gradient).norm(),
                  1e-5 * (1 + pose_gradient.norm()));
      }
      for (const Measurement& m : problem.measurements) {
        num_beyond +=
            problem.Residual(m, problem.poses[m.frame], point).norm() * kPixelSigma > 1.8 * 4.685;
      }
    }
  }
  EXPECT_GT(num_beyond, 10);
}

TEST(ProjectionFactorTest, InformationIsThatOf1Point8Pixels) {
  Rng rng(2);
  Problem problem = testing::MakeProblem({false, true, 0.0}, rng);
  LandmarkBlock smart, projection;
  LinearizeLandmark(GeometryOf(problem), {}, problem.landmark, kNoise, smart);
  problem.landmark.is_projection = true;
  LinearizeLandmark(GeometryOf(problem), {}, problem.landmark, kNoise, projection);
  const double ratio = std::pow(kPixelSigma / 1.8, 2);
  EXPECT_LT((projection.V - ratio * smart.V).norm(), 1e-12 * smart.V.norm());
  EXPECT_LT((projection.pose_squares[0].H - ratio * smart.pose_squares[0].H).norm(),
            1e-12 * smart.pose_squares[0].H.norm());
  // A camera whose pixels are worse changes nothing: the paper's noise is one number.
  for (WindowObservation& o : problem.landmark.observations) {
    o.rays[1].whitening *= 0.25;
    o.sigma_px[1] *= 4;
  }
  LandmarkBlock worse;
  LinearizeLandmark(GeometryOf(problem), {}, problem.landmark, kNoise, worse);
  EXPECT_LT((projection.V - worse.V).norm(), 1e-12 * projection.V.norm());
}

}  // namespace
}  // namespace facet
