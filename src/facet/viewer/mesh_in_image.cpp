// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/mesh_in_image.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>

#include "facet/viewer/base64.h"
#include "facet/viewer/jpeg_encoder.h"

namespace facet {
namespace {

constexpr double kNearest_m = 0.05;

struct ProjectedVertex {
  Vector2d px;
  double depth_m = 0;
};

using Corners = std::array<ProjectedVertex, 3>;

/// Twice the area of a triangle in the image; positive if its corners run clockwise on the screen.
double TwiceArea(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// The nearest surface in each cell of the image.
class DepthCells {
 public:
  DepthCells(int width, int height) : columns_(width / kCell_px + 1), rows_(height / kCell_px + 1) {
    nearest_m_.assign(static_cast<std::size_t>(columns_) * rows_,
                      std::numeric_limits<double>::infinity());
  }

  void Add(const Corners& c) {
    const double area = TwiceArea(c[0].px, c[1].px, c[2].px);
    if (area == 0) return;
    const auto [x0, x1] = Range(c, 0, columns_);
    const auto [y0, y1] = Range(c, 1, rows_);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const Vector2d px(kCell_px * (x + 0.5), kCell_px * (y + 0.5));
        double inverse = 0;
        bool is_in = true;
        for (int k = 0; k < 3 && is_in; ++k) {
          const double share = TwiceArea(px, c[(k + 1) % 3].px, c[(k + 2) % 3].px) / area;
          is_in = share >= 0;
          inverse += share / c[k].depth_m;
        }
        if (is_in) At(x, y) = std::min(At(x, y), 1 / inverse);
      }
    }
  }

  /// Whether something is clearly in front of the middle of a face.
  bool Hides(const Corners& c) const {
    const Vector2d px = (c[0].px + c[1].px + c[2].px) / 3;
    // As Add interpolates: linearly in the inverse depth.
    const double depth_m = 3 / (1 / c[0].depth_m + 1 / c[1].depth_m + 1 / c[2].depth_m);
    const int x = std::clamp(static_cast<int>(px.x() / kCell_px), 0, columns_ - 1);
    const int y = std::clamp(static_cast<int>(px.y() / kCell_px), 0, rows_ - 1);
    constexpr double kShare = 0.06, kLeast_m = 0.05;
    return At(x, y) < depth_m - std::max(kShare * depth_m, kLeast_m);
  }

 private:
  static constexpr int kCell_px = 4;

  static std::pair<int, int> Range(const Corners& c, int axis, int count) {
    const auto [low, high] = std::minmax({c[0].px[axis], c[1].px[axis], c[2].px[axis]});
    return {std::max(static_cast<int>(low / kCell_px) - 1, 0),
            std::min(static_cast<int>(high / kCell_px) + 1, count - 1)};
  }
  double& At(int x, int y) { return nearest_m_[static_cast<std::size_t>(y) * columns_ + x]; }
  double At(int x, int y) const { return nearest_m_[static_cast<std::size_t>(y) * columns_ + x]; }

  int columns_, rows_;
  std::vector<double> nearest_m_;
};

/// Empty for vertices that the camera does not see.
std::vector<std::optional<ProjectedVertex>> ProjectAll(const TriangleMesh& mesh,
                                                       const CameraModel& camera,
                                                       const SE3& T_WC) {
  const SE3 T_CW = T_WC.Inverse();
  std::vector<std::optional<ProjectedVertex>> projected(mesh.vertices.size());
  for (std::size_t i = 0; i < projected.size(); ++i) {
    const Vector3d p_C = T_CW * mesh.vertices[i];
    if (p_C.z() < kNearest_m) continue;
    if (const auto px = camera.Project(p_C)) projected[i] = ProjectedVertex{*px, p_C.z()};
  }
  return projected;
}

}  // namespace

MeshInImage SeeMesh(const TriangleMesh& mesh, const CameraModel& camera, const SE3& T_WC) {
  const auto projected = ProjectAll(mesh, camera, T_WC);
  std::vector<std::pair<std::size_t, Corners>> candidates;  // faces and their corners
  DepthCells cells(camera.width(), camera.height());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [a, b, c] = mesh.faces[f];
    if (!projected[a] || !projected[b] || !projected[c]) continue;
    const Corners corners = {*projected[a], *projected[b], *projected[c]};
    const bool is_inside = std::ranges::any_of(
        corners, [&](const ProjectedVertex& v) { return camera.IsInside(v.px, 0); });
    // Counter-clockwise from the front; y of the image is down.
    const bool is_front = TwiceArea(corners[0].px, corners[1].px, corners[2].px) < 0;
    if (!is_inside || !is_front) continue;
    cells.Add(corners);
    candidates.emplace_back(f, corners);
  }
  MeshInImage seen;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (const auto& [f, corners] : candidates) {
    if (cells.Hides(corners)) continue;
    std::array<int, 3>& face = seen.faces.emplace_back();
    for (int k = 0; k < 3; ++k) {
      int& number = index[mesh.faces[f][k]];
      if (number < 0) {
        number = static_cast<int>(seen.pixels.size());
        seen.pixels.push_back(corners[k].px);
        seen.depths_m.push_back(corners[k].depth_m);
      }
      face[k] = number;
    }
    seen.plane_ids.push_back(mesh.plane_ids.empty() ? -1 : mesh.plane_ids[f]);
  }
  return seen;
}

std::string MeshImageSvg(const cv::Mat& grey, const MeshInImage& mesh) {
  // As in the page; the last one: on no plane.
  constexpr std::array kColours = {
      "#56b4e9", "#e69f00", "#009e73", "#f0e442", "#cc79a7", "#d55e00"};
  constexpr const char* kNoPlane = "#d8dce0";
  constexpr int kQuality = 75;
  std::map<std::string, std::string> paths;  // by colour
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const int id = mesh.plane_ids[f];
    std::string& path =
        paths[id < 0 ? kNoPlane : kColours[static_cast<std::size_t>(id) % kColours.size()]];
    for (int k = 0; k < 3; ++k) {
      const Vector2d& px = mesh.pixels[mesh.faces[f][k]];
      char text[40];
      std::snprintf(text, sizeof(text), "%c%.1f %.1f", k == 0 ? 'M' : 'L', px.x(), px.y());
      path += text;
    }
    path += 'Z';
  }
  const std::string size =
      "width=\"" + std::to_string(grey.cols) + "\" height=\"" + std::to_string(grey.rows) + "\"";
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " +
                    std::to_string(grey.cols) + " " + std::to_string(grey.rows) + "\" " + size +
                    "><image " + size + " href=\"data:image/jpeg;base64," +
                    Base64(EncodeJpeg(grey, kQuality)) + "\"/>";
  for (const auto& [colour, path] : paths) {
    svg += "<path fill=\"none\" stroke=\"" + colour +
           "\" stroke-width=\"1\" stroke-opacity=\"0.8\" d=\"" + path + "\"/>";
  }
  return svg + "</svg>";
}

}  // namespace facet
