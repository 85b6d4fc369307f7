// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/window_system.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <Eigen/Cholesky>

#include "facet/base/check.h"
#include "facet/base/median.h"
#include "facet/estimator/factors/relation_factor.h"
#include "facet/estimator/factors/robust_loss.h"
#include "facet/estimator/factors/sighting_factor.h"
#include "facet/estimator/solver/schur_kernel.h"

namespace facet {

namespace {

// Adds the dense normal equations of one factor between the blocks (column, size, offset in J).
struct Slice {
  int column;
  int size;
  int offset;
};

template <class J, class R>
void AddFactor(
    const J& jacobian, const R& r, std::initializer_list<Slice> slices, MatrixXd& H, VectorXd& b) {
  const MatrixXd JtJ = jacobian.transpose() * jacobian;
  const VectorXd Jtr = jacobian.transpose() * r;
  for (const Slice& a : slices) {
    b.segment(a.column, a.size) += Jtr.segment(a.offset, a.size);
    for (const Slice& c : slices) {
      H.block(a.column, c.column, a.size, c.size) += JtJ.block(a.offset, c.offset, a.size, c.size);
    }
  }
}

}  // namespace

VectorXd PriorDelta(const SlidingWindow& window) {
  VectorXd delta(window.prior.dim());
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.IsPlane()) {
      delta.segment<3>(block.offset) = window.planes[window.IndexOf(block.plane)].delta;
      continue;
    }
    const WindowFrame& frame = window.frames[window.IndexOf(block.frame)];
    if (block.is_motion) {
      delta.segment<9>(block.offset) = frame.delta.tail<9>();
    } else {
      delta.segment<6>(block.offset) = frame.delta.head<6>();
    }
  }
  return delta;
}

double AddPrior(const SlidingWindow& window, const StateLayout& layout, MatrixXd* H, VectorXd* b) {
  const MarginalPrior& prior = window.prior;
  if (prior.dim() == 0) return 0;
  const VectorXd delta = PriorDelta(window);
  const VectorXd H_delta = prior.H * delta;
  const double cost = delta.dot(0.5 * H_delta + prior.b);
  if (H == nullptr) return cost;
  const auto column = [&](const MarginalPrior::Block& block) {
    if (block.IsPlane()) return layout.plane_column[window.IndexOf(block.plane)];
    const int frame = window.IndexOf(block.frame);
    return block.is_motion ? layout.motion_column[frame] : layout.pose_column[frame];
  };
  for (const MarginalPrior::Block& r : prior.blocks) {
    const int row = column(r), rows = r.size();
    b->segment(row, rows) += prior.b.segment(r.offset, rows) + H_delta.segment(r.offset, rows);
    for (const MarginalPrior::Block& c : prior.blocks) {
      const int cols = c.size();
      H->block(row, column(c), rows, cols) += prior.H.block(r.offset, c.offset, rows, cols);
    }
  }
  return cost;
}

double AddStartPrior(const SlidingWindow& window,
                     const StateLayout& layout,
                     MatrixXd* H,
                     VectorXd* b) {
  const StartPrior& prior = window.start_prior;
  if (!prior.active) return 0;
  const int index = window.IndexOf(prior.frame);
  FACET_CHECK(index >= 0 && window.frames[index].has_motion) << "start prior without its frame";
  const NavState& x = window.frames[index].x;

  // Rows: position, heading, velocity, gyro bias, accelerometer bias; tilt is free.
  Vector<13> r;
  r.head<3>() = (x.T_WB.p - prior.T_WB.p) / prior.sigma_position;
  const Vector3d rotation_W = LogSO3(x.T_WB.q * prior.T_WB.q.conjugate());
  r(3) = rotation_W.z() / prior.sigma_yaw;
  r.segment<3>(4) = x.v_WB / prior.sigma_velocity;
  r.segment<3>(7) = x.bias.b_g / prior.sigma_gyro_bias;
  r.segment<3>(10) = x.bias.b_a / prior.sigma_accel_bias;
  if (H == nullptr) return 0.5 * r.squaredNorm();

  Matrix<13, 15> J = Matrix<13, 15>::Zero();
  J.block<3, 3>(0, 3) = Matrix3d::Identity() / prior.sigma_position;
  // Log(R Exp(theta) R0^T) ~ Log(R R0^T) + Jl^-1 R theta, and Jl^-1(w) = Jr^-1(-w).
  J.block<1, 3>(3, 0) =
      (RightJacobianInverseSO3(-rotation_W) * x.T_WB.R()).row(2) / prior.sigma_yaw;
  J.block<3, 3>(4, 6) = Matrix3d::Identity() / prior.sigma_velocity;
  J.block<3, 3>(7, 9) = Matrix3d::Identity() / prior.sigma_gyro_bias;
  J.block<3, 3>(10, 12) = Matrix3d::Identity() / prior.sigma_accel_bias;
  AddFactor(J, r, {{layout.pose_column[index], 6, 0}, {layout.motion_column[index], 9, 6}}, *H, *b);
  return 0.5 * r.squaredNorm();
}

