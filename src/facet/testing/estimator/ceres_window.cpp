// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/estimator/ceres_window.h"

#include <ceres/autodiff_manifold.h>
#include <ceres/ceres.h>

#include "facet/base/check.h"
#include "facet/testing/estimator/ceres_costs.h"

namespace facet::testing {

namespace {

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
                               options_.noise.relations,
                               window_.planes[a].anchor_W,
                               window_.planes[b].anchor_W,
                               relation.point_B}),
          new ceres::HuberLoss(options_.noise.relations.huber_sigma),
          std::vector<double*>{
              planes_[a].data(), planes_[b].data(), frame.q.data(), frame.p.data()});
    }
    for (const PlaneMeasurement& measurement : window_.measurements) {
      const auto k = static_cast<std::size_t>(window_.IndexOf(measurement.plane));
      FrameBlock& frame = blocks_[window_.IndexOf(measurement.frame)];
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PlaneMeasurementCost, 3, 4, 4, 3>(
              new PlaneMeasurementCost{measurement, window_.planes[k].anchor_W}),
          new ceres::HuberLoss(options_.noise.measurement_huber_sigma),
          std::vector<double*>{planes_[k].data(), frame.q.data(), frame.p.data()});
    }
  }

  ceres::LossFunction* NewLoss(const WindowLandmark& landmark) const {
    if (landmark.is_projection) return new ceres::TukeyLoss(options_.noise.projection.tukey_sigma);
    return new GemanMcClure(options_.noise.reprojection_width);
  }

  void AddLandmarks() {
    for (std::size_t l = 0; l < points_.size(); ++l) {
      const WindowLandmark& landmark = window_.landmarks()[l];
      points_[l] = PointOf(window_, landmark);
      if (landmark.observations.size() + static_cast<std::size_t>(landmark.planes.count()) < 2)
        continue;
      for (int k = 0; k < landmark.planes.count(); ++k) {
        const auto plane = static_cast<std::size_t>(landmark.planes[k]);
        const double sigma_m = landmark.planes.row_scale(k) * window_.planes[plane].row_sigma_m;
        problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<OnPlaneCost, 1, 4, 3>(
                                      new OnPlaneCost{window_.planes[plane].anchor_W, sigma_m}),
                                  new ceres::HuberLoss(options_.noise.plane_huber_sigma),
                                  planes_[plane].data(),
                                  points_[l].data());
      }
      for (const WindowObservation& o : landmark.observations) {
        for (int c = 0; c < (o.has_right ? 2 : 1); ++c) {
          const double scale =
              landmark.is_projection ? o.sigma_px[c] / options_.noise.projection.sigma_px : 1.0;
          auto* cost = new ReprojectionCost{rig_.T_BC[c], o.rays[c], scale};
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
      if (!window_.frames[j].imu_link) continue;
      const ImuPreintegration& imu = window_.frames[j].imu_link->measured;
      const BiasWalk walk = DefaultBiasWalk();
      Matrix<15, 15> sqrt_info = Matrix<15, 15>::Zero();
      const Matrix<9, 9> information = imu.Covariance().inverse();
      sqrt_info.topLeftCorner<9, 9>() = information.llt().matrixU();
      sqrt_info.diagonal().segment<3>(9).setConstant(1 / (walk.gyro * std::sqrt(imu.dt())));
      sqrt_info.diagonal().segment<3>(12).setConstant(1 / (walk.accel * std::sqrt(imu.dt())));
      FrameBlock& a = blocks_[j - 1];
      FrameBlock& b = blocks_[j];
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ImuCost, 15, 4, 3, 9, 4, 3, 9>(
              new ImuCost{imu, sqrt_info}),
          nullptr,
          std::vector<double*>{
              a.q.data(), a.p.data(), a.m.data(), b.q.data(), b.p.data(), b.m.data()});
    }
    if (!window_.start_prior) return;
    FrameBlock& first = blocks_[window_.IndexOf(window_.start_prior->frame)];
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<StartCost, 13, 4, 3, 9>(
                                  new StartCost{*window_.start_prior}),
                              nullptr,
                              std::vector<double*>{first.q.data(), first.p.data(), first.m.data()});
  }

  // What the prior says about one variable, in parts of three.
  struct PriorVariable {
    double* block;
    int size;
    QuadraticCost::Part part;
  };
  std::vector<PriorVariable> VariablesOf(const MarginalPrior::Block& block) {
    const int index = window_.VariableOf(block).index;
    if (block.kind == Variable::Kind::kPlane) {
      const WindowPlane& plane = window_.planes[index];
      QuadraticCost::Part part = QuadraticCost::Part::At(plane.n_lin, 0);
      part.is_plane = true;
      part.offset0 = plane.offset - plane.delta.z();
      return {{planes_[static_cast<std::size_t>(index)].data(), 4, part}};
    }
    const NavState& lin = window_.frames[index].lin;
    FrameBlock& frame = blocks_[index];
    if (block.kind == Variable::Kind::kMotion) {
      return {{frame.m.data(), 9, QuadraticCost::Part::At(lin.v_WB, 0)},
              {frame.m.data(), 9, QuadraticCost::Part::At(lin.bias.b_g, 3)},
              {frame.m.data(), 9, QuadraticCost::Part::At(lin.bias.b_a, 6)}};
    }
    QuadraticCost::Part rotation;
    rotation.is_rotation = true;
    rotation.q0 = lin.T_WB.q;
    return {{frame.q.data(), 4, rotation},
            {frame.p.data(), 3, QuadraticCost::Part::At(lin.T_WB.p, 0)}};
  }

  void AddPrior() {
    std::vector<QuadraticCost::Part> parts;
    std::vector<int> sizes;
    for (const MarginalPrior::Block& block : window_.prior.blocks) {
      for (PriorVariable& variable : VariablesOf(block)) {
        if (prior_parameters_.empty() || prior_parameters_.back() != variable.block) {
          prior_parameters_.push_back(variable.block);
          sizes.push_back(variable.size);
        }
        variable.part.parameter = static_cast<int>(sizes.size()) - 1;
        parts.push_back(variable.part);
      }
    }
    if (options_.hold_prior_variables) {
      for (double* block : prior_parameters_)
        problem_.SetParameterBlockConstant(block);
      return;
    }
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
