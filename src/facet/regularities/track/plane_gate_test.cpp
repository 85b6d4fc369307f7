// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/plane_gate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

SE3 RandomPose(Rng& rng) {
  SE3 T_WB;
  T_WB.q = ExpSO3(Vector3d(rng.Normal3()));
  T_WB.p = 2 * rng.Normal3();
  return T_WB;
}

SE3 Moved(const SE3& T_WB, const Vector<10>& x) {
  SE3 out = T_WB;
  out.q = T_WB.q * ExpSO3(Vector3d(x.head<3>()));
  out.p = T_WB.p + x.segment<3>(3);
  return out;
}

// The estimator's covariance is over "how the normal moves": n + dn, offset about the anchor.
PlaneEstimate Moved(const PlaneEstimate& plane, const Vector<10>& x) {
  PlaneEstimate out = plane;
  const double offset = plane.plane_W.SignedDistance(plane.anchor_W) * -1 + x(9);
  out.plane_W.n = (plane.plane_W.n + x.segment<3>(6)).normalized();
  out.plane_W.d = out.plane_W.n.dot(plane.anchor_W) + offset;
  return out;
}

// A joint covariance of rank 9: the normal has two degrees of freedom.
PlaneEstimate RandomPlane(const SE3& T_WB, double scale, Rng& rng) {
  PlaneEstimate plane;
  plane.plane_W = {rng.UnitVector(), 0};
  plane.anchor_W = T_WB.p + 2 * rng.Normal3();
  plane.plane_W.d = plane.plane_W.n.dot(plane.anchor_W) + 0.1 * rng.Normal();
  Matrix<9, 9> A;
  for (int i = 0; i < 81; ++i)
    A(i) = rng.Normal();
  Matrix<10, 9> expand = Matrix<10, 9>::Zero();
  expand.topLeftCorner<6, 6>().setIdentity();
  expand.block<3, 2>(6, 6) = TangentBasis(plane.plane_W.n);
  expand(9, 8) = 1;
  plane.covariance = scale * scale * expand * (A * A.transpose()) * expand.transpose();
  return plane;
}

// A draw of the error of pose and plane.
Vector<10> Draw(const Matrix<10, 10>& covariance, Rng& rng) {
  const Eigen::LDLT<Matrix<10, 10>> factor(covariance);
  Vector<10> x;
  for (int i = 0; i < 10; ++i)
    x(i) = rng.Normal() * std::sqrt(std::max(factor.vectorD()(i), 0.0));
  const Vector<10> y = factor.matrixL() * x;
  return factor.transpositionsP().transpose() * y;
}

// At the gate a point of the plane is as likely as something else, however well it is known.
TEST(PlaneGateTest, AtTheGatePlaneAndSomethingElseAreAsLikely) {
  const auto density_at_gate = [](double sigma_m) {
    const double on_plane_m = std::hypot(sigma_m, kRelief_m);
    const double gate2 = SquaredGate(sigma_m * sigma_m, 0.05, 1);
    return std::exp(-0.5 * gate2 / (on_plane_m * on_plane_m)) / on_plane_m;
  };
  for (const double sigma_m : {0.001, 0.01, 0.03, 0.06, 0.08})
    EXPECT_NEAR(density_at_gate(sigma_m) / density_at_gate(0), 1, 1e-9) << sigma_m;
}

TEST(PlaneGateTest, GateIsNoWiderThanItMayBe) {
  double widest2 = 0;
  for (double sigma_m = 0; sigma_m < 0.2; sigma_m += 1e-3)
    widest2 = std::max(widest2, SquaredGate(sigma_m * sigma_m, 0.05, 1));
  EXPECT_LE(widest2, 0.05 * 0.05 * (1 + 1e-9));
  EXPECT_GT(widest2, 0.049 * 0.049);
  EXPECT_NEAR(std::sqrt(SquaredGate(0, 0.05, 1)), 0.02, 0.001);  // what stands out of walls
}

TEST(PlaneGateTest, VerticesThatAreHardlyKnownAreOnNoPlane) {
  EXPECT_GT(SquaredGate(0.08 * 0.08, 0.05, 1), 0);
  EXPECT_EQ(SquaredGate(0.083 * 0.083, 0.05, 1), 0);
  EXPECT_EQ(SquaredGate(std::numeric_limits<double>::infinity(), 0.05, 1), 0);
}

