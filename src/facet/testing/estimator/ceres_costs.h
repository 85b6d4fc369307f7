// SPDX-License-Identifier: BSD-2-Clause
// The factors of a sliding window once more, for Ceres: residuals written from the formulas of
// docs/math.md, without the code under test.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <ceres/loss_function.h>
#include <ceres/rotation.h>

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/window/sliding_window.h"
#include "facet/geometry/so3.h"

namespace facet::testing {

template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Quat = Eigen::Quaternion<T>;

// Log of a rotation by way of Ceres' angle-axis functions (w first).
template <class T>
Vec3<T> Log(const Quat<T>& q) {
  const T wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  Vec3<T> out;
  ceres::QuaternionToAngleAxis(wxyz, out.data());
  return out;
}

template <class T>
Quat<T> Exp(const Vec3<T>& theta) {
  T wxyz[4];
  ceres::AngleAxisToQuaternion(theta.data(), wxyz);
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

// rho of ceres is twice ours and a function of the square.
class GemanMcClure : public ceres::LossFunction {
 public:
  explicit GemanMcClure(double c) : c2_(c * c) {}
  void Evaluate(double s2, double rho[3]) const override {
    const double w = 1 / (1 + s2 / c2_);
    rho[0] = s2 * w;
    rho[1] = w * w;
    rho[2] = -2 * w * w * w / c2_;
  }

 private:
  double c2_;
};

// q Exp(theta) on x y z w.
struct RightRotation {
  template <class T>
  bool Plus(const T* x, const T* delta, T* x_plus_delta) const {
    Eigen::Map<Quat<T>> out(x_plus_delta);
    out = Eigen::Map<const Quat<T>>(x) * Exp<T>(Eigen::Map<const Vec3<T>>(delta));
    return true;
  }
  template <class T>
  bool Minus(const T* y, const T* x, T* y_minus_x) const {
    Eigen::Map<Vec3<T>> out(y_minus_x);
    out = Log<T>(Eigen::Map<const Quat<T>>(x).conjugate() * Eigen::Map<const Quat<T>>(y));
    return true;
  }
};

// Two unit vectors across n, chosen as docs/math.md says; n itself is not differentiated.
inline Matrix<3, 2> BasisAt(const Vector3d& n) {
  return TangentBasis(n);
}

// Where the tangent step u leads from n.
template <class T>
Vec3<T> MoveDirection(const Vec3<T>& n, const Eigen::Matrix<T, 3, 2>& basis, const T* u) {
  const T square = u[0] * u[0] + u[1] * u[1];
  T cosine = T(1) - square / T(2), ratio = T(1) - square / T(6);
  if (square > T(1e-12)) {
    const T angle = sqrt(square);
    cosine = cos(angle);
    ratio = sin(angle) / angle;
  }
  return cosine * n + ratio * (basis.col(0) * u[0] + basis.col(1) * u[1]);
}

// The tangent step from n0 (constant) to n.
template <class T>
Eigen::Matrix<T, 2, 1> StepBetween(const Vector3d& n0, const Vec3<T>& n) {
  const Eigen::Matrix<T, 2, 1> across = BasisAt(n0).transpose().cast<T>() * n;
  const T square = across.squaredNorm();
  if (square < T(1e-12)) return across * (T(1) + square / T(6));
  const T sine = sqrt(square), cosine = n0.cast<T>().dot(n);
  return across * (atan2(sine, cosine) / sine);
}

template <class T>
Vector3d ValueOf(const Vec3<T>& v) {
  Vector3d out;
  for (int k = 0; k < 3; ++k) {
    if constexpr (std::is_same_v<T, double>) {
      out(k) = v(k);
    } else {
      out(k) = v(k).a;
    }
  }
  return out;
}

// Normal and offset, stepped by two tangent directions and the offset.
struct PlaneStep {
  template <class T>
  bool Plus(const T* x, const T* delta, T* x_plus_delta) const {
    const Vec3<T> n = Eigen::Map<const Vec3<T>>(x);
    Eigen::Map<Vec3<T>> out(x_plus_delta);
    out = MoveDirection<T>(n, BasisAt(ValueOf<T>(n)).template cast<T>(), delta);
    x_plus_delta[3] = x[3] + delta[2];
    return true;
  }
  template <class T>
  bool Minus(const T* y, const T* x, T* y_minus_x) const {
    const Vec3<T> n0 = Eigen::Map<const Vec3<T>>(x);
    Eigen::Map<Eigen::Matrix<T, 2, 1>> out(y_minus_x);
    out = StepBetween<T>(ValueOf<T>(n0), Eigen::Map<const Vec3<T>>(y));
    y_minus_x[2] = y[3] - x[3];
    return true;
  }
};

// Distance of a point of the world from a plane.
struct OnPlaneCost {
  Vector3d anchor_W;
  double sigma_m;

  template <class T>
  bool operator()(const T* plane, const T* point, T* residual) const {
    const Eigen::Map<const Vec3<T>> n(plane), p_W(point);
    residual[0] = (n.dot(p_W - anchor_W.cast<T>()) - plane[3]) / T(sigma_m);
    return true;
  }
};

// Angle from the heading of b, turned, to that of a, whatever the signs of the normals: in
// [-pi/2, pi/2].
template <class T>
T HeadingFrom(const Vec3<T>& n_a, const Vec3<T>& n_b, double turn) {
  const T angle = atan2(n_a.y(), n_a.x()) - atan2(n_b.y(), n_b.x()) - T(turn);
  return atan2(sin(T(2) * angle), cos(T(2) * angle)) / T(2);
}

// Section 8 of docs/math.md, in the world; the second plane of a relation to gravity is not used.
struct RelationCost {
  PlaneRelationKind kind;
  RelationNoise noise;
  Vector3d anchor_a, anchor_b, point_B;

  template <class T>
  bool operator()(const T* a, const T* b, const T* q, const T* p, T* residual) const {
    const Vec3<T> n_a(a[0], a[1], a[2]), n_b(b[0], b[1], b[2]);
    const T s(n_a.dot(n_b) < T(0) ? -1.0 : 1.0);
    Eigen::Map<Eigen::Matrix<T, 4, 1>> r(residual);
    r.setZero();
    switch (kind) {
      case PlaneRelationKind::kCoplanar: {
        const Vec3<T> c = Eigen::Map<const Quat<T>>(q) * Vec3<T>(point_B.cast<T>()) +
                          Eigen::Map<const Vec3<T>>(p);
        const T d_a = n_a.dot(c - anchor_a.cast<T>()) - a[3];
        const T d_b = n_b.dot(c - anchor_b.cast<T>()) - b[3];
        r(3) = (d_a - s * d_b) / T(noise.sigma_m);
        r.template head<3>() = (n_a - s * n_b) / T(noise.sigma_rad);
        break;
      }
      case PlaneRelationKind::kParallel:
        r.template head<3>() = (n_a - s * n_b) / T(noise.sigma_rad);
        break;
      case PlaneRelationKind::kOrthogonal:
        r(0) = n_a.dot(n_b) / T(noise.sigma_rad);
        break;
      case PlaneRelationKind::kHorizontal:
        r.template head<2>() = n_a.template head<2>() / T(noise.gravity_sigma_rad);
        break;
      case PlaneRelationKind::kVertical:
        r(0) = n_a.z() / T(noise.gravity_sigma_rad);
        break;
      case PlaneRelationKind::kHeadingParallel:
        r(0) = HeadingFrom(n_a, n_b, 0) / T(noise.sigma_rad);
        break;
      case PlaneRelationKind::kHeadingOrthogonal:
        r(0) = HeadingFrom(n_a, n_b, M_PI / 2) / T(noise.sigma_rad);
        break;
    }
    return true;
  }
};

// Section 9 of docs/math.md.
struct PlaneMeasurementCost {
  PlaneMeasurement measurement;
  Vector3d anchor;

  template <class T>
  bool operator()(const T* plane, const T* q, const T* p, T* residual) const {
    const Vec3<T> n(plane[0], plane[1], plane[2]);
    const Quat<T> q_WB = Eigen::Map<const Quat<T>>(q);
    const Vec3<T> c_W =
        q_WB * Vec3<T>(measurement.centre_B.cast<T>()) + Eigen::Map<const Vec3<T>>(p);
    residual[0] = (n.dot(c_W - anchor.cast<T>()) - plane[3]) / T(measurement.sigma_m);
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec3<T> along_W = q_WB * Vec3<T>(measurement.along_B[k].cast<T>());
      residual[1 + k] = n.dot(along_W) / T(measurement.sigma_rad[k]);
    }
    return true;
  }
};

// Reprojection of a point of the world.
struct ReprojectionCost {
  SE3 T_BC;
  MeasuredRay ray;
  double scale;

