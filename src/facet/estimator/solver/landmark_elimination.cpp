// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/solver/landmark_elimination.h"

#include <cmath>
#include <span>

#include "facet/base/check.h"
#include "facet/estimator/factors/vision_kernels.h"

namespace facet {

namespace {

// Less information than this on a direction of a landmark (1-sigma of 30 rad or 30/m) counts as
// none.
constexpr double kMinInformation = 1e-3;
constexpr double kNoInformationPivot = 1e100;

std::span<const LandmarkBlock::View> ViewsOf(const LandmarkBlock& block) {
  return {block.views.data(), static_cast<std::size_t>(block.num_views)};
}

std::span<const LandmarkBlock::PlaneView> PlaneViewsOf(const LandmarkBlock& block) {
  return {block.plane_views.data(), static_cast<std::size_t>(block.num_plane_views)};
}

// Cholesky by hand: a direction without information (no parallax, no view at all) gets an infinite
// pivot, which leaves it where it is. A ridge instead would pretend to know it and leak into the
// prior.
Matrix3d Factorize(const Matrix3d& V) {
  Matrix3d L = Matrix3d::Zero();
  for (int c = 0; c < 3; ++c) {
    const double pivot = V(c, c) - L.row(c).head(c).squaredNorm();
    L(c, c) = pivot > kMinInformation ? std::sqrt(pivot) : kNoInformationPivot;
    for (int r = c + 1; r < 3; ++r) {
      L(r, c) = (V(r, c) - L.row(r).head(c).dot(L.row(c).head(c))) / L(c, c);
    }
  }
  return L;
}

// Y L^T = W, column by column.
template <int kRows>
void SolveFromRight(const Matrix3d& L,
                    const Vector3d& inverse_diagonal,
                    const Matrix<kRows, 3>& W,
                    Matrix<kRows, 3>& Y) {
  Y.col(0) = inverse_diagonal(0) * W.col(0);
  Y.col(1) = inverse_diagonal(1) * (W.col(1) - L(1, 0) * Y.col(0));
  Y.col(2) = inverse_diagonal(2) * (W.col(2) - L(2, 0) * Y.col(0) - L(2, 1) * Y.col(1));
}

void SubtractPlane(const LandmarkBlock& block,
                   const LandmarkBlock::PlaneView& plane,
                   const StateLayout& layout,
                   MatrixXd& H,
                   VectorXd& b) {
  const int column = layout.plane_column[plane.plane];
  b.segment<3>(column) -= plane.J_plane * plane.z.dot(block.y);
  // Planes come before poses, so these blocks are below the diagonal.
  for (const LandmarkBlock::View& view : ViewsOf(block)) {
    const Vector<6> Y_z = view.Y * plane.z;
    H.block<6, 3>(layout.pose_column[view.frame], column).noalias() -=
        Y_z * plane.J_plane.transpose();
  }
  for (const LandmarkBlock::PlaneView& other : PlaneViewsOf(block)) {
    const int row = layout.plane_column[other.plane];
    if (row < column) continue;
    H.block<3, 3>(row, column).noalias() -=
        (other.z.dot(plane.z) * other.J_plane) * plane.J_plane.transpose();
  }
}

void SubtractLens(const LandmarkBlock& block,
                  const LandmarkBlock::LensColumns& lens,
                  const StateLayout& layout,
                  MatrixXd& H,
                  VectorXd& b) {
  const int column = layout.calibration_column;
  b.segment<kNumLensColumns>(column) -= lens.Y.lazyProduct(block.y);
  const LensKernels& kernels = BestKernels().lens(lens.has_modes);
  kernels.subtract_square(lens.Y.data(), &H(column, column), H.outerStride());
  for (const LandmarkBlock::View& view : ViewsOf(block)) {
    kernels.subtract_pose(
        view.Y.data(), lens.Y.data(), &H(layout.pose_column[view.frame], column), H.outerStride());
  }
  for (const LandmarkBlock::PlaneView& plane : PlaneViewsOf(block)) {
    H.block<kNumLensColumns, 3>(column, layout.plane_column[plane.plane]).noalias() -=
        (lens.Y * plane.z) * plane.J_plane.transpose();
  }
}

}  // namespace

void AddDiagonal(const LandmarkBlock& block, const StateLayout& layout, MatrixXd& H, VectorXd& b) {
  FACET_CHECK(std::ssize(block.pose_squares) >= block.num_views) << "they are lent to others";
  for (int v = 0; v < block.num_views; ++v) {
    const int column = layout.pose_column[block.views[v].frame];
    H.block<6, 6>(column, column) += block.pose_squares[v].H;
    b.segment<6>(column) += block.pose_squares[v].b;
  }
  for (const LandmarkBlock::PlaneView& view : PlaneViewsOf(block)) {
    const int column = layout.plane_column[view.plane];
    H.block<3, 3>(column, column) += view.J_plane * view.J_plane.transpose();
    b.segment<3>(column) += view.J_plane * view.residual;
  }
}

void Eliminate(double lambda, LandmarkBlock& block) {
  Matrix3d V = block.V;
  V.diagonal() += lambda * V.diagonal();
  block.L = Factorize(V);
  const Matrix3d& L = block.L;
  block.y = L.triangularView<Eigen::Lower>().solve(block.b);
  const Vector3d inv = L.diagonal().cwiseInverse();
  for (int v = 0; v < block.num_views; ++v)
    SolveFromRight(L, inv, block.views[v].W, block.views[v].Y);
  for (LandmarkBlock::LensColumns& lens : block.lens)
    SolveFromRight(L, inv, lens.W, lens.Y);
  for (int k = 0; k < block.num_plane_views; ++k) {
    LandmarkBlock::PlaneView& view = block.plane_views[static_cast<std::size_t>(k)];
    view.z = L.triangularView<Eigen::Lower>().solve(view.J_landmark);
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
      BestKernels().subtract_poses(view_i.Y.data(),
                                   view_j.Y.data(),
                                   &H(row, layout.pose_column[view_j.frame]),
                                   H.outerStride());
    }
  }
  for (const LandmarkBlock::PlaneView& plane : PlaneViewsOf(block))
    SubtractPlane(block, plane, layout, H, b);
  for (const LandmarkBlock::LensColumns& lens : block.lens)
    SubtractLens(block, lens, layout, H, b);
}

Vector3d BackSubstitute(const LandmarkBlock& block,
                        const StateLayout& layout,
                        const VectorXd& step) {
  Vector3d rhs = block.y;
  for (const LandmarkBlock::View& view : ViewsOf(block))
    rhs += view.Y.transpose() * step.segment<6>(layout.pose_column[view.frame]);
  for (const LandmarkBlock::LensColumns& lens : block.lens)
    rhs += lens.Y.transpose() * step.segment<kNumLensColumns>(layout.calibration_column);
  for (const LandmarkBlock::PlaneView& view : PlaneViewsOf(block))
    rhs += view.z * view.J_plane.dot(step.segment<3>(layout.plane_column[view.plane]));
  return -block.L.transpose().triangularView<Eigen::Upper>().solve(rhs);
}

}  // namespace facet