double AddImuLink(
    const SlidingWindow& window, const StateLayout& layout, int j, MatrixXd* H, VectorXd* b) {
  const WindowFrame& frame_j = window.frames[j];
  const WindowFrame& frame_i = window.frames[j - 1];
  const Vector<15> r = frame_j.imu_sqrt_info * ImuError(frame_j.imu, frame_i.x, frame_j.x);
  const double cost = 0.5 * r.squaredNorm();
  if (H == nullptr) return cost;
  const ImuResidual linear = LinearizeImu(frame_j.imu, frame_i.lin, frame_j.lin);
  Matrix<15, 30> J;
  J.leftCols<15>() = frame_j.imu_sqrt_info * linear.J_i;
  J.rightCols<15>() = frame_j.imu_sqrt_info * linear.J_j;
  AddFactor(J,
            r,
            {{layout.pose_column[j - 1], 6, 0},
             {layout.motion_column[j - 1], 9, 6},
             {layout.pose_column[j], 6, 15},
             {layout.motion_column[j], 9, 21}},
            *H,
            *b);
  return cost;
}

double AddPlaneRelation(const SlidingWindow& window,
                        const StateLayout& layout,
                        const WindowRelation& relation,
                        const RelationNoise& noise,
                        MatrixXd* H,
                        VectorXd* b) {
  if (H == nullptr)
    return HuberLoss(RelationError(window, relation, noise).norm(), noise.huber_sigma).cost;
  const RelationRows rows = LinearizeRelation(window, relation, noise);
  const PlaneRelation& planes = relation.relation;
  // Fixed sizes: there are many relations, and AddFactor allocates.
  const auto add_square = [&](int column, const auto& J) {
    constexpr int kSize = std::decay_t<decltype(J)>::ColsAtCompileTime;
    H->block<kSize, kSize>(column, column) += J.transpose() * J;
    b->segment<kSize>(column) += J.transpose() * rows.r;
  };
  const auto add_product = [&](int row, const auto& J, int column, const auto& K) {
    constexpr int kRows = std::decay_t<decltype(J)>::ColsAtCompileTime;
    constexpr int kColumns = std::decay_t<decltype(K)>::ColsAtCompileTime;
    const Matrix<kRows, kColumns> product = J.transpose() * K;
    H->block<kRows, kColumns>(row, column) += product;
    H->block<kColumns, kRows>(column, row) += product.transpose();
  };
  const int column_a = layout.plane_column[window.IndexOf(planes.a)];
  const int column_b = planes.IsUnary() ? -1 : layout.plane_column[window.IndexOf(planes.b)];
  add_square(column_a, rows.J_a);
  if (column_b >= 0) {
    add_square(column_b, rows.J_b);
    add_product(column_a, rows.J_a, column_b, rows.J_b);
  }
  if (!NeedsFrame(planes.kind)) return rows.cost;
  const int column_f = layout.pose_column[window.IndexOf(relation.frame)];
  add_square(column_f, rows.J_frame);
  add_product(column_a, rows.J_a, column_f, rows.J_frame);
  if (column_b >= 0) add_product(column_b, rows.J_b, column_f, rows.J_frame);
  return rows.cost;
}

double AddPlaneSighting(const SlidingWindow& window,
                        const StateLayout& layout,
                        const PlaneSighting& sighting,
                        double huber_sigma,
                        MatrixXd* H,
                        VectorXd* b) {
  const int index = window.IndexOf(sighting.plane), frame = window.IndexOf(sighting.frame);
  const WindowPlane& plane = window.planes[index];
  if (H == nullptr) {
    return HuberLoss(SightingError(sighting, plane, window.frames[frame]).norm(), huber_sigma).cost;
  }
  const SightingRows rows = LinearizeSighting(sighting, plane, window.frames[frame], huber_sigma);
  const int column = layout.plane_column[index], pose = layout.pose_column[frame];
  const Matrix<6, 3> product = rows.J_pose.transpose() * rows.J_plane;
  H->block<3, 3>(column, column) += rows.J_plane.transpose() * rows.J_plane;
  H->block<6, 6>(pose, pose) += rows.J_pose.transpose() * rows.J_pose;
  H->block<6, 3>(pose, column) += product;
  H->block<3, 6>(column, pose) += product.transpose();
  b->segment<3>(column) += rows.J_plane.transpose() * rows.r;
  b->segment<6>(pose) += rows.J_pose.transpose() * rows.r;
  return rows.cost;
}

