// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/factors/lens_kernel.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/estimator/solver/schur_kernel.h"

namespace facet {
namespace {

using LensMatrix = Matrix<kNumRigParameters, kNumRigParameters>;

template <class M>
void Fill(M& m, Rng& rng) {
  for (Eigen::Index k = 0; k < m.size(); ++k)
    m.data()[k] = rng.Normal();
}

double LowerError(const MatrixXd& a, const MatrixXd& b) {
  return MatrixXd((a - b).triangularView<Eigen::Lower>()).norm();
}

TEST(LensKernelTest, ProductsOfRowsAreThoseOfMatrices) {
  Rng rng(1);
  Matrix<2, 10> rows;
  Matrix<2, kNumRigParameters> lens;
  Fill(rows, rng);
  Fill(lens, rng);
  VisionRow vision_rows[2];
  LensRow lens_rows[2];
  for (int r = 0; r < 2; ++r) {
    Eigen::Map<Vector<10>>(vision_rows[r].pose) = rows.row(r);
    Eigen::Map<RigVector>(lens_rows[r].k) = lens.row(r);
  }
  const auto error = [&](int columns, auto add) {
    LensMatrix H;
    Matrix<kNumRigParameters, 6> pose;
    Matrix<kNumRigParameters, 3> landmark;
    RigVector b;
    Fill(H, rng);
    Fill(pose, rng);
    Fill(landmark, rng);
    Fill(b, rng);
    LensMatrix expected_H = H;
    MatrixXd expected(kNumRigParameters, 10);
    expected << pose, landmark, b;
    const auto used = lens.leftCols(columns);
    expected_H.topLeftCorner(columns, columns) += used.transpose() * used;
    expected.topRows(columns) += used.transpose() * rows;
    add({H.data(), pose.data(), landmark.data(), b.data()});
    MatrixXd sums(kNumRigParameters, 10);
    sums << pose, landmark, b;
    return LowerError(H, expected_H) + (sums - expected).norm();
  };
  EXPECT_LT(error(kNumRigParameters,
                  [&](const LensProducts& to) {
                    AddLensProducts<2, kNumRigParameters>(lens_rows, vision_rows, to);
                  }),
            1e-12);
  EXPECT_LT(error(kNumIntrinsics,
                  [&](const LensProducts& to) {
                    AddLensProducts<2, kNumIntrinsics>(lens_rows, vision_rows, to);
                  }),
            1e-12);
}

TEST(LensKernelTest, OuterProductsAreSubtractedInABlockOfAMatrix) {
  Rng rng(2);
  Matrix<6, 3> A;
  Matrix<kNumRigParameters, 3> B;
  Fill(A, rng);
  Fill(B, rng);
  MatrixXd H(37, 37);
  Fill(H, rng);
  MatrixXd expected = H;
  expected.block<6, kNumRigParameters>(30, 3) -= A * B.transpose();
  SubtractOuterProduct<kNumRigParameters>(A.data(), B.data(), &H(30, 3), H.outerStride());
  EXPECT_LT((H - expected).norm(), 1e-12);
  expected.block<kNumRigParameters, kNumRigParameters>(5, 5) -= B * B.transpose();
  SubtractSquare<kNumRigParameters>(B.data(), &H(5, 5), H.outerStride());
  EXPECT_LT(LowerError(H, expected), 1e-12);
}

}  // namespace
}  // namespace facet
