// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/estimator/ceres_window.h"

#include <type_traits>

#include <Eigen/Cholesky>
#include <ceres/autodiff_manifold.h>
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "facet/base/check.h"

namespace facet::testing {

namespace {

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
Matrix<3, 2> BasisAt(const Vector3d& n) {
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
    const auto heading = [&](double turn) {
      // The sine is the angle near zero, and knows no sign of the normals.
      const T angle = atan2(n_a.y(), n_a.x()) - atan2(n_b.y(), n_b.x()) - T(turn);
      const T folded = atan2(sin(T(2) * angle), cos(T(2) * angle)) / T(2);
      return folded / T(noise.sigma_rad);
    };
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
        r(0) = heading(0);
        break;
      case PlaneRelationKind::kHeadingOrthogonal:
        r(0) = heading(M_PI / 2);
        break;
    }
    return true;
  }
};

// Section 9 of docs/math.md.
struct SightingCost {
  PlaneSighting sighting;
  Vector3d anchor;

  template <class T>
  bool operator()(const T* plane, const T* q, const T* p, T* residual) const {
    const Vec3<T> n(plane[0], plane[1], plane[2]);
    const Quat<T> q_WB = Eigen::Map<const Quat<T>>(q);
    const Vec3<T> c_W = q_WB * Vec3<T>(sighting.centre_B.cast<T>()) + Eigen::Map<const Vec3<T>>(p);
    residual[0] = (n.dot(c_W - anchor.cast<T>()) - plane[3]) / T(sighting.sigma_m);
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec3<T> along_W = q_WB * Vec3<T>(sighting.along_B[k].cast<T>());
      residual[1 + k] = n.dot(along_W) / T(sighting.sigma_rad[k]);
    }
    return true;
  }
};

// Reprojection of a point of the world.
struct ReprojectionCost {
  SE3 T_BC;
  Vector2d xy;
  Matrix2d sqrt_info;

  template <class T>
  bool operator()(const T* q, const T* p, const T* point, T* residual) const {
    const Eigen::Map<const Quat<T>> q_WB(q);
    const Eigen::Map<const Vec3<T>> p_WB(p), p_W(point);
    const Vec3<T> p_B = q_WB.conjugate() * (p_W - p_WB);
    const Vec3<T> p_C = T_BC.q.conjugate().cast<T>() * (p_B - T_BC.p.cast<T>());
    const Eigen::Matrix<T, 2, 1> error(p_C.x() / p_C.z() - xy.x(), p_C.y() / p_C.z() - xy.y());
    Eigen::Map<Eigen::Matrix<T, 2, 1>> whitened(residual);
    whitened = sqrt_info.cast<T>() * error;
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

class CeresWindow {
 public:
  CeresWindow(const SlidingWindow& window, const StereoRig& rig, const CeresOptions& options)
      : window_(window),
        rig_(rig),
        options_(options),
        blocks_(window.frames.size()),
        points_(window.landmarks().size()),
        planes_(window.planes.size()) {
    AddFrames();
    AddPlanes();
    AddLandmarks();
    AddImu();
    if (window_.prior.dim() > 0) AddPrior();
  }

  CeresResult Solve() {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.max_num_iterations = 200;
    solver.function_tolerance = 1e-18;
    solver.gradient_tolerance = 1e-12;
    solver.parameter_tolerance = 1e-14;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    FACET_CHECK(summary.IsSolutionUsable()) << summary.BriefReport();

    CeresResult result;
    result.cost = summary.final_cost - constant_;
    result.points = points_;
    for (const auto& plane : planes_)
      result.planes.push_back(Eigen::Map<const Vector4d>(plane.data()));
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      NavState x = window_.frames[i].x;
      x.T_WB.q = Eigen::Map<const Quaterniond>(blocks_[i].q.data());
      x.T_WB.p = Eigen::Map<const Vector3d>(blocks_[i].p.data());
      x.v_WB = Eigen::Map<const Vector3d>(blocks_[i].m.data());
      x.bias.b_g = Eigen::Map<const Vector3d>(blocks_[i].m.data() + 3);
      x.bias.b_a = Eigen::Map<const Vector3d>(blocks_[i].m.data() + 6);
      result.states.push_back(x);
    }
    if (options_.hold_prior_variables) result.prior_gradient = PriorGradient();
    return result;
  }

 private:
  struct FrameBlock {
    std::array<double, 4> q;
    std::array<double, 3> p;
    std::array<double, 9> m;
  };

  void AddFrames() {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const NavState& x = window_.frames[i].x;
      FrameBlock& block = blocks_[i];
      Eigen::Map<Quaterniond>(block.q.data()) = x.T_WB.q;
      Eigen::Map<Vector3d>(block.p.data()) = x.T_WB.p;
      Eigen::Map<Vector<9>>(block.m.data()) << x.v_WB, x.bias.b_g, x.bias.b_a;
      problem_.AddParameterBlock(
          block.q.data(), 4, new ceres::AutoDiffManifold<RightRotation, 4, 3>);
      problem_.AddParameterBlock(block.p.data(), 3);
      if (window_.frames[i].has_motion) problem_.AddParameterBlock(block.m.data(), 9);
    }
  }