bool IsConstraining(const WindowLandmark& landmark) {
  return landmark.has_depth && (landmark.observations.size() >= 2 ||
                                (landmark.IsOnPlanes() && !landmark.observations.empty()));
}

void AddDiagonal(const LandmarkBlock& block, const StateLayout& layout, MatrixXd& H, VectorXd& b) {
  for (int v = 0; v < block.num_views; ++v) {
    const int column = layout.pose_column[block.views[v].frame];
    H.block<6, 6>(column, column) += block.views[v].H;
    b.segment<6>(column) += block.views[v].b;
  }
  for (int k = 0; k < block.num_plane_views; ++k) {
    const LandmarkBlock::PlaneView& view = block.plane_views[static_cast<std::size_t>(k)];
    const int column = layout.plane_column[view.plane];
    H.block<3, 3>(column, column) += view.J_plane * view.J_plane.transpose();
    b.segment<3>(column) += view.J_plane * view.residual;
  }
}

void SubtractSchur(const LandmarkBlock& block,
                   const StateLayout& layout,
                   MatrixXd& H,
                   VectorXd& b) {
  for (int i = 0; i < block.num_views; ++i) {
    const LandmarkBlock::View& view_i = block.views[i];
    const int row = layout.pose_column[view_i.frame];
    b.segment<6>(row).noalias() -= view_i.Y * block.y;
    for (int j = 0; j <= i; ++j) {
      const LandmarkBlock::View& view_j = block.views[j];
      SubtractOuterProduct(view_i.Y.data(),
                           view_j.Y.data(),
                           &H(row, layout.pose_column[view_j.frame]),
                           H.outerStride());
    }
  }
  for (int p = 0; p < block.num_plane_views; ++p) {
    const LandmarkBlock::PlaneView& plane_p = block.plane_views[static_cast<std::size_t>(p)];
    const int column = layout.plane_column[plane_p.plane];
    b.segment<3>(column) -= plane_p.J_plane * plane_p.z.dot(block.y);
    // Planes come before poses, so these blocks are below the diagonal.
    for (int i = 0; i < block.num_views; ++i) {
      const Vector<6> Y_z = block.views[i].Y * plane_p.z;
      H.block<6, 3>(layout.pose_column[block.views[i].frame], column).noalias() -=
          Y_z * plane_p.J_plane.transpose();
    }
    for (int q = 0; q < block.num_plane_views; ++q) {
      const LandmarkBlock::PlaneView& plane_q = block.plane_views[static_cast<std::size_t>(q)];
      if (layout.plane_column[plane_q.plane] < column) continue;
      H.block<3, 3>(layout.plane_column[plane_q.plane], column).noalias() -=
          (plane_q.z.dot(plane_p.z) * plane_q.J_plane) * plane_p.J_plane.transpose();
    }
  }
}

void WindowSystem::LinearizeVision(const SlidingWindow& window, const RobustOptions& robust) {
  num_blocks_ = 0;
  const auto& landmarks = window.landmarks();
  if (blocks_.size() < landmarks.size()) blocks_.resize(landmarks.size());
  for (std::size_t l = 0; l < landmarks.size(); ++l) {
    if (!IsConstraining(landmarks[l])) continue;
    LandmarkBlock& block = blocks_[num_blocks_++];
    block.index = static_cast<int>(l);
    LinearizeLandmark(geometry_, window.planes, landmarks[l], robust, block);
    cost_ += block.cost;
    AddDiagonal(block, layout_, H_, b_);
  }
}

void WindowSystem::LinearizeSightings(const SlidingWindow& window, const RobustOptions& robust) {
  const auto on_diagonal = [&](std::size_t plane) {
    return H_.block<3, 3>(layout_.plane_column[plane], layout_.plane_column[plane]);
  };
  sighted_.resize(window.planes.size());
  for (std::size_t k = 0; k < sighted_.size(); ++k)
    sighted_[k] = -on_diagonal(k);
  for (const PlaneSighting& sighting : window.sightings)
    cost_ += AddPlaneSighting(window, layout_, sighting, robust.sighting_huber_sigma, &H_, &b_);
  for (std::size_t k = 0; k < sighted_.size(); ++k)
    sighted_[k] += on_diagonal(k);
}

