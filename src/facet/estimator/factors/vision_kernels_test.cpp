// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/vision_kernels.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/base/types.h"

namespace facet {
namespace {

using LensMatrix = Matrix<kNumLensColumns, kNumLensColumns>;

template <class M>
void Fill(M& m, Rng& rng) {
  for (Eigen::Index k = 0; k < m.size(); ++k)
    m.data()[k] = rng.Normal();
}

double LowerError(const MatrixXd& a, const MatrixXd& b) {
  return MatrixXd((a - b).triangularView<Eigen::Lower>()).norm();
}

/// Two or four numbers at a time.
class VisionKernelsTest : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (GetParam() == 4 && QuadKernels() == nullptr)
      GTEST_SKIP() << "this processor does not do four numbers at a time";
    kernels_ = GetParam() == 4 ? *QuadKernels() : PairKernels();
  }

  VisionKernels kernels_{};
};

INSTANTIATE_TEST_SUITE_P(Lanes, VisionKernelsTest, ::testing::Values(2, 4));

TEST_P(VisionKernelsTest, SquaredRowsAreNormalEquations) {
  Rng rng(3);
  VisionRow rows[4];
  Matrix<4, 10> J;
  Fill(J, rng);
  for (int r = 0; r < 4; ++r)
    Eigen::Map<Vector<10>>(rows[r].pose) = J.row(r);
  for (const int num_rows : {2, 4}) {
    SquaredRows G;
    (num_rows == 2 ? kernels_.square_two_rows : kernels_.square_four_rows)(rows, G);
    const Matrix<10, 10> expected = J.topRows(num_rows).transpose() * J.topRows(num_rows);
    const auto is_near = [](const auto& a, const auto& b) { return (a - b).norm() < 1e-13; };
    EXPECT_TRUE(is_near(Eigen::Map<Matrix<6, 6>>(G.H), expected.topLeftCorner<6, 6>()));
    EXPECT_TRUE(is_near(Eigen::Map<Matrix<6, 3>>(G.W), expected.block<6, 3>(0, 6)));
    EXPECT_TRUE(is_near(Eigen::Map<Vector<6>>(G.b), expected.block<6, 1>(0, 9)));
    EXPECT_TRUE(is_near(Eigen::Map<Matrix<4, 3>>(G.V), expected.block<4, 3>(6, 6)));
  }
}

TEST_P(VisionKernelsTest, ProductsOfRowsAreThoseOfMatrices) {
  Rng rng(1);
  Matrix<2, 10> rows;
  Matrix<2, kNumLensColumns> lens;
  Fill(rows, rng);
  Fill(lens, rng);
  VisionRow vision_rows[2];
  LensRow lens_rows[2];
  for (int r = 0; r < 2; ++r) {
    Eigen::Map<Vector<10>>(vision_rows[r].pose) = rows.row(r);
    Eigen::Map<Vector<kNumLensColumns>>(lens_rows[r].k) = lens.row(r);
  }
  // Of a row that has only so many parameters and modes.
  const auto error = [&](int num_parameters, int num_modes, auto add_lens) {
    LensMatrix H;
    Matrix<kNumLensColumns, 6> pose;
    Matrix<kNumLensColumns, 3> landmark;
    Vector<kNumLensColumns> b;
    Fill(H, rng);
    Fill(pose, rng);
    Fill(landmark, rng);
    Fill(b, rng);
    LensMatrix expected_H = H;
    MatrixXd expected(kNumLensColumns, 10);
    expected << pose, landmark, b;
    Matrix<2, kNumLensColumns> used = Matrix<2, kNumLensColumns>::Zero();
    used.leftCols(num_parameters) = lens.leftCols(num_parameters);
    used.middleCols(kLensModes, num_modes) = lens.middleCols(kLensModes, num_modes);
    expected_H += used.transpose() * used;
    expected += used.transpose() * rows;
    add_lens(
        lens_rows, vision_rows, LensProducts{H.data(), pose.data(), landmark.data(), b.data()});
    MatrixXd sums(kNumLensColumns, 10);
    sums << pose, landmark, b;
    return LowerError(H, expected_H) + (sums - expected).norm();
  };
  EXPECT_LT(error(kNumRigParameters, 2 * kNumLensModes, kernels_.with_modes.add_right), 1e-12);
  EXPECT_LT(error(kNumIntrinsics, kNumLensModes, kernels_.with_modes.add_left), 1e-12);
  EXPECT_LT(error(kNumRigParameters, 0, kernels_.without_modes.add_right), 1e-12);
  EXPECT_LT(error(kNumIntrinsics, 0, kernels_.without_modes.add_left), 1e-12);
}

TEST_P(VisionKernelsTest, OuterProductsAreSubtractedInABlockOfAMatrix) {
  Rng rng(2);
  Matrix<6, 3> A, C;
  Matrix<kNumLensColumns, 3> B;
  Fill(A, rng);
  Fill(B, rng);
  Fill(C, rng);
  MatrixXd H(57, 57);
  Fill(H, rng);
  MatrixXd expected = H;
  expected.block<6, kNumLensColumns>(50, 3) -= A * B.transpose();
  kernels_.with_modes.subtract_pose(A.data(), B.data(), &H(50, 3), H.outerStride());
  expected.block<6, kLensModes>(44, 3) -= A * B.topRows<kLensModes>().transpose();
  kernels_.without_modes.subtract_pose(A.data(), B.data(), &H(44, 3), H.outerStride());
  expected.block<6, 6>(1, 48) -= A * C.transpose();
  kernels_.subtract_poses(A.data(), C.data(), &H(1, 48), H.outerStride());
  EXPECT_LT((H - expected).norm(), 1e-12);
  expected.block<kNumLensColumns, kNumLensColumns>(5, 5) -= B * B.transpose();
  kernels_.with_modes.subtract_square(B.data(), &H(5, 5), H.outerStride());
  expected.block<kLensModes, kLensModes>(2, 2) -=
      B.topRows<kLensModes>() * B.topRows<kLensModes>().transpose();
  kernels_.without_modes.subtract_square(B.data(), &H(2, 2), H.outerStride());
  EXPECT_LT(LowerError(H, expected), 1e-12);
}