TEST(PlaneGateTest, GatesFarAwayAreThoseOfALargerWorld) {
  const double near2 = SquaredGate(0.02 * 0.02, 0.05, 1);
  EXPECT_NEAR(SquaredGate(0.1 * 0.1, 0.05, 5) / (25 * near2), 1, 1e-12);
}

TEST(PlaneGateTest, DistanceVarianceEqualsNumericDerivative) {
  Rng rng(1);
  for (int run = 0; run < 20; ++run) {
    const SE3 T_WB = RandomPose(rng);
    const PlaneEstimate plane = RandomPlane(T_WB, 1e-3, rng);
    const Vector3d p_W = T_WB.p + 3 * rng.Normal3();
    const Vector3d p_B = T_WB.q.conjugate() * (p_W - T_WB.p);
    const auto distance = [&](const Vector<10>& x) -> Vector<1> {
      const PlaneEstimate moved = Moved(plane, x);
      return Vector<1>(moved.plane_W.SignedDistance(Moved(T_WB, x) * p_B));
    };
    // Only directions along the sphere count: the normal's own direction has no variance.
    const Matrix<1, 10> J = testing::NumericJacobian<1, 10>(distance);
    const double expected = (J * plane.covariance * J.transpose())(0);
    EXPECT_NEAR(DistanceVariance(plane, T_WB, p_W) / expected, 1, 1e-5);
    EXPECT_NEAR(DistanceUncertainty(plane, T_WB).VarianceAt(p_W) / expected, 1, 1e-5);
  }
}

TEST(PlaneGateTest, DistanceVarianceAgreesWithMonteCarlo) {
  Rng rng(2);
  const SE3 T_WB = RandomPose(rng);
  const PlaneEstimate plane = RandomPlane(T_WB, 1e-3, rng);
  const Vector3d p_W = T_WB.p + 3 * rng.Normal3();
  const Vector3d p_B = T_WB.q.conjugate() * (p_W - T_WB.p);
  const double at_mean = plane.plane_W.SignedDistance(p_W);
  double square = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const Vector<10> x = Draw(plane.covariance, rng);
    const double d = Moved(plane, x).plane_W.SignedDistance(Moved(T_WB, x) * p_B) - at_mean;
    square += d * d / kDraws;
  }
  EXPECT_NEAR(square / DistanceVariance(plane, T_WB, p_W), 1, 0.05);
}

// A measurement of the true plane from the true pose, expressed through the estimated pose.
PlaneCandidate Measure(const PlaneEstimate& truth, const SE3& T_true, const SE3& T_WB, Rng& rng) {
  const double sigma_normal = 0.004, sigma_offset_m = 0.003;
  const Vector3d n = truth.plane_W.n;
  const Matrix<3, 2> B = TangentBasis(n);
  const Vector3d along = B * Vector2d(rng.Normal(), rng.Normal());
  Vector3d centroid = truth.anchor_W + along;
  centroid -= truth.plane_W.SignedDistance(centroid) * n;
  centroid += sigma_offset_m * rng.Normal() * n;
  const Vector3d seen =
      (n + sigma_normal * (B * Vector2d(rng.Normal(), rng.Normal()))).normalized();
  const SE3 T_estimate_true = T_WB * T_true.Inverse();
  PlaneCandidate candidate;
  candidate.plane_W.n = T_estimate_true.q * seen;
  candidate.centroid_W = T_estimate_true * centroid;
  candidate.plane_W.d = candidate.plane_W.n.dot(candidate.centroid_W);
  const Matrix<3, 2> seen_B = TangentBasis(candidate.plane_W.n);
  candidate.normal_covariance = sigma_normal * sigma_normal * seen_B * seen_B.transpose();
  candidate.offset_variance_m2 = sigma_offset_m * sigma_offset_m;
  return candidate;
}

