// SPDX-License-Identifier: BSD-2-Clause
// The sum of all factors: each adds J^T J to H and J^T r to b, in the columns of its variables.
#pragma once

#include <initializer_list>

#include "facet/estimator/window/state_layout.h"

namespace facet {

/// Gauss-Newton system H dx = -b of frames and planes. Reuse one object: it keeps its storage. Not
/// thread-safe.
struct NormalEquations {
  StateLayout layout;  ///< without columns for a calibration that is held
  MatrixXd H;
  VectorXd b;

  void Clear(const SlidingWindow& window,
             CalibrationStep calibration_step = CalibrationStep::kFree) {
    layout = MakeLayout(window, calibration_step);
    H.setZero(layout.dim, layout.dim);
    b.setZero(layout.dim);
  }

  /// Rows with residual r; the columns of J belong to the variables, in this order.
  template <class Jacobian, class Residual>
  void AddRows(std::initializer_list<Variable> variables, const Jacobian& J, const Residual& r) {
    const MatrixXd JtJ = J.transpose() * J;
    const VectorXd Jtr = J.transpose() * r;
    AddSquares(variables, JtJ, Jtr);
  }

  /// The same, squared already: J^T J and J^T r.
  template <class Square, class Gradient>
  void AddSquares(std::initializer_list<Variable> variables,
                  const Square& JtJ,
                  const Gradient& Jtr) {
    int row = 0;
    for (const Variable& v : variables) {
      const int size = SizeOf(v.kind);
      b.segment(layout.ColumnOf(v), size) += Jtr.segment(row, size);
      int column = 0;
      for (const Variable& w : variables) {
        const int width = SizeOf(w.kind);
        H.block(layout.ColumnOf(v), layout.ColumnOf(w), size, width) +=
            JtJ.block(row, column, size, width);
        column += width;
      }
      row += size;
    }
  }

  /// Besides the rows of AddRows: their columns `J` of the calibration, from its column `first` on.
  template <class CalibrationJacobian, class Residual, class Jacobian>
  void AddCalibrationColumns(int first,
                             const CalibrationJacobian& J,
                             const Residual& r,
                             std::initializer_list<Variable> variables,
                             const Jacobian& J_variables) {
    constexpr int kSize = CalibrationJacobian::ColsAtCompileTime;
    const int column = layout.calibration_column + first;
    H.block<kSize, kSize>(column, column) += J.transpose() * J;
    b.segment<kSize>(column) += J.transpose() * r;
    const Matrix<Jacobian::ColsAtCompileTime, kSize> product = J_variables.transpose() * J;
    int row = 0;
    for (const Variable& v : variables) {
      const int size = SizeOf(v.kind);
      H.block(layout.ColumnOf(v), column, size, kSize) += product.middleRows(row, size);
      H.block(column, layout.ColumnOf(v), kSize, size) += product.middleRows(row, size).transpose();
      row += size;
    }
  }

  /// The same as AddRows in parts of fixed size, for factors of which there are many: these
  /// allocate nothing, and few rows make Eigen's lazy products the faster ones. First each
  /// variable's own columns, then the products of two variables.
  template <class Jacobian, class Residual>
  void AddSquare(Variable variable, const Jacobian& J, const Residual& r) {
    constexpr int kSize = Jacobian::ColsAtCompileTime;
    const int column = layout.ColumnOf(variable);
    H.block<kSize, kSize>(column, column) += J.transpose().lazyProduct(J);
    b.segment<kSize>(column) += J.transpose() * r;
  }
  template <class FirstJacobian, class SecondJacobian>
  void AddProduct(Variable first,
                  const FirstJacobian& J,
                  Variable second,
                  const SecondJacobian& K) {
    constexpr int kRows = FirstJacobian::ColsAtCompileTime;
    constexpr int kColumns = SecondJacobian::ColsAtCompileTime;
    const int row = layout.ColumnOf(first), column = layout.ColumnOf(second);
    const Matrix<kRows, kColumns> product = J.transpose().lazyProduct(K);
    H.block<kRows, kColumns>(row, column) += product;
    H.block<kColumns, kRows>(column, row) += product.transpose();
  }
};

}  // namespace facet
