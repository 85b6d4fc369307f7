// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/board_calibration.h"

#include <Eigen/Cholesky>

#include "facet/calibration/intrinsics_jacobian.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

using RigRow = Matrix<2, kNumRigParameters>;
using PoseRow = Matrix<2, 6>;

/// Derivatives of one corner in one camera.
struct CornerRow {
  Vector2d px;
  RigRow J_rig = RigRow::Zero();
  PoseRow J_pose;  // by T_C0_board: rotation (perturbed on the right), translation
};

std::optional<CornerRow> LinearizeCorner(const StereoRig& rig,
                                         const SE3& T_C0_board,
                                         std::size_t camera,
                                         const Vector3d& p_board) {
  const SE3 T_C1C0 = rig.T_C1C0();
  const Vector3d p_C0 = T_C0_board * p_board;
  const Vector3d p_C = camera == 0 ? p_C0 : T_C1C0 * p_C0;
  const auto projected = ProjectWithDerivatives(rig.cameras[camera], p_C);
  if (!projected) return std::nullopt;
  CornerRow row;
  row.px = projected->px;
  row.J_rig.middleCols<kNumIntrinsics>(static_cast<Eigen::Index>(camera) * kNumIntrinsics) =
      projected->J_px_k;
  Matrix<2, 3> J_px_pC0 = projected->J_px_p;
  if (camera == 1) {
    J_px_pC0 = projected->J_px_p * T_C1C0.R();
    row.J_rig.middleCols<3>(kStereoRotation) = -J_px_pC0 * Hat(p_C0);
    row.J_rig.middleCols<3>(kStereoTranslation) = projected->J_px_p;
  }
  row.J_pose << -J_px_pC0 * T_C0_board.R() * Hat(p_board), J_px_pC0;
  return row;
}

/// Normal equations of one view. Each column of `right` and `right_pose` belongs to one error that
/// the corners may have: what that error adds to J' e.
struct ViewSums {
  explicit ViewSums(int num_errors)
      : right(MatrixXd::Zero(kNumRigParameters, num_errors)),
        right_pose(MatrixXd::Zero(6, num_errors)) {}

  /// A corner of `camera`, and its errors: the columns from `first_error` on.
  template <typename Errors>
  void Add(std::size_t camera,
           const CornerRow& row,
           const Errors& errors,
           Eigen::Index first_error) {
    if (camera == 0) {
      AddRow<0, kNumIntrinsics>(row, errors, first_error);
    } else {
      AddRow<kNumIntrinsics, kNumRigParameters - kNumIntrinsics>(row, errors, first_error);
    }
  }

  /// Only kCount parameters from kFirst on move the corner.
  template <int kFirst, int kCount, typename Errors>
  void AddRow(const CornerRow& row, const Errors& errors, Eigen::Index first_error) {
    const Matrix<2, kCount> J = row.J_rig.middleCols<kCount>(kFirst);
    H.block<kCount, kCount>(kFirst, kFirst).noalias() += J.transpose() * J;
    H_cross.middleRows<kCount>(kFirst).noalias() += J.transpose() * row.J_pose;
    H_pose.noalias() += row.J_pose.transpose() * row.J_pose;
    constexpr int kNumErrors = Errors::ColsAtCompileTime;
    right.block<kCount, kNumErrors>(kFirst, first_error).noalias() += J.transpose() * errors;
    right_pose.middleCols<kNumErrors>(first_error).noalias() += row.J_pose.transpose() * errors;
  }

  RigMatrix H = RigMatrix::Zero();
  Matrix<kNumRigParameters, 6> H_cross = Matrix<kNumRigParameters, 6>::Zero();
  Matrix<6, 6> H_pose = Matrix<6, 6>::Zero();
  MatrixXd right, right_pose;
};

/// Normal equations of the rig alone: the poses of the board are eliminated.
struct RigSums {
  explicit RigSums(int num_errors) : right(MatrixXd::Zero(kNumRigParameters, num_errors)) {}

  void Add(const ViewSums& view) {
    const Matrix<kNumRigParameters, 6> K =
        view.H_pose.ldlt().solve(view.H_cross.transpose()).transpose();
    H += view.H - K * view.H_cross.transpose();
    right += view.right - K * view.right_pose;
  }

  /// H with unit diagonal where no corner depends on a parameter: coefficients that the lens model
  /// does not have. They keep their value.
  RigMatrix WithUnseenHeld() const {
    RigMatrix held = H;
    for (int i = 0; i < kNumRigParameters; ++i) {
      if (H(i, i) == 0) held(i, i) = 1;
    }
    return held;
  }

  MatrixXd Solve() const { return WithUnseenHeld().ldlt().solve(right); }

  RigMatrix InverseOfSeen() const {
    RigMatrix inverse = WithUnseenHeld().ldlt().solve(RigMatrix::Identity());
    for (int i = 0; i < kNumRigParameters; ++i) {
      if (H(i, i) == 0) inverse(i, i) = 0;
    }
    return 0.5 * (inverse + inverse.transpose());
  }

  RigMatrix H = RigMatrix::Zero();
  MatrixXd right;
};

/// The normal equations of a view for the errors measured - predicted; empty if a corner leaves the
/// field of view.
std::optional<ViewSums> SumResiduals(const StereoRig& rig,
                                     const BoardView& view,
                                     const DetectedView& detected) {
  ViewSums sums(1);
  for (std::size_t c = 0; c < 2; ++c) {
    for (std::size_t i = 0; i < view.corners[c].size(); ++i) {
      const auto row = LinearizeCorner(rig, view.T_C0_board, c, view.corners[c][i]);
      if (!row) return std::nullopt;
      sums.Add(c, *row, Vector2d(detected.corners[c][i] - row->px), 0);
    }
  }
  return sums;
}