  void AddPlanes() {
    for (std::size_t k = 0; k < planes_.size(); ++k) {
      const WindowPlane& plane = window_.planes[k];
      Eigen::Map<Vector4d>(planes_[k].data()) << plane.n, plane.offset;
      problem_.AddParameterBlock(
          planes_[k].data(), 4, new ceres::AutoDiffManifold<PlaneStep, 4, 3>);
    }
    for (const WindowRelation& relation : window_.relations) {
      const PlaneRelation& r = relation.relation;
      const auto a = static_cast<std::size_t>(window_.IndexOf(r.a));
      // Any other plane in the place of one that is not used: a block must not appear twice.
      const std::size_t b =
          r.IsUnary() ? (a == 0 ? 1 : 0) : static_cast<std::size_t>(window_.IndexOf(r.b));
      FrameBlock& frame = blocks_[window_.IndexOf(relation.frame)];
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RelationCost, 4, 4, 4, 4, 3>(
              new RelationCost{r.kind,
                               options_.robust.relations,
                               window_.planes[a].anchor_W,
                               window_.planes[b].anchor_W,
                               relation.point_B}),
          new ceres::HuberLoss(options_.robust.relations.huber_sigma),
          std::vector<double*>{
              planes_[a].data(), planes_[b].data(), frame.q.data(), frame.p.data()});
    }
    for (const PlaneSighting& sighting : window_.sightings) {
      const auto k = static_cast<std::size_t>(window_.IndexOf(sighting.plane));
      FrameBlock& frame = blocks_[window_.IndexOf(sighting.frame)];
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<SightingCost, 3, 4, 4, 3>(
              new SightingCost{sighting, window_.planes[k].anchor_W}),
          new ceres::HuberLoss(options_.robust.sighting_huber_sigma),
          std::vector<double*>{planes_[k].data(), frame.q.data(), frame.p.data()});
    }
  }

  ceres::LossFunction* NewLoss(const WindowLandmark& landmark) const {
    if (landmark.is_projection) return new ceres::TukeyLoss(options_.robust.projection.tukey_sigma);
    return new GemanMcClure(options_.robust.reprojection_width);
  }

  void AddLandmarks() {
    for (std::size_t l = 0; l < points_.size(); ++l) {
      const WindowLandmark& landmark = window_.landmarks()[l];
      points_[l] = PointOf(window_, landmark);
      if (landmark.observations.size() + static_cast<std::size_t>(landmark.planes.count) < 2)
        continue;
      for (int k = 0; k < landmark.planes.count; ++k) {
        const auto plane =
            static_cast<std::size_t>(landmark.planes.index[static_cast<std::size_t>(k)]);
        problem_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<OnPlaneCost, 1, 4, 3>(
                new OnPlaneCost{window_.planes[plane].anchor_W, window_.planes[plane].row_sigma_m}),
            new ceres::HuberLoss(options_.robust.plane_huber_sigma),
            planes_[plane].data(),
            points_[l].data());
      }
      for (const WindowObservation& o : landmark.observations) {
        for (int c = 0; c < (o.has_right ? 2 : 1); ++c) {
          const double scale =
              landmark.is_projection ? o.sigma_px[c] / options_.robust.projection.sigma_px : 1.0;
          auto* cost = new ReprojectionCost{rig_.T_BC[c], o.xy[c], scale * o.sqrt_info[c]};
          problem_.AddResidualBlock(
              new ceres::AutoDiffCostFunction<ReprojectionCost, 2, 4, 3, 3>(cost),
              NewLoss(landmark),
              blocks_[o.frame].q.data(),
              blocks_[o.frame].p.data(),
              points_[l].data());
        }
      }
    }
  }

  void AddImu() {
    for (std::size_t j = 1; j < blocks_.size(); ++j) {
      const WindowFrame& frame = window_.frames[j];
      if (!frame.has_imu_link) continue;
      const BiasWalk walk;
      Matrix<15, 15> sqrt_info = Matrix<15, 15>::Zero();
      const Matrix<9, 9> information = frame.imu.Covariance().inverse();
      sqrt_info.topLeftCorner<9, 9>() = information.llt().matrixU();
      sqrt_info.diagonal().segment<3>(9).setConstant(1 / (walk.gyro * std::sqrt(frame.imu.dt())));
      sqrt_info.diagonal().segment<3>(12).setConstant(1 / (walk.accel * std::sqrt(frame.imu.dt())));
      FrameBlock& a = blocks_[j - 1];
      FrameBlock& b = blocks_[j];
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ImuCost, 15, 4, 3, 9, 4, 3, 9>(
              new ImuCost{frame.imu, sqrt_info}),
          nullptr,
          std::vector<double*>{
              a.q.data(), a.p.data(), a.m.data(), b.q.data(), b.p.data(), b.m.data()});
    }
    if (!window_.start_prior.active) return;
    FrameBlock& first = blocks_[window_.IndexOf(window_.start_prior.frame)];
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<StartCost, 13, 4, 3, 9>(new StartCost{window_.start_prior}),
        nullptr,
        std::vector<double*>{first.q.data(), first.p.data(), first.m.data()});
  }

  void AddPrior() {
    std::vector<QuadraticCost::Part> parts;
    std::vector<int> sizes;
    const auto add = [&](double* block, int size) {
      prior_parameters_.push_back(block);
      sizes.push_back(size);
      if (options_.hold_prior_variables) problem_.SetParameterBlockConstant(block);
      return static_cast<int>(sizes.size()) - 1;
    };
    for (const MarginalPrior::Block& block : window_.prior.blocks) {
      if (block.IsPlane()) {
        const int index = window_.IndexOf(block.plane);
        const WindowPlane& plane = window_.planes[index];
        const int parameter = add(planes_[static_cast<std::size_t>(index)].data(), 4);
        parts.push_back({false,
                         true,
                         Quaterniond::Identity(),
                         plane.n_lin,
                         parameter,
                         0,
                         plane.offset - plane.delta.z()});
        continue;
      }
      const int frame = window_.IndexOf(block.frame);
      const NavState& lin = window_.frames[frame].lin;
      if (block.is_motion) {
        const int parameter = add(blocks_[frame].m.data(), 9);
        parts.push_back({false, false, Quaterniond::Identity(), lin.v_WB, parameter, 0});
        parts.push_back({false, false, Quaterniond::Identity(), lin.bias.b_g, parameter, 3});
        parts.push_back({false, false, Quaterniond::Identity(), lin.bias.b_a, parameter, 6});
      } else {
        parts.push_back(
            {true, false, lin.T_WB.q, Vector3d::Zero(), add(blocks_[frame].q.data(), 4), 0});
        parts.push_back({false,
                         false,
                         Quaterniond::Identity(),
                         lin.T_WB.p,
                         add(blocks_[frame].p.data(), 3),
                         0});
      }
    }
    if (options_.hold_prior_variables) return;
    auto* quadratic = new QuadraticCost(window_.prior.H, window_.prior.b, std::move(parts));
    constant_ = quadratic->constant();
    auto* cost = new ceres::DynamicAutoDiffCostFunction<QuadraticCost>(quadratic);
    for (int size : sizes)
      cost->AddParameterBlock(size);
    cost->SetNumResiduals(window_.prior.dim());
    problem_.AddResidualBlock(cost, nullptr, prior_parameters_);
  }

  VectorXd PriorGradient() {
    for (double* block : prior_parameters_)
      problem_.SetParameterBlockVariable(block);
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.parameter_blocks = prior_parameters_;
    std::vector<double> gradient;
    problem_.Evaluate(evaluate, nullptr, nullptr, &gradient, nullptr);
    return Eigen::Map<const VectorXd>(gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  }

  const SlidingWindow& window_;
  const StereoRig& rig_;
  CeresOptions options_;
  std::vector<FrameBlock> blocks_;
  std::vector<Vector3d> points_;
  std::vector<std::array<double, 4>> planes_;
  std::vector<double*> prior_parameters_;
  double constant_ = 0;  // what Ceres' form of the prior adds
  ceres::Problem problem_;
};

}  // namespace

CeresResult SolveWithCeres(const SlidingWindow& window,
                           const StereoRig& rig,
                           const CeresOptions& options) {
  return CeresWindow(window, rig, options).Solve();
}

}  // namespace facet::testing
