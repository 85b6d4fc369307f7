// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/marginalization.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include "facet/estimator/factors/landmark_factors.h"
#include "facet/estimator/factors/window_factors.h"
#include "facet/estimator/solver/landmark_elimination.h"
#include "facet/estimator/solver/vision_system.h"

namespace facet {

namespace {

// The factors that are used up, and what they touch.
struct UsedFactors {
  NormalEquations equations;
  VariableSet touched;
};

void UseFactors(const MarginalizationPlan& plan,
                const FactorNoise& noise,
                const SlidingWindow& window,
                UsedFactors& used) {
  VisitFactors(window, noise, [&](const Factor auto& factor) {
    if (!factor.IsUsedUp(plan)) return;
    factor.AddTo(used.equations);
    factor.ForEachVariable([&](Variable variable) { used.touched.Insert(variable); });
  });
}

void UseLandmarks(const MarginalizationPlan& plan,
                  const StereoRig& rig,
                  const FactorNoise& noise,
                  const SlidingWindow& window,
                  UsedFactors& used) {
  NormalEquations& equations = used.equations;
  const StateLayout& layout = equations.layout;
  FrameGeometry geometry(rig);
  geometry.Update(window);
  // Landmarks have nothing to do with motions, whose columns come last.
  MatrixXd lower = MatrixXd::Zero(layout.dense_dim, layout.dense_dim);
  LandmarkBlock block;
  LensSums sums;
  LensSums* const lens = window.calibration ? &sums : nullptr;
  VectorXd b = VectorXd::Zero(layout.dense_dim);
  if (lens != nullptr) sums.Clear(window.frames.size());
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    const WindowLandmark& landmark = window.landmarks()[l];
    if (!plan.drop_landmark[l] || !IsConstraining(landmark)) continue;
    LinearizeLandmark(geometry, window.planes, landmark, noise, block, lens);
    Eliminate(0.0, block);
    AddDiagonal(block, layout, lower, b);
    for (int v = 0; v < block.num_views; ++v)
      used.touched.Insert(Variable::Pose(block.views[v].frame));
    for (int k = 0; k < block.num_plane_views; ++k)
      used.touched.Insert(Variable::Plane(block.plane_views[static_cast<std::size_t>(k)].plane));
    SubtractSchur(block, layout, lower, b);
  }
  if (lens != nullptr) {
    used.touched.Insert(Variable::Calibration());
    AddLensSums(sums, layout, lower, b);
    FillMountColumns(MountJacobiansOf(window, geometry), layout, lower, b);
  }
  equations.b.head(layout.dense_dim) += b;
  equations.H.topLeftCorner(layout.dense_dim, layout.dense_dim) +=
      lower.selfadjointView<Eigen::Lower>();
}

// Columns of the variables that are touched, the leaving ones apart.
struct Partition {
  std::vector<int> leaving;
  std::vector<int> staying;
  std::vector<MarginalPrior::Block> staying_blocks;
};

MarginalPrior::Block BlockOf(Variable variable, int offset, const SlidingWindow& window) {
  switch (variable.kind) {
    case Variable::Kind::kPlane:
      return MarginalPrior::Block::OfPlane(window.planes[variable.index].id, offset);
    case Variable::Kind::kCalibration:
      return MarginalPrior::Block::OfCalibration(offset);
    case Variable::Kind::kPose:
      return MarginalPrior::Block::OfPose(window.frames[variable.index].id, offset);
    case Variable::Kind::kMotion:
      break;
  }
  return MarginalPrior::Block::OfMotion(window.frames[variable.index].id, offset);
}

Partition MakePartition(const MarginalizationPlan& plan,
                        const UsedFactors& used,
                        const SlidingWindow& window) {
  Partition partition;
  const auto place = [&](Variable variable) {
    if (!used.touched.Contains(variable)) return;
    std::vector<int>& list = plan.Drops(variable) ? partition.leaving : partition.staying;
    if (!plan.Drops(variable)) {
      partition.staying_blocks.push_back(BlockOf(variable, static_cast<int>(list.size()), window));
    }
    const int column = used.equations.layout.ColumnOf(variable);
    for (int k = 0; k < SizeOf(variable.kind); ++k)
      list.push_back(column + k);
  };
  for (int k = 0; k < static_cast<int>(window.planes.size()); ++k)
    place(Variable::Plane(k));
  if (window.calibration) place(Variable::Calibration());
  for (int i = 0; i <= window.newest_frame(); ++i) {
    place(Variable::Pose(i));
    place(Variable::Motion(i));
  }
  return partition;
}

// Pseudo-inverse of a symmetric positive semidefinite matrix, scaled to unit diagonal first.
MatrixXd PseudoInverse(const MatrixXd& A) {
  const VectorXd scale = A.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  const double threshold = 1e-12 * std::max(eigen.eigenvalues().maxCoeff(), 0.0);
  const VectorXd inverse =
      eigen.eigenvalues().unaryExpr([&](double e) { return e > threshold ? 1.0 / e : 0.0; });
  return scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
         eigen.eigenvectors().transpose() * scale.asDiagonal();
}

// Equation (5.1): the Schur complement of what leaves.
void ReduceTo(const Partition& partition, const NormalEquations& equations, MarginalPrior& prior) {
  const MatrixXd& H = equations.H;
  const VectorXd& b = equations.b;
  const std::vector<int>& M = partition.leaving;
  const std::vector<int>& K = partition.staying;
  MatrixXd H_KK = H(K, K);
  VectorXd b_K = b(K);
  if (!M.empty()) {
    const MatrixXd H_KM = H(K, M);
    const MatrixXd gain = H_KM * PseudoInverse(H(M, M));
    H_KK -= gain * H_KM.transpose();
    b_K -= gain * b(M);
  }
  prior.H = 0.5 * (H_KK + H_KK.transpose());
  prior.b = b_K;
  prior.blocks = partition.staying_blocks;
}

void FreezePriorVariables(SlidingWindow& window) {
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    const int index = window.VariableOf(block).index;
    switch (block.kind) {
      case Variable::Kind::kPlane:
        window.planes[index].Freeze();
        break;
      case Variable::Kind::kCalibration:
        break;  // it is always linearised at the nominal one
      case Variable::Kind::kPose:
        window.frames[index].FreezePose();
        break;
      case Variable::Kind::kMotion:
        window.frames[index].FreezeMotion();
        break;
    }
  }
}

