// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/board_views.h"

#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

using Tag = std::array<Vector3d, 4>;

std::vector<Tag> LayOutTags(const BoardOptions& board) {
  const double pitch_m = board.tag_m * (1 + board.gap);
  const double width_m = board.columns * pitch_m - board.tag_m * board.gap;
  const double height_m = board.rows * pitch_m - board.tag_m * board.gap;
  std::vector<Tag> tags;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const double x = column * pitch_m - 0.5 * width_m, y = row * pitch_m - 0.5 * height_m;
      const double s = board.tag_m;
      tags.push_back({Vector3d(x, y, 0),
                      Vector3d(x + s, y, 0),
                      Vector3d(x + s, y + s, 0),
                      Vector3d(x, y + s, 0)});
    }
  }
  return tags;
}

/// Corners of the tags of which a camera sees all four.
std::vector<Vector3d> CornersInView(const std::vector<Tag>& tags,
                                    const CameraModel& camera,
                                    const SE3& T_C_board) {
  constexpr double kBorder_px = 4;  // a detector needs some white around a tag
  std::vector<Vector3d> corners;
  for (const Tag& tag : tags) {
    bool is_inside = true;
    for (const Vector3d& corner : tag) {
      const auto px = camera.Project(T_C_board * corner);
      is_inside = is_inside && px && camera.IsInside(*px, kBorder_px);
    }
    if (is_inside) corners.insert(corners.end(), tag.begin(), tag.end());
  }
  return corners;
}

/// A pose of the board somewhere in the left image.
SE3 DrawBoardPose(const CameraModel& left, const BoardOptions& board, Rng& rng) {
  constexpr double kBorder = 0.15;  // of width and height: the middle of the board keeps away
  const Vector2d px(rng.Uniform(kBorder, 1 - kBorder) * left.width(),
                    rng.Uniform(kBorder, 1 - kBorder) * left.height());
  const double depth_m = rng.Uniform(board.near_m, board.far_m);
  const Quaterniond turn = ExpSO3(board.turn_rad * rng.Normal3());
  // At this depth along the axis, or at this distance where the lens sees beside itself.
  constexpr double kMinCosine = 0.1;
  const Vector3d ray = left.Unproject(px).value_or(Vector3d::UnitZ());
  return SE3(turn, depth_m * (ray.z() > kMinCosine ? Vector3d(ray / ray.z()) : ray));
}

/// No detector reads tags at a grazing angle.
bool IsReadable(const SE3& T_C_board) {
  constexpr double kMinCosine = 0.5;
  const Vector3d normal = T_C_board.q * Vector3d::UnitZ();
  return normal.dot(T_C_board.p.normalized()) > kMinCosine;
}

}  // namespace

std::vector<BoardView> MakeUpBoardViews(const StereoRig& rig,
                                        const BoardOptions& options,
                                        Rng& rng) {
  constexpr double kMinShare = 0.25;  // of the tags, in each camera
  constexpr int kMaxTries = 1000;     // for each view
  const std::vector<Tag> tags = LayOutTags(options);
  const double min_corners = kMinShare * 4 * static_cast<double>(tags.size());
  std::vector<BoardView> views;
  for (int i = 0; i < kMaxTries * options.num_views; ++i) {
    if (static_cast<int>(views.size()) == options.num_views) return views;
    BoardView view;
    view.T_C0_board = DrawBoardPose(rig.cameras[0], options, rng);
    if (!IsReadable(view.T_C0_board)) continue;
    view.corners = {CornersInView(tags, rig.cameras[0], view.T_C0_board),
                    CornersInView(tags, rig.cameras[1], rig.T_C1C0() * view.T_C0_board)};
    const auto is_enough = [&](const std::vector<Vector3d>& corners) {
      return static_cast<double>(corners.size()) >= min_corners;
    };
    if (is_enough(view.corners[0]) && is_enough(view.corners[1])) views.push_back(std::move(view));
  }
  return {};
}

}  // namespace facet