  template <class T>
  bool operator()(const T* q, const T* p, const T* point, T* residual) const {
    const Eigen::Map<const Quat<T>> q_WB(q);
    const Eigen::Map<const Vec3<T>> p_WB(p), p_W(point);
    const Vec3<T> p_B = q_WB.conjugate() * (p_W - p_WB);
    const Vec3<T> p_C = T_BC.q.conjugate().cast<T>() * (p_B - T_BC.p.cast<T>());
    const Vec3<T> error = p_C / ray.bearing.cast<T>().dot(p_C) - ray.bearing.cast<T>();
    Eigen::Map<Eigen::Matrix<T, 2, 1>> whitened(residual);
    whitened = T(scale) * (ray.whitening.cast<T>() * error);
    return true;
  }
};

// Equations (2.11) to (2.15) of docs/math.md. A motion is v b_g b_a.
struct ImuCost {
  const ImuPreintegration& imu;
  Matrix<15, 15> sqrt_info;

  template <class T>
  bool operator()(const T* q_i,
                  const T* p_i,
                  const T* m_i,
                  const T* q_j,
                  const T* p_j,
                  const T* m_j,
                  T* residual) const {
    const Eigen::Map<const Quat<T>> R_i(q_i), R_j(q_j);
    const Eigen::Map<const Vec3<T>> x_i(p_i), x_j(p_j), v_i(m_i), v_j(m_j);
    const Eigen::Map<const Eigen::Matrix<T, 6, 1>> bias_i(m_i + 3), bias_j(m_j + 3);
    Vector<6> lin_bias;
    lin_bias << imu.bias().b_g, imu.bias().b_a;
    const Eigen::Matrix<T, 9, 1> shift =
        imu.BiasJacobian().cast<T>() * (bias_i - lin_bias.cast<T>());
    const Quat<T> dR = imu.dR().cast<T>() * Exp<T>(shift.template head<3>());
    const T dt(imu.dt());
    const Vec3<T> g(T(0), T(0), T(-9.81));
    Eigen::Matrix<T, 15, 1> r;
    r.template segment<3>(0) = Log<T>(dR.conjugate() * (R_i.conjugate() * R_j));
    r.template segment<3>(3) =
        R_i.conjugate() * Vec3<T>(x_j - x_i - dt * v_i - T(0.5) * dt * dt * g) -
        imu.dp().cast<T>() - shift.template segment<3>(3);
    r.template segment<3>(6) = R_i.conjugate() * Vec3<T>(v_j - v_i - dt * g) - imu.dv().cast<T>() -
                               shift.template segment<3>(6);
    r.template tail<6>() = bias_j - bias_i;
    Eigen::Map<Eigen::Matrix<T, 15, 1>> whitened(residual);
    whitened = sqrt_info.cast<T>() * r;
    return true;
  }
};

struct StartCost {
  StartPrior prior;

