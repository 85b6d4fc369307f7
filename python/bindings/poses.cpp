// SPDX-License-Identifier: BSD-2-Clause
#include "poses.h"

#include <Eigen/Geometry>

namespace facet::python {
namespace {

using RowMatrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

bool IsRigid(const RowMatrix4& T) {
  constexpr double kTolerance = 1e-3;
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const Eigen::RowVector4d last(0, 0, 0, 1);
  return T.allFinite() && (T.row(3) - last).norm() < kTolerance &&
         (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < kTolerance &&
         R.determinant() > 0;
}

}  // namespace

Doubles PoseMatrix(const api::Pose& pose) {
  const auto& [w, x, y, z] = pose.q;
  RowMatrix4 T = RowMatrix4::Identity();
  T.topLeftCorner<3, 3>() = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
  T.topRightCorner<3, 1>() = Eigen::Map<const Eigen::Vector3d>(pose.p.data());
  Doubles matrix({4, 4});
  std::copy_n(T.data(), 16, matrix.mutable_data());
  return matrix;
}

api::Pose PoseFromMatrix(const py::object& matrix, const char* name) {
  const Doubles rows = Rows(matrix, 4, 4, name);
  const RowMatrix4 T = Eigen::Map<const RowMatrix4>(rows.data());
  if (!IsRigid(T)) {
    throw py::value_error(std::string(name) +
                          ": not a rigid motion; the upper left 3 x 3 must be a rotation and the "
                          "last row 0 0 0 1");
  }
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(Eigen::Matrix3d(T.topLeftCorner<3, 3>())).normalized();
  return {{T(0, 3), T(1, 3), T(2, 3)}, {q.w(), q.x(), q.y(), q.z()}};
}

}  // namespace facet::python
