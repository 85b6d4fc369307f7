// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/marginalization.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include "facet/base/check.h"
#include "facet/estimator/factors/relation_factor.h"
#include "facet/estimator/solver/window_system.h"

namespace facet {

namespace {

// Columns of the involved variables, the leaving ones apart.
struct Partition {
  std::vector<int> leaving;
  std::vector<int> staying;
  std::vector<MarginalPrior::Block> staying_blocks;
};

// Which poses and motions appear in a factor that is being used up.
struct Involved {
  std::vector<char> pose, motion, plane;
};

bool LeavesMotion(const MarginalizationPlan& plan, int frame) {
  return plan.drop_frame[frame] || plan.drop_motion[frame];
}

Involved FindInvolved(const SlidingWindow& window) {
  const std::size_t n = window.frames.size();
  Involved involved{
      std::vector<char>(n, 0), std::vector<char>(n, 0), std::vector<char>(window.planes.size(), 0)};
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.IsPlane()) {
      involved.plane[window.IndexOf(block.plane)] = 1;
      continue;
    }
    (block.is_motion ? involved.motion : involved.pose)[window.IndexOf(block.frame)] = 1;
  }
  return involved;
}

// Adds the IMU links that touch a leaving motion and cuts them.
void UseImuLinks(const MarginalizationPlan& plan,
                 const StateLayout& layout,
                 SlidingWindow& window,
                 Involved& involved,
                 MatrixXd& H,
                 VectorXd& b) {
  for (int j = 1; j < static_cast<int>(window.frames.size()); ++j) {
    if (!window.frames[j].has_imu_link) continue;
    if (!LeavesMotion(plan, j) && !LeavesMotion(plan, j - 1)) continue;
    AddImuLink(window, layout, j, &H, &b);
    window.frames[j].has_imu_link = false;
    for (int k : {j - 1, j})
      involved.pose[k] = involved.motion[k] = 1;
  }
}

// Adds the relations of leaving planes and removes them.
void UseRelations(const MarginalizationPlan& plan,
                  const StateLayout& layout,
                  const RelationNoise& noise,
                  SlidingWindow& window,
                  Involved& involved,
                  MatrixXd& H,
                  VectorXd& b) {
  std::erase_if(window.relations, [&](const WindowRelation& relation) {
    const PlaneRelation& r = relation.relation;
    const int plane_a = window.IndexOf(r.a);
    const int plane_b = r.IsUnary() ? plane_a : window.IndexOf(r.b);
    if (!plan.drop_plane[plane_a] && !plan.drop_plane[plane_b]) return false;
    AddPlaneRelation(window, layout, relation, noise, &H, &b);
    involved.plane[plane_a] = involved.plane[plane_b] = 1;
    if (NeedsFrame(r.kind)) involved.pose[window.IndexOf(relation.frame)] = 1;
    return true;
  });
}

// Adds what leaving frames have sighted.
void UseSightings(const MarginalizationPlan& plan,
                  const StateLayout& layout,
                  double huber_sigma,
                  const SlidingWindow& window,
                  Involved& involved,
                  MatrixXd& H,
                  VectorXd& b) {
  for (const PlaneSighting& sighting : window.sightings) {
    const int frame = window.IndexOf(sighting.frame);
    if (!plan.drop_frame[frame]) continue;
    AddPlaneSighting(window, layout, sighting, huber_sigma, &H, &b);
    involved.pose[frame] = involved.plane[window.IndexOf(sighting.plane)] = 1;
  }
}

void UseLandmarks(const MarginalizationPlan& plan,
                  const StereoRig& rig,
                  const RobustOptions& robust,
                  const StateLayout& layout,
                  const SlidingWindow& window,
                  Involved& involved,
                  MatrixXd& H,
                  VectorXd& b) {
  FrameGeometry geometry(rig);
  geometry.Update(window.frames);
  MatrixXd lower = MatrixXd::Zero(layout.dim, layout.dim);
  LandmarkBlock block;
  for (std::size_t l = 0; l < window.landmarks().size(); ++l) {
    const WindowLandmark& landmark = window.landmarks()[l];
    if (!plan.drop_landmark[l] || !IsConstraining(landmark)) continue;
    LinearizeLandmark(geometry, window.planes, landmark, robust, block);
    Eliminate(0.0, block);
    AddDiagonal(block, layout, lower, b);
    for (int v = 0; v < block.num_views; ++v)
      involved.pose[block.views[v].frame] = 1;
    for (int k = 0; k < block.num_plane_views; ++k)
      involved.plane[block.plane_views[static_cast<std::size_t>(k)].plane] = 1;
    SubtractSchur(block, layout, lower, b);
  }
  H += lower.selfadjointView<Eigen::Lower>();
}