  template <class T>
  bool operator()(const T* q, const T* p, const T* m, T* residual) const {
    const Quat<T> turn = Eigen::Map<const Quat<T>>(q) * prior.T_WB.q.conjugate().cast<T>();
    for (int k = 0; k < 3; ++k) {
      residual[k] = (p[k] - prior.T_WB.p(k)) / prior.sigma_position;
      residual[4 + k] = m[k] / prior.sigma_velocity;
      residual[7 + k] = m[3 + k] / prior.sigma_gyro_bias;
      residual[10 + k] = m[6 + k] / prior.sigma_accel_bias;
    }
    residual[3] = Log<T>(turn).z() / prior.sigma_yaw;
    return true;
  }
};

// 1/2 d^T H d + b^T d as 1/2 |L^T d + L^-1 b|^2 up to a constant, H = L L^T. Blocks of three.
class QuadraticCost {
 public:
  struct Part {
    bool is_rotation = false;
    bool is_plane = false;  // x0 is the normal
    Quaterniond q0 = Quaterniond::Identity();
    Vector3d x0 = Vector3d::Zero();
    int parameter = 0, offset_in_parameter = 0;
    double offset0 = 0;  // of a plane

    static Part At(const Vector3d& value, int offset) {
      Part part;
      part.x0 = value;
      part.offset_in_parameter = offset;
      return part;
    }
  };
  QuadraticCost(const MatrixXd& H, const VectorXd& b, std::vector<Part> parts)
      : root_(H.llt().matrixU()), shift_(H.llt().matrixL().solve(b)), parts_(std::move(parts)) {}

  double constant() const { return 0.5 * shift_.squaredNorm(); }

  template <class T>
  bool operator()(T const* const* parameters, T* residual) const {
    Eigen::Matrix<T, Eigen::Dynamic, 1> d(shift_.size());
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const Part& part = parts_[k];
      const T* x = parameters[part.parameter] + part.offset_in_parameter;
      const auto out = static_cast<Eigen::Index>(3 * k);
      if (part.is_plane) {
        d.template segment<2>(out) = StepBetween<T>(part.x0, Eigen::Map<const Vec3<T>>(x));
        d(out + 2) = x[3] - T(part.offset0);
      } else if (part.is_rotation) {
        d.template segment<3>(out) =
            Log<T>(part.q0.conjugate().cast<T>() * Eigen::Map<const Quat<T>>(x));
      } else {
        d.template segment<3>(out) = Eigen::Map<const Vec3<T>>(x) - part.x0.cast<T>();
      }
    }
    Eigen::Map<Eigen::Matrix<T, Eigen::Dynamic, 1>> whitened(residual, d.size());
    whitened = root_.cast<T>() * d + shift_.cast<T>();
    return true;
  }

 private:
  MatrixXd root_;
  VectorXd shift_;
  std::vector<Part> parts_;
};

}  // namespace facet::testing