// With the variables go the factors that were used up.
void RemoveLeaving(const MarginalizationPlan& plan, SlidingWindow& window) {
  window.start_prior.reset();
  if (window.calibration) window.calibration->start_information.reset();
  window.RemoveLandmarks(plan.drop_landmark);
  for (int k = static_cast<int>(window.planes.size()) - 1; k >= 0; --k) {
    if (plan.drop_plane[k]) window.RemovePlane(k);
  }
  for (int i = window.newest_frame(); i >= 0; --i) {
    if (plan.drop_motion[i]) window.RemoveMotion(i);
    if (plan.drop_frame[i]) window.RemoveFrame(i);
  }
}

}  // namespace

void Marginalize(const MarginalizationPlan& plan,
                 const StereoRig& rig,
                 const FactorNoise& noise,
                 SlidingWindow& window) {
  if (plan.IsEmpty()) return;
  UsedFactors used;
  used.equations.Clear(window);
  used.touched.Clear(window.frames.size(), window.planes.size());
  UseFactors(plan, noise, window, used);
  UseLandmarks(plan, rig, noise, window, used);
  ReduceTo(MakePartition(plan, used, window), used.equations, window.prior);
  FreezePriorVariables(window);
  // The gradient was taken at the present delta; the prior is stored at delta = 0.
  window.prior.b -= window.prior.H * PriorDelta(window);
  RemoveLeaving(plan, window);
}

}  // namespace facet