void WindowSystem::Linearize(const SlidingWindow& window, const RobustOptions& robust) {
  layout_ = MakeLayout(window);
  geometry_.Update(window.frames);
  H_.setZero(layout_.dim, layout_.dim);
  b_.setZero(layout_.dim);
  cost_ = AddPrior(window, layout_, &H_, &b_);
  cost_ += AddStartPrior(window, layout_, &H_, &b_);
  for (int j = 1; j < static_cast<int>(window.frames.size()); ++j) {
    if (window.frames[j].has_imu_link) cost_ += AddImuLink(window, layout_, j, &H_, &b_);
  }
  for (const WindowRelation& relation : window.relations)
    cost_ += AddPlaneRelation(window, layout_, relation, robust.relations, &H_, &b_);
  LinearizeSightings(window, robust);
  LinearizeVision(window, robust);
}

double WindowSystem::NewestError(const SlidingWindow& window) {
  geometry_.Update(window.frames);
  const int newest = static_cast<int>(window.frames.size()) - 1;
  errors_.clear();
  for (const WindowLandmark& landmark : window.landmarks()) {
    // With a single observation the point lies where that says; pipeline SP's have another loss.
    if (!IsConstraining(landmark) || landmark.observations.size() < 2 || landmark.is_projection)
      continue;
    const WindowObservation& o = landmark.observations.back();
    if (o.frame != newest) continue;
    if (const auto error = WhitenedError(geometry_, landmark, o, 0))
      errors_.push_back(error->norm());
  }
  return Median(errors_).value_or(0.0);
}

double WindowSystem::Cost(const SlidingWindow& window, const RobustOptions& robust) {
  geometry_.Update(window.frames);
  double cost = AddPrior(window, layout_, nullptr, nullptr);
  cost += AddStartPrior(window, layout_, nullptr, nullptr);
  for (int j = 1; j < static_cast<int>(window.frames.size()); ++j) {
    if (window.frames[j].has_imu_link) cost += AddImuLink(window, layout_, j, nullptr, nullptr);
  }
  for (const WindowRelation& relation : window.relations)
    cost += AddPlaneRelation(window, layout_, relation, robust.relations, nullptr, nullptr);
  for (const PlaneSighting& sighting : window.sightings) {
    cost +=
        AddPlaneSighting(window, layout_, sighting, robust.sighting_huber_sigma, nullptr, nullptr);
  }
  for (const WindowLandmark& landmark : window.landmarks()) {
    if (IsConstraining(landmark)) cost += LandmarkCost(geometry_, window.planes, landmark, robust);
  }
  return cost;
}

bool WindowSystem::Solve(const SlidingWindow& window, double lambda) {
  reduced_H_.resize(layout_.dim, layout_.dim);
  reduced_H_.triangularView<Eigen::Lower>() = H_;
  reduced_b_ = b_;
  // The constant keeps a frame without any measurement (dark, during the start) where it is.
  reduced_H_.diagonal().array() += lambda * (H_.diagonal().array() + 1.0);
  for (int k = 0; k < num_blocks_; ++k) {
    Eliminate(lambda, blocks_[k]);
    SubtractSchur(blocks_[k], layout_, reduced_H_, reduced_b_);
  }
  if (!motions_.Eliminate(window, layout_, reduced_H_, reduced_b_)) return false;
  Eigen::Ref<MatrixXd> dense = reduced_H_.topLeftCorner(layout_.dense_dim, layout_.dense_dim);
  if (Eigen::LLT<Eigen::Ref<MatrixXd>>(dense).info() != Eigen::Success) return false;
  step_.setZero(layout_.dim);
  auto dense_step = step_.head(layout_.dense_dim);
  dense_step = -reduced_b_.head(layout_.dense_dim);
  Factor().triangularView<Eigen::Lower>().solveInPlace(dense_step);
  Factor().transpose().triangularView<Eigen::Upper>().solveInPlace(dense_step);
  motions_.BackSubstitute(step_);
  return step_.allFinite();
}

