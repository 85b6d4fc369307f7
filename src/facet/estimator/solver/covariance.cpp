// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/covariance.h"

#include "facet/base/check.h"

namespace facet {

// The newest frame's pose and motion are the last columns of the dense part, so the last block of
// its Cholesky factor alone says it: Sigma = L^-T L^-1.
Matrix<15, 15> NewestFrameCovariance(const ReducedSystem& reduced, const StateLayout& layout) {
  const int pose = layout.pose_column.back(), motion = layout.motion_column.back();
  FACET_CHECK(motion == pose + 6 && layout.dense_dim == pose + 15) << "newest frame is not last";
  Matrix<15, 15> inverse_L = Matrix<15, 15>::Identity();
  const Matrix<15, 15> L = reduced.factor().block<15, 15>(pose, pose);
  L.triangularView<Eigen::Lower>().solveInPlace(inverse_L);
  return inverse_L.transpose() * inverse_L;
}

ClockCovariance NewestFrameWithClock(const ReducedSystem& reduced, const StateLayout& layout) {
  const int newest = layout.pose_column.back();
  VectorXd clock = VectorXd::Unit(layout.dense_dim, layout.calibration_column + kTimeOffset);
  reduced.factor().triangularView<Eigen::Lower>().solveInPlace(clock);
  Matrix<15, 15> inverse_L = Matrix<15, 15>::Identity();
  const Matrix<15, 15> L = reduced.factor().block<15, 15>(newest, newest);
  L.triangularView<Eigen::Lower>().solveInPlace(inverse_L);
  return {inverse_L.transpose() * clock.tail<15>(), clock.squaredNorm()};
}

CalibrationMatrix CalibrationCovariance(const ReducedSystem& reduced, const StateLayout& layout) {
  MatrixXd columns = MatrixXd::Zero(layout.dense_dim, kNumCalibration);
  columns.middleRows<kNumCalibration>(layout.calibration_column).setIdentity();
  reduced.factor().triangularView<Eigen::Lower>().solveInPlace(columns);
  return columns.transpose() * columns;
}

// Sigma = L^-T L^-1, so the columns of L^-1 that belong to pose and planes are enough.
std::vector<Matrix<9, 9>> PlaneCovariances(const ReducedSystem& reduced,
                                           const StateLayout& layout) {
  const int num_planes = static_cast<int>(layout.plane_column.size());
  std::vector<Matrix<9, 9>> out(static_cast<std::size_t>(num_planes));
  if (num_planes == 0) return out;
  const int pose = 3 * num_planes;
  MatrixXd columns = MatrixXd::Zero(layout.dense_dim, pose + 6);
  for (int k = 0; k < num_planes; ++k)
    columns.block<3, 3>(layout.plane_column[k], 3 * k).setIdentity();
  columns.block<6, 6>(layout.pose_column.back(), pose).setIdentity();
  reduced.factor().triangularView<Eigen::Lower>().solveInPlace(columns);
  Eigen::Matrix<double, Eigen::Dynamic, 9> both(layout.dense_dim, 9);
  both.leftCols<6>() = columns.rightCols<6>();
  for (int k = 0; k < num_planes; ++k) {
    both.rightCols<3>() = columns.middleCols<3>(3 * k);
    out[static_cast<std::size_t>(k)].noalias() = both.transpose() * both;
  }
  return out;
}

std::vector<Matrix3d> PlaneInformation(const LinearizedWindow& linear) {
  std::vector<Matrix3d> information = linear.measured;
  for (int k = 0; k < linear.num_landmarks; ++k) {
    const LandmarkBlock& block = linear.landmarks[k];
    for (int p = 0; p < block.num_plane_views; ++p) {
      const LandmarkBlock::PlaneView& view = block.plane_views[static_cast<std::size_t>(p)];
      information[static_cast<std::size_t>(view.plane)] +=
          (1 - view.z.squaredNorm()) * view.J_plane * view.J_plane.transpose();
    }
  }
  return information;
}

}  // namespace facet
