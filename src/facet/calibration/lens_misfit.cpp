// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/lens_misfit.h"

#include <Eigen/Eigenvalues>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr int kNumExplained = kNumIntrinsics + 3;

/// How the pixel moves with the intrinsic parameters and a turn of the camera.
std::optional<Matrix<2, kNumExplained>> ModelJacobian(const CameraModel& camera,
                                                      const Vector2d& px) {
  const auto bearing = camera.Unproject(px);
  if (!bearing) return std::nullopt;
  const Vector3d& p_C = *bearing;
  const auto projected = ProjectWithDerivatives(camera, p_C);
  if (!projected) return std::nullopt;
  Matrix<2, kNumExplained> J;
  J << projected->J_px_k, -projected->J_px_p * Hat(p_C);
  return J;
}

/// Calls f(px) for pixels all over the image.
template <class Function>
void OverImage(const CameraModel& camera, const Function& f) {
  constexpr int kColumns = 48, kRows = 32;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      f(Vector2d((camera.width() - 1) * (column + 0.5) / kColumns,
                 (camera.height() - 1) * (row + 0.5) / kRows));
    }
  }
}

}  // namespace

LensMisfit LensMisfit::Draw(const CameraModel& camera, double rms_px, std::uint64_t seed) {
  LensMisfit misfit(camera);
  Rng rng(seed);
  misfit.field_ = SmoothField::Draw(camera.width(), camera.height(), 1, rng);
  using Square = Matrix<kNumExplained, kNumExplained>;
  Square H = Square::Zero();
  Vector<kNumExplained> g = Vector<kNumExplained>::Zero();
  OverImage(camera, [&](const Vector2d& px) {
    const auto J = ModelJacobian(camera, px);
    if (!J) return;
    H += J->transpose() * *J;
    g += J->transpose() * misfit.field_.At(px);
  });
  // Some parameters do the same, or nothing: a turn about y and cx nearly.
  const Vector<kNumExplained> size = (H.diagonal().array() > 0).select(H.diagonal(), 1).cwiseSqrt();
  const Vector<kNumExplained> unit = size.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Square> solver(unit.asDiagonal() * H * unit.asDiagonal());
  constexpr double kDependent = 1e-10;
  const auto& lambda = solver.eigenvalues();
  const Vector<kNumExplained> inverse =
      (lambda.array() > kDependent).select(lambda.cwiseInverse(), 0);
  misfit.explained_ =
      unit.asDiagonal() *
      (solver.eigenvectors() *
       (inverse.asDiagonal() * (solver.eigenvectors().transpose() * (unit.asDiagonal() * g))));
  double squares = 0;
  int count = 0;
  OverImage(camera, [&](const Vector2d& px) {
    squares += misfit.At(px).squaredNorm();
    count += 2;
  });
  if (squares > 0) misfit.scale_ = rms_px / std::sqrt(squares / count);
  return misfit;
}

Vector2d LensMisfit::At(const Vector2d& px) const {
  const auto J = ModelJacobian(camera_, px);
  if (!J) return Vector2d::Zero();
  return scale_ * (field_.At(px) - *J * explained_);
}

Vector2d LensMisfit::Undo(const Vector2d& displaced_px) const {
  constexpr int kRounds = 3;  // the field changes by a thousandth of a pixel per pixel
  Vector2d px = displaced_px;
  for (int i = 0; i < kRounds; ++i)
    px = displaced_px - At(px);
  return px;
}

}  // namespace facet