TEST(PlaneGateTest, ChiSquareHasThreeDegreesOfFreedom) {
  Rng rng(3);
  double sum = 0;
  int beyond_95 = 0;
  constexpr int kRuns = 4000;
  for (int run = 0; run < kRuns; ++run) {
    const SE3 T_WB = RandomPose(rng);
    const PlaneEstimate plane = RandomPlane(T_WB, 2e-3, rng);
    const Vector<10> error = Draw(plane.covariance, rng);
    const PlaneCandidate candidate = Measure(Moved(plane, error), Moved(T_WB, error), T_WB, rng);
    const double chi_square = ChiSquare(candidate, plane, T_WB);
    sum += chi_square / kRuns;
    beyond_95 += chi_square > 7.815 ? 1 : 0;
  }
  EXPECT_NEAR(sum, 3, 0.15);
  EXPECT_NEAR(beyond_95 / static_cast<double>(kRuns), 0.05, 0.012);
}

TEST(PlaneGateTest, ChiSquareSeesWhatIsFarOff) {
  Rng rng(4);
  const SE3 T_WB = RandomPose(rng);
  const PlaneEstimate plane = RandomPlane(T_WB, 1e-3, rng);
  PlaneCandidate candidate = Measure(plane, T_WB, T_WB, rng);
  EXPECT_LT(ChiSquare(candidate, plane, T_WB), 16.3);  // 99.9 %
  const double sigma =
      std::sqrt(DistanceVariance(plane, T_WB, candidate.centroid_W) + candidate.offset_variance_m2);
  candidate.centroid_W += 10 * sigma * plane.plane_W.n;
  EXPECT_GT(ChiSquare(candidate, plane, T_WB), 36);
}

TEST(PlaneGateTest, TwoPlanesThatDifferAsMuchAsTheyMayHaveThreeDegreesOfFreedom) {
  Rng rng(6);
  double sum = 0;
  constexpr int kRuns = 4000;
  for (int run = 0; run < kRuns; ++run) {
    const SE3 T_WB = RandomPose(rng);
    PlaneEstimate a = RandomPlane(T_WB, 1e-3, rng);
    PlaneEstimate b = RandomPlane(T_WB, 1e-3, rng);
    // The same plane from another anchor, and a pose that is known: the planes' errors alone.
    b.plane_W = a.plane_W;
    const Matrix<3, 2> B = TangentBasis(a.plane_W.n);
    for (PlaneEstimate* plane : {&a, &b}) {
      plane->covariance.setZero();
      plane->covariance.block<3, 3>(6, 6) = 1e-5 * B * B.transpose();
      plane->covariance(9, 9) = 1e-5;
    }
    const PlaneEstimate seen_b = Moved(b, Draw(b.covariance, rng));
    const PlaneEstimate seen_a = Moved(a, Draw(a.covariance, rng));
    sum += ChiSquare(seen_a, seen_b, T_WB.p + 2 * rng.Normal3(), T_WB) / kRuns;
  }
  EXPECT_NEAR(sum, 3, 0.15);
}

TEST(PlaneGateTest, TheOtherSideIsAnotherSurface) {
  Rng rng(7);
  const SE3 T_WB = RandomPose(rng);
  const PlaneEstimate plane = RandomPlane(T_WB, 1e-3, rng);
  PlaneCandidate candidate = Measure(plane, T_WB, T_WB, rng);
  ASSERT_TRUE(std::isfinite(ChiSquare(candidate, plane, T_WB)));
  ASSERT_TRUE(std::isfinite(ChiSquare(plane, plane, plane.anchor_W, T_WB)));
  candidate.plane_W = {-candidate.plane_W.n, -candidate.plane_W.d};
  PlaneEstimate behind = plane;
  behind.plane_W = {-plane.plane_W.n, -plane.plane_W.d};
  EXPECT_EQ(ChiSquare(candidate, plane, T_WB), std::numeric_limits<double>::infinity());
  EXPECT_EQ(ChiSquare(plane, behind, plane.anchor_W, T_WB),
            std::numeric_limits<double>::infinity());
}

TEST(PlaneGateTest, AUselessCovarianceRecognisesNothing) {
  Rng rng(5);
  const SE3 T_WB = RandomPose(rng);
  PlaneEstimate plane = RandomPlane(T_WB, 1e-3, rng);
  const PlaneCandidate candidate = Measure(plane, T_WB, T_WB, rng);
  plane.covariance.setConstant(std::nan(""));
  EXPECT_EQ(ChiSquare(candidate, plane, T_WB), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace facet
