// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/vision_system.h"

namespace facet {

MountJacobians MountJacobiansOf(const SlidingWindow& window, const FrameGeometry& geometry) {
  MountJacobians mounts;
  mounts.reserve(window.frames.size());
  for (int i = 0; i <= window.newest_frame(); ++i)
    mounts.push_back(MountJacobian(geometry.frozen(i).R_BW.transpose(), window.frames[i].Rates()));
  return mounts;
}

void AddLensSums(const LensSums& sums, const StateLayout& layout, MatrixXd& H, VectorXd& b) {
  const int lens = layout.calibration_column;
  H.block<kNumLensColumns, kNumLensColumns>(lens, lens) += sums.H;
  b.segment<kNumLensColumns>(lens) += sums.b;
  for (std::size_t i = 0; i < sums.poses.size(); ++i)
    H.block<6, kNumLensColumns>(layout.pose_column[i], lens) += sums.poses[i].transpose();
}

// Equation (10.5): with A_i of each frame the columns are sums of A_i^T times the rows of its pose.
void FillMountColumns(const MountJacobians& mounts,
                      const StateLayout& layout,
                      MatrixXd& H,
                      VectorXd& b) {
  const int lens = layout.calibration_column, mount = lens + kNumLensColumns;
  const int first_pose = layout.pose_column.front();
  const int num_poses = 6 * static_cast<int>(mounts.size());
  Eigen::Matrix<double, Eigen::Dynamic, kNumMount> A(num_poses, kNumMount);
  for (std::size_t i = 0; i < mounts.size(); ++i)
    A.middleRows<6>(6 * static_cast<int>(i)) = mounts[i];
  const auto poses = H.block(first_pose, first_pose, num_poses, num_poses);
  const MatrixXd HA = poses.template selfadjointView<Eigen::Lower>() * A;
  H.block(first_pose, mount, num_poses, kNumMount) += HA;
  H.block<kNumMount, kNumMount>(mount, mount).noalias() += A.transpose() * HA;
  // Planes and lenses have smaller columns than the mount: these are rows of it.
  const int before = lens + kNumLensColumns;
  H.block(mount, 0, kNumMount, before).noalias() +=
      A.transpose() * H.block(first_pose, 0, num_poses, before);
  b.segment<kNumMount>(mount).noalias() += A.transpose() * b.segment(first_pose, num_poses);
}

VectorXd WithMountAsPoses(const MountJacobians& mounts,
                          const StateLayout& layout,
                          const VectorXd& step) {
  VectorXd moved = step;
  const Vector<kNumMount> mount =
      step.segment<kNumMount>(layout.calibration_column + kNumLensColumns);
  for (std::size_t i = 0; i < mounts.size(); ++i)
    moved.segment<6>(layout.pose_column[i]) += mounts[i] * mount;
  return moved;
}

}  // namespace facet