TEST_P(VisionKernelsTest, AMotionIsEliminated) {
  Rng rng(5);
  for (const int rows : {1, 2, 3, 7, 8, 21, 40}) {
    Matrix<kEliminated, kEliminated> L;
    Fill(L, rng);
    L = MatrixXd(L.triangularView<Eigen::Lower>());
    L.diagonal() = L.diagonal().cwiseAbs().array() + 1;
    const Vector<kEliminated> inverse_diagonal = L.diagonal().cwiseInverse();
    Eigen::Matrix<double, Eigen::Dynamic, kEliminated> X(rows + 3, kEliminated);
    Fill(X, rng);
    const MatrixXd before = X;
    kernels_.solve_motion(L.data(), inverse_diagonal.data(), {&X(2, 0), X.outerStride(), rows});
    EXPECT_LT((X.middleRows(2, rows) * L.transpose() - before.middleRows(2, rows)).norm(), 1e-11);
    EXPECT_EQ(X.topRows(2), before.topRows(2));
    EXPECT_EQ(X.bottomRows(1), before.bottomRows(1));

    MatrixXd H(rows + 20, rows + 20);
    Fill(H, rng);
    MatrixXd expected = H;
    const NineColumns some{&X(2, 0), X.outerStride(), rows}, others{&X(0, 0), X.outerStride(), 2};
    kernels_.subtract_motion(some, others, &H(9, 3), H.outerStride());
    expected.block(9, 3, rows, 2) -= X.middleRows(2, rows) * X.topRows(2).transpose();
    EXPECT_LT((H - expected).norm(), 1e-11 * expected.norm());
    kernels_.subtract_motion(some, some, &H(6, 6), H.outerStride());
    expected.block(6, 6, rows, rows) -= X.middleRows(2, rows) * X.middleRows(2, rows).transpose();
    EXPECT_LT(LowerError(H, expected), 1e-11 * expected.norm());
  }
}

TEST(VisionKernelsBitsTest, FourAtATimeEliminateAMotionWithTheBitsOfTwo) {
  if (QuadKernels() == nullptr) GTEST_SKIP() << "this processor does not do four numbers at a time";
  Rng rng(6);
  Matrix<kEliminated, kEliminated> L;
  Fill(L, rng);
  const Vector<kEliminated> inverse_diagonal = L.diagonal().cwiseInverse();
  Matrix<23, kEliminated> start;
  Fill(start, rng);
  const auto all = [&](const VisionKernels& kernels) {
    Matrix<23, kEliminated> X = start;
    MatrixXd H = MatrixXd::Ones(23, 23);
    const NineColumns columns{X.data(), 23, 23};
    kernels.solve_motion(L.data(), inverse_diagonal.data(), columns);
    kernels.subtract_motion(columns, columns, H.data(), 23);
    H.triangularView<Eigen::StrictlyUpper>().setZero();
    VectorXd bits(X.size() + H.size());
    bits << X.reshaped(), H.reshaped();
    return bits;
  };
  EXPECT_EQ(all(PairKernels()), all(*QuadKernels()));
}

TEST(VisionKernelsBitsTest, FourAtATimeGiveTheBitsOfTwo) {
  if (QuadKernels() == nullptr) GTEST_SKIP() << "this processor does not do four numbers at a time";
  Rng rng(4);
  VisionRow rows[4];
  LensRow lens[2];
  for (VisionRow& row : rows) {
    Eigen::Map<Vector<10>> values(row.pose);
    Fill(values, rng);
  }
  for (LensRow& row : lens) {
    Eigen::Map<Vector<kNumLensColumns>> values(row.k);
    Fill(values, rng);
  }
  Matrix<kNumLensColumns, 3> B;
  Fill(B, rng);
  const auto all = [&](const VisionKernels& kernels) {
    SquaredRows G;
    kernels.square_four_rows(rows, G);
    LensMatrix H = LensMatrix::Ones();
    Matrix<kNumLensColumns, 10> sums = Matrix<kNumLensColumns, 10>::Ones();
    const LensProducts to{H.data(), sums.data(), &sums(0, 6), &sums(0, 9)};
    for (const bool has_modes : {true, false}) {
      kernels.lens(has_modes).add_left(lens, rows, to);
      kernels.lens(has_modes).add_right(lens, rows, to);
      kernels.lens(has_modes).subtract_square(B.data(), H.data(), H.outerStride());
    }
    H.triangularView<Eigen::StrictlyUpper>().setZero();
    VectorXd bits(72 + H.size() + sums.size());
    bits << Eigen::Map<Vector<36>>(G.H), Eigen::Map<Vector<18>>(G.W), Eigen::Map<Vector<6>>(G.b),
        Eigen::Map<Vector<12>>(G.V), H.reshaped(), sums.reshaped();
    return bits;
  };
  EXPECT_EQ(all(PairKernels()), all(*QuadKernels()));
}

}  // namespace
}  // namespace facet