/// One step of Gauss-Newton. Returns the largest step of a parameter; empty where it fails.
std::optional<double> Improve(StereoRig& rig,
                              std::vector<BoardView>& views,
                              const std::vector<DetectedView>& detected) {
  std::vector<ViewSums> sums;
  RigSums total(1);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto view = SumResiduals(rig, views[i], detected[i]);
    if (!view) return std::nullopt;
    sums.push_back(*view);
    total.Add(*view);
  }
  const RigVector delta = total.Solve();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Vector<6> rest = sums[i].right_pose - sums[i].H_cross.transpose() * delta;
    const Vector<6> step = sums[i].H_pose.ldlt().solve(rest);
    SE3& T = views[i].T_C0_board;
    T = T.Retract(step.head<3>(), step.tail<3>());
  }
  const auto changed = ChangeParameters(rig, delta);
  if (!changed) return std::nullopt;
  rig = *changed;
  return delta.cwiseAbs().maxCoeff();
}

/// What the monomials of a camera's field, axis after axis, add to the pixel of a corner.
Matrix<2, 2 * kNumMonomials> FieldColumns(const CameraModel& camera, const Vector2d& px) {
  const auto m = SmoothField::Monomials(px, camera.width(), camera.height());
  Matrix<2, 2 * kNumMonomials> columns = Matrix<2, 2 * kNumMonomials>::Zero();
  for (int axis = 0; axis < 2; ++axis)
    columns.row(axis).segment<kNumMonomials>(axis * kNumMonomials) = m;
  return columns;
}

/// The normal equations for unit fields.
RigSums SumFields(const StereoRig& rig, const std::vector<BoardView>& views) {
  RigSums total(4 * kNumMonomials);
  for (const BoardView& view : views) {
    ViewSums sums(4 * kNumMonomials);
    for (std::size_t c = 0; c < 2; ++c) {
      const Eigen::Index first_error = 2 * kNumMonomials * static_cast<Eigen::Index>(c);
      for (const Vector3d& corner : view.corners[c]) {
        const auto row = LinearizeCorner(rig, view.T_C0_board, c, corner);
        if (row) sums.Add(c, *row, FieldColumns(rig.cameras[c], row->px), first_error);
      }
    }
    total.Add(sums);
  }
  return total;
}

}  // namespace

std::vector<DetectedView> DetectCorners(const StereoRig& exact,
                                        const std::vector<BoardView>& views,
                                        const BoardCalibrationOptions& options,
                                        Rng& rng) {
  const double misfit_px = options.misfit_share * options.corner_noise_px;
  const auto draw_field = [&](const CameraModel& camera) {
    return SmoothField::Draw(camera.width(), camera.height(), misfit_px, rng);
  };
  const SmoothField left = draw_field(exact.cameras[0]), right = draw_field(exact.cameras[1]);
  std::vector<DetectedView> detected(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t c = 0; c < 2; ++c) {
      const SE3 T_C_board = c == 0 ? views[i].T_C0_board : exact.T_C1C0() * views[i].T_C0_board;
      for (const Vector3d& corner : views[i].corners[c]) {
        // What a camera sees has a pixel; MakeUpBoardViews keeps nothing else.
        const Vector2d px = exact.cameras[c].Project(T_C_board * corner).value_or(Vector2d::Zero());
        const double x = rng.Normal(), y = rng.Normal();
        detected[i].corners[c].push_back(px + (c == 0 ? left : right).At(px) +
                                         options.corner_noise_px * Vector2d(x, y));
      }
    }
  }
  return detected;
}

std::optional<StereoRig> CalibrateWithBoard(const StereoRig& start,
                                            std::vector<BoardView> views,
                                            const std::vector<DetectedView>& detected) {
  constexpr int kMaxSteps = 20;
  constexpr double kConverged = 1e-7;  // of any parameter, in its unit
  StereoRig rig = start;
  for (int i = 0; i < kMaxSteps; ++i) {
    const auto moved = Improve(rig, views, detected);
    if (!moved) return std::nullopt;
    if (*moved < kConverged) return rig;
  }
  return rig;
}

std::optional<RigMatrix> BoardCalibrationCovariance(const StereoRig& rig,
                                                    const BoardCalibrationOptions& options) {
  constexpr std::uint64_t kViewSeed = 1;
  Rng rng(kViewSeed);
  const std::vector<BoardView> views = MakeUpBoardViews(rig, options.board, rng);
  if (views.empty()) return std::nullopt;
  const RigSums sums = SumFields(rig, views);
  const MatrixXd response = sums.Solve();  // of the parameters to unit fields
  const auto per_axis = SmoothField::Covariance();
  RigMatrix field_part = RigMatrix::Zero();
  for (Eigen::Index axis = 0; axis < 4; ++axis) {
    const Matrix<kNumRigParameters, kNumMonomials> G =
        response.middleCols<kNumMonomials>(axis * kNumMonomials);
    field_part += G * per_axis * G.transpose();
  }
  const double share = options.misfit_share;
  return RigMatrix(std::pow(options.corner_noise_px, 2) *
                   (sums.InverseOfSeen() + share * share * field_part));
}

}  // namespace facet
