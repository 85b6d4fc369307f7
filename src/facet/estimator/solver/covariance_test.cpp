// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/covariance.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::TestWindow;

// Two planes: every landmark lies on one of them, the second frame has measured the first one.
TestWindow MakeWindow(Rng& rng) {
  TestWindow test = testing::MakeTestWindow({}, rng);
  SlidingWindow& window = test.window;
  window.start_prior.emplace(FrameId{0}, test.truth[0].T_WB, StartOptions{});
  const Vector3d centre_W = test.points[0];
  for (int k = 0; k < 2; ++k) {
    const Vector3d n = rng.UnitVector();
    window.planes.emplace_back(PlaneId{k}, Plane{n, n.dot(centre_W)}, centre_W, 1.0);
  }
  for (std::size_t l = 0; l < window.landmarks().size(); ++l)
    window.landmarks()[l].planes.Add(static_cast<int>(l % 2));
  window.measurements.push_back(
      testing::MakeMeasurement(window.frames[1], window.planes[0], centre_W, 0, rng));
  return test;
}

// Columns of these variables.
std::vector<int> ColumnsOf(const StateLayout& layout, std::initializer_list<Variable> variables) {
  std::vector<int> columns;
  for (const Variable& variable : variables) {
    for (int k = 0; k < SizeOf(variable.kind); ++k)
      columns.push_back(layout.ColumnOf(variable) + k);
  }
  return columns;
}

double ScaledError(const MatrixXd& a, const MatrixXd& b) {
  const VectorXd s = b.diagonal().cwiseSqrt().cwiseInverse();
  return (s.asDiagonal() * (a - b) * s.asDiagonal()).cwiseAbs().maxCoeff();
}

TEST(CovarianceTest, BlocksAreThoseOfTheInverse) {
  Rng rng(3);
  const TestWindow test = MakeWindow(rng);
  LinearizedWindow linear;
  testing::Linearize(test, testing::NoiseOfWidth(10.0), linear);
  ReducedSystem reduced;
  ASSERT_TRUE(reduced.Solve(0.0, linear));
  const NormalEquations dense = testing::Assemble(test.window, test.rig, 10.0);
  const VectorXd s = dense.H.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = s.asDiagonal() * dense.H * s.asDiagonal();
  const MatrixXd inverse = s.asDiagonal() * scaled.inverse() * s.asDiagonal();
  const int newest = test.window.newest_frame();
  const auto frame = ColumnsOf(dense.layout, {Variable::Pose(newest), Variable::Motion(newest)});
  EXPECT_LT(ScaledError(NewestFrameCovariance(reduced, linear.layout()), inverse(frame, frame)),
            1e-6);
  const auto planes = PlaneCovariances(reduced, linear.layout());
  ASSERT_EQ(planes.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    const auto both = ColumnsOf(dense.layout, {Variable::Pose(newest), Variable::Plane(k)});
    EXPECT_LT(ScaledError(planes[static_cast<std::size_t>(k)], inverse(both, both)), 1e-6);
  }
}

// Landmarks and measurements, but neither relations nor the prior.
TEST(CovarianceTest, PlaneInformationIsThatOfMeasurementsAlone) {
  Rng rng(4);
  TestWindow test = MakeWindow(rng);
  const auto information = [&] {
    LinearizedWindow linear;
    testing::Linearize(test, testing::NoiseOfWidth(10.0), linear);
    ReducedSystem reduced;
    EXPECT_TRUE(reduced.Solve(0.0, linear));
    return PlaneInformation(linear);
  };
  const std::vector<Matrix3d> before = information();
  test.window.AddRelation({PlaneRelationKind::kParallel, PlaneId{0}, PlaneId{1}});
  test.window.planes[0].Freeze();
  test.window.prior.blocks = {MarginalPrior::Block::OfPlane(PlaneId{0}, 0)};
  test.window.prior.H = 1e3 * Matrix3d::Identity();
  test.window.prior.b = Vector3d::Zero();
  const std::vector<Matrix3d> after = information();
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_LT((after[k] - before[k]).norm(), 1e-9 * before[k].norm());
  test.window.measurements.clear();
  EXPECT_GT((information()[0] - before[0]).norm(), 0.1 * before[0].norm());
}

// Poses given, the information on normal and offset is that of a measurement with these sigmas.
TEST(CovarianceTest, PlaneInformationOfAMeasurementIsThatOfItsSigmas) {
  Rng rng(5);
  TestWindow test = MakeWindow(rng);
  SlidingWindow& window = test.window;
  for (WindowLandmark& landmark : window.landmarks())
    landmark.planes = PlaneLinks();
  PlaneMeasurement& measurement = window.measurements[0];
  // About the centre normal and offset are independent.
  window.planes[0].anchor_W = window.frames[1].x.T_WB * measurement.centre_B;
  window.planes[0].offset = 0;
  measurement.sigma_rad = {0.02, 0.02};
  LinearizedWindow linear;
  testing::Linearize(test, FactorNoise(EstimatorOptions{}), linear);
  const Matrix3d expected =
      Vector3d(
          1 / (0.02 * 0.02), 1 / (0.02 * 0.02), 1 / (measurement.sigma_m * measurement.sigma_m))
          .asDiagonal();
  EXPECT_LT((PlaneInformation(linear)[0] - expected).norm(), 1e-6 * expected.norm());
}

}  // namespace
}  // namespace facet