void WindowSystem::ApplyStep(SlidingWindow& window) {
  // Landmark steps are steps in the world, relative to where the host was when it was linearised.
  struct HostPose {
    SE3 T_WC0;
  };
  std::vector<HostPose> old_hosts(window.frames.size());
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    old_hosts[i].T_WC0 = window.frames[i].x.T_WB * window.T_BC0;
  }
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    Vector<15> frame_step = Vector<15>::Zero();
    frame_step.head<6>() = step_.segment<6>(layout_.pose_column[i]);
    if (layout_.motion_column[i] >= 0)
      frame_step.tail<9>() = step_.segment<9>(layout_.motion_column[i]);
    window.frames[i].ApplyStep(frame_step);
  }
  for (std::size_t k = 0; k < window.planes.size(); ++k)
    window.planes[k].ApplyStep(step_.segment<3>(layout_.plane_column[k]));
  for (int k = 0; k < num_blocks_; ++k) {
    const LandmarkBlock& block = blocks_[k];
    Vector3d rhs = block.y;
    for (int v = 0; v < block.num_views; ++v) {
      rhs += block.views[v].Y.transpose() *
             step_.segment<6>(layout_.pose_column[block.views[v].frame]);
    }
    for (int p = 0; p < block.num_plane_views; ++p) {
      const LandmarkBlock::PlaneView& view = block.plane_views[static_cast<std::size_t>(p)];
      rhs += view.z * view.J_plane.dot(step_.segment<3>(layout_.plane_column[view.plane]));
    }
    const Vector3d d = -block.L.transpose().triangularView<Eigen::Upper>().solve(rhs);

    WindowLandmark& landmark = window.landmarks()[block.index];
    const SE3& old_host = old_hosts[landmark.host].T_WC0;
    const SE3 new_host = window.frames[landmark.host].x.T_WB * window.T_BC0;
    const double rho = std::clamp(landmark.inverse_distance + d.z(), 0.0, 20.0);
    const Vector3d bearing = landmark.bearing_H + TangentBasis(landmark.bearing_H) * d.head<2>();
    const Vector3d y_W = old_host.q * bearing + rho * (old_host.p - new_host.p);
    const double norm = y_W.norm();
    landmark.bearing_H = new_host.q.conjugate() * (y_W / norm);
    landmark.inverse_distance = rho / norm;
  }
}

std::vector<Matrix3d> WindowSystem::PlaneInformation() const {
  std::vector<Matrix3d> information = sighted_;
  for (int k = 0; k < num_blocks_; ++k) {
    for (int p = 0; p < blocks_[k].num_plane_views; ++p) {
      const LandmarkBlock::PlaneView& view = blocks_[k].plane_views[static_cast<std::size_t>(p)];
      information[static_cast<std::size_t>(view.plane)] +=
          (1 - view.z.squaredNorm()) * view.J_plane * view.J_plane.transpose();
    }
  }
  return information;
}

std::vector<Matrix<9, 9>> WindowSystem::PlaneCovariances() const {
  const int num_planes = static_cast<int>(layout_.plane_column.size());
  std::vector<Matrix<9, 9>> out(static_cast<std::size_t>(num_planes));
  if (num_planes == 0) return out;
  // Sigma = L^-T L^-1, so the columns of L^-1 that belong to pose and planes are enough.
  const int pose = 3 * num_planes;
  MatrixXd columns = MatrixXd::Zero(layout_.dense_dim, pose + 6);
  for (int k = 0; k < num_planes; ++k)
    columns.block<3, 3>(layout_.plane_column[k], 3 * k).setIdentity();
  columns.block<6, 6>(layout_.pose_column.back(), pose).setIdentity();
  Factor().triangularView<Eigen::Lower>().solveInPlace(columns);
  Eigen::Matrix<double, Eigen::Dynamic, 9> both(layout_.dense_dim, 9);
  both.leftCols<6>() = columns.rightCols<6>();
  for (int k = 0; k < num_planes; ++k) {
    both.rightCols<3>() = columns.middleCols<3>(3 * k);
    out[static_cast<std::size_t>(k)].noalias() = both.transpose() * both;
  }
  return out;
}

Matrix<15, 15> WindowSystem::NewestFrameCovariance() const {
  // The newest frame's pose and motion are the last columns of the dense part, so the last block of
  // its Cholesky factor alone says it: Sigma = L^-T L^-1.
  const int pose = layout_.pose_column.back(), motion = layout_.motion_column.back();
  FACET_CHECK(motion == pose + 6 && layout_.dense_dim == pose + 15) << "newest frame is not last";
  Matrix<15, 15> inverse_L = Matrix<15, 15>::Identity();
  const Matrix<15, 15> L = reduced_H_.block<15, 15>(pose, pose);
  L.triangularView<Eigen::Lower>().solveInPlace(inverse_L);
  return inverse_L.transpose() * inverse_L;
}

}  // namespace facet
