// SPDX-License-Identifier: BSD-2-Clause
#include <numbers>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/se3.h"
#include "facet/geometry/so3.h"
#include "facet/testing/numeric_jacobian.h"

namespace facet {
namespace {

TEST(So3Test, ExpAndLogAreInverse) {
  Rng rng(1);
  for (double angle : {0.0, 1e-9, 1e-5, 9.9e-5, 1.01e-4, 0.3, 2.0, 3.1, 3.14159}) {
    for (int i = 0; i < 20; ++i) {
      const Vector3d theta = angle * rng.UnitVector();
      EXPECT_LT((LogSO3(ExpSO3(theta)) - theta).norm(), 1e-10) << angle;
    }
  }
}

TEST(So3Test, ExpAgreesWithEigenAngleAxis) {
  Rng rng(2);
  for (int i = 0; i < 50; ++i) {
    const Vector3d axis = rng.UnitVector();
    const double angle = rng.Uniform(0, std::numbers::pi);
    const Matrix3d expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((ExpSO3(angle * axis).toRotationMatrix() - expected).norm(), 1e-12);
  }
}

TEST(So3Test, RightJacobianMatchesNumericDerivative) {
  Rng rng(3);
  for (double angle : {1e-6, 9e-5, 2e-4, 0.1, 1.0, 2.5}) {
    const Vector3d theta = angle * rng.UnitVector();
    const auto f = [&](const Vector3d& d) {
      return Vector3d(LogSO3(ExpSO3(theta).conjugate() * ExpSO3(theta + d)));
    };
    testing::ExpectJacobian<3, 3>(RightJacobianSO3(theta), f, 1e-7);
    EXPECT_LT(
        (RightJacobianSO3(theta) * RightJacobianInverseSO3(theta) - Matrix3d::Identity()).norm(),
        1e-9);
  }
}

TEST(So3Test, RotationBetweenIsSmallest) {
  Rng rng(4);
  for (int i = 0; i < 20; ++i) {
    const Vector3d a = rng.UnitVector(), b = rng.UnitVector();
    const Quaterniond q = RotationBetween(3.0 * a, 0.5 * b);
    EXPECT_LT((q * a - b).norm(), 1e-12);
    EXPECT_NEAR(LogSO3(q).norm(), std::acos(a.dot(b)), 1e-7);
  }
}

TEST(So3Test, RotationBetweenOppositeDirectionsIsHalfATurn) {
  Rng rng(4);
  for (const double off : {0.0, 1e-9, 1e-5}) {
    const Vector3d a = rng.UnitVector(), b = (off * rng.UnitVector() - a).normalized();
    const Quaterniond q = RotationBetween(a, b);
    EXPECT_LT((q * a - b).norm(), 1e-8);
    EXPECT_NEAR(q.norm(), 1, 1e-12);
  }
}

TEST(So3Test, TangentBasisIsOrthonormal) {
  Rng rng(5);
  for (int i = 0; i < 20; ++i) {
    const Vector3d n = rng.UnitVector();
    Matrix3d m;
    m << TangentBasis(n), n;
    EXPECT_LT((m.transpose() * m - Matrix3d::Identity()).norm(), 1e-12);
  }
}

TEST(Se3Test, ComposesLikeMatrices) {
  Rng rng(6);
  const SE3 T_AB(ExpSO3(rng.Normal3()), rng.Normal3());
  const SE3 T_BC(ExpSO3(rng.Normal3()), rng.Normal3());
  const Vector3d p_C = rng.Normal3();
  EXPECT_LT(((T_AB * T_BC) * p_C - T_AB * (T_BC * p_C)).norm(), 1e-12);
  EXPECT_LT((T_AB.Inverse() * (T_AB * p_C) - p_C).norm(), 1e-12);
}

}  // namespace
}  // namespace facet
