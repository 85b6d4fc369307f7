// SPDX-License-Identifier: BSD-2-Clause
// Against finite differences of what the covariances are of, written without the formulas.
#include "facet/robot/motion_covariance.h"

#include <functional>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace facet::robot {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Matrix15 = Eigen::Matrix<double, 15, 15, Eigen::RowMajor>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector15 = Eigen::Matrix<double, 15, 1>;

Matrix3d Exp(const Vector3d& v) {
  return v.norm() == 0 ? Matrix3d::Identity() : AngleAxisd(v.norm(), v.normalized()).matrix();
}

Vector3d Log(const Matrix3d& R) {
  const AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Quaterniond Quaternion(const api::Pose& T) {
  return {T.q[0], T.q[1], T.q[2], T.q[3]};
}

Vector3d ToEigen(const api::Vec3& v) {
  return {v[0], v[1], v[2]};
}

class MotionCovarianceTest : public ::testing::Test {
 protected:
  double Draw() { return std::normal_distribution<double>()(random_); }
  Vector3d DrawVector() { return {Draw(), Draw(), Draw()}; }

  api::Pose DrawPose() {
    const Vector3d p = DrawVector();
    const Quaterniond q(Exp(DrawVector()));
    return {{{p.x(), p.y(), p.z()}}, {{q.w(), q.x(), q.y(), q.z()}}};
  }

  StateCovariance DrawCovariance() {
    Matrix15 A;
    for (double& a : A.reshaped())
      a = Draw();
    StateCovariance rows;
    Eigen::Map<Matrix15>(rows.data()) = A * A.transpose();
    return rows;
  }

  /// J Sigma J^T with the derivatives of `f` at no error.
  static Matrix6 Numeric(const std::function<Vector6(const Vector15&)>& f,
                         const StateCovariance& covariance) {
    constexpr double kStep = 1e-5;
    Eigen::Matrix<double, 6, 15> J;
    for (int i = 0; i < 15; ++i)
      J.col(i) = (f(kStep * Vector15::Unit(i)) - f(-kStep * Vector15::Unit(i))) / (2 * kStep);
    return J * Eigen::Map<const Matrix15>(covariance.data()) * J.transpose();
  }

  static void ExpectNear(const Covariance6& actual, const Matrix6& expected) {
    const Matrix6 difference = Eigen::Map<const Matrix6>(actual.data()) - expected;
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-6 * expected.cwiseAbs().maxCoeff());
  }

  std::mt19937 random_{7};
};

TEST_F(MotionCovarianceTest, OfThePoseIsAboutTheFixedAxes) {
  for (int i = 0; i < 5; ++i) {
    const api::Pose T_WB = DrawPose(), T_BF = DrawPose();
    const StateCovariance covariance = DrawCovariance();
    const Matrix3d R_WB = Quaternion(T_WB).matrix(), R_BF = Quaternion(T_BF).matrix();
    const auto f = [&](const Vector15& error) {
      const Matrix3d R = R_WB * Exp(error.head<3>());
      Vector6 y;
      y.head<3>() = ToEigen(T_WB.p) + error.segment<3>(3) + R * ToEigen(T_BF.p);
      y.tail<3>() = Log(R * R_BF * (R_WB * R_BF).transpose());
      return y;
    };
    ExpectNear(PoseCovariance(T_WB, T_BF, covariance), Numeric(f, covariance));
  }
}

TEST_F(MotionCovarianceTest, OfTheTwistIsAlongTheMovingAxes) {
  for (int i = 0; i < 5; ++i) {
    api::Motion motion;
    motion.T_WF = DrawPose();
    const Vector3d v_W = DrawVector(), rate_B = DrawVector();
    motion.v_WF = {{v_W.x(), v_W.y(), v_W.z()}};
    motion.covariance = DrawCovariance();
    const api::Pose T_BF = DrawPose();
    const Matrix3d R_WF = Quaternion(motion.T_WF).matrix(), R_BF = Quaternion(T_BF).matrix();
    const auto f = [&](const Vector15& error) {
      const Matrix3d R = R_WF * Exp(error.head<3>());
      Vector6 y;
      y.head<3>() = R.transpose() * (v_W + error.segment<3>(6));
      y.tail<3>() = R_BF.transpose() * (rate_B - error.segment<3>(9));
      return y;
    };
    Matrix6 expected = Numeric(f, motion.covariance);
    expected.diagonal().tail<3>().array() += 0.25;
    ExpectNear(TwistCovariance(motion, T_BF, 0.25), expected);
  }
}

TEST_F(MotionCovarianceTest, PosesComposeAndInvert) {
  const api::Pose T = DrawPose();
  const api::Pose none = Compose(T, Inverse(T));
  EXPECT_LT(ToEigen(none.p).norm(), 1e-12);
  EXPECT_NEAR(std::abs(none.q[0]), 1, 1e-12);
  const api::Vec3 v = InFrame(T, {{1, 2, 3}});
  EXPECT_LT((ToEigen(v) - Quaternion(T).matrix().transpose() * Vector3d(1, 2, 3)).norm(), 1e-12);
}

}  // namespace
}  // namespace facet::robot