Partition MakePartition(const MarginalizationPlan& plan,
                        const StateLayout& layout,
                        const Involved& involved,
                        const SlidingWindow& window) {
  Partition partition;
  const auto place = [&](int frame, bool is_motion, bool leaves) {
    const int column = is_motion ? layout.motion_column[frame] : layout.pose_column[frame];
    const int size = is_motion ? 9 : 6;
    std::vector<int>& list = leaves ? partition.leaving : partition.staying;
    if (!leaves) {
      partition.staying_blocks.push_back(
          {window.frames[frame].id, is_motion, static_cast<int>(list.size())});
    }
    for (int k = 0; k < size; ++k)
      list.push_back(column + k);
  };
  for (std::size_t k = 0; k < window.planes.size(); ++k) {
    if (!involved.plane[k]) continue;
    std::vector<int>& list = plan.drop_plane[k] ? partition.leaving : partition.staying;
    if (!plan.drop_plane[k]) {
      partition.staying_blocks.push_back(
          {FrameId{}, false, static_cast<int>(list.size()), window.planes[k].id});
    }
    for (int c = 0; c < 3; ++c)
      list.push_back(layout.plane_column[k] + c);
  }
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    const int frame = static_cast<int>(i);
    if (involved.pose[i]) place(frame, false, plan.drop_frame[i]);
    if (involved.motion[i]) place(frame, true, LeavesMotion(plan, frame));
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

void Freeze(SlidingWindow& window) {
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.IsPlane()) {
      window.planes[window.IndexOf(block.plane)].Freeze();
      continue;
    }
    WindowFrame& frame = window.frames[window.IndexOf(block.frame)];
    if (block.is_motion && !frame.motion_frozen) {
      frame.motion_frozen = true;
      frame.lin.v_WB = frame.x.v_WB;
      frame.lin.bias = frame.x.bias;
      frame.delta.tail<9>().setZero();
    }
    if (!block.is_motion && !frame.pose_frozen) {
      frame.pose_frozen = true;
      frame.lin.T_WB = frame.x.T_WB;
      frame.delta.head<6>().setZero();
    }
  }
}

}  // namespace

bool MarginalizationPlan::IsEmpty() const {
  const auto none = [](const std::vector<char>& flags) {
    return std::none_of(flags.begin(), flags.end(), [](char f) { return f != 0; });
  };
  return none(drop_frame) && none(drop_motion) && none(drop_landmark) && none(drop_plane);
}

void Marginalize(const MarginalizationPlan& plan,
                 const StereoRig& rig,
                 const RobustOptions& robust,
                 SlidingWindow& window) {
  if (plan.IsEmpty()) return;
  const StateLayout layout = MakeLayout(window);
  MatrixXd H = MatrixXd::Zero(layout.dim, layout.dim);
  VectorXd b = VectorXd::Zero(layout.dim);

  Involved involved = FindInvolved(window);
  AddPrior(window, layout, &H, &b);
  if (window.start_prior.active) {
    AddStartPrior(window, layout, &H, &b);
    const int first = window.IndexOf(window.start_prior.frame);
    involved.pose[first] = involved.motion[first] = 1;
    window.start_prior.active = false;
  }
  UseImuLinks(plan, layout, window, involved, H, b);
  UseRelations(plan, layout, robust.relations, window, involved, H, b);
  UseSightings(plan, layout, robust.sighting_huber_sigma, window, involved, H, b);
  UseLandmarks(plan, rig, robust, layout, window, involved, H, b);

  const Partition partition = MakePartition(plan, layout, involved, window);
  const auto& M = partition.leaving;
  const auto& K = partition.staying;
  MatrixXd H_KK = H(K, K);
  VectorXd b_K = b(K);
  if (!M.empty()) {
    const MatrixXd H_KM = H(K, M);
    const MatrixXd gain = H_KM * PseudoInverse(H(M, M));
    H_KK -= gain * H_KM.transpose();
    b_K -= gain * b(M);
  }
  window.prior.H = 0.5 * (H_KK + H_KK.transpose());
  window.prior.blocks = partition.staying_blocks;
  window.prior.b = b_K;
  Freeze(window);
  // The gradient was taken at the present delta; the prior is stored at delta = 0.
  window.prior.b -= window.prior.H * PriorDelta(window);

  window.RemoveLandmarks(plan.drop_landmark);
  for (int k = static_cast<int>(window.planes.size()) - 1; k >= 0; --k) {
    if (plan.drop_plane[k]) window.RemovePlane(k);
  }
  for (int i = static_cast<int>(window.frames.size()) - 1; i >= 0; --i) {
    if (plan.drop_motion[i]) window.frames[i].has_motion = window.frames[i].motion_frozen = false;
    if (plan.drop_frame[i]) window.RemoveFrame(i);
  }
}

}  // namespace facet
