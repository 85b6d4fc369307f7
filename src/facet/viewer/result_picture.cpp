// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/result_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "facet/io/errors.h"
#include "facet/io/planes_file.h"
#include "facet/io/ply_reader.h"
#include "facet/io/trajectory_file.h"
#include "facet/mesh/vertex_normals.h"
#include "facet/viewer/rasteriser.h"

namespace facet {
namespace {

// The palettes of viewer/src/palette.ts.
constexpr std::array<Colour, 12> kKinds = {{{86, 180, 233},
                                            {230, 159, 0},
                                            {0, 158, 115},
                                            {240, 228, 66},
                                            {204, 121, 167},
                                            {213, 94, 0},
                                            {0, 114, 178},
                                            {148, 203, 236},
                                            {220, 205, 125},
                                            {126, 41, 84},
                                            {93, 168, 153},
                                            {194, 106, 119}}};
constexpr Colour kNoPlane = {150, 156, 164};
constexpr std::array<Colour, 5> kAmounts = {
    {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
constexpr Colour kPath = {213, 94, 0};
constexpr double kFov_deg = 45;

Colour PlaneColour(std::int64_t id) {
  return id < 0 ? kNoPlane : kKinds[static_cast<std::size_t>(id) % kKinds.size()];
}

Colour AmountColour(double amount) {
  const double x = std::clamp(amount, 0.0, 1.0) * (kAmounts.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(x), kAmounts.size() - 2);
  Colour colour;
  for (std::size_t k = 0; k < 3; ++k) {
    const double share = x - static_cast<double>(i);
    colour[k] = kAmounts[i][k] + share * (kAmounts[i + 1][k] - kAmounts[i][k]);
  }
  return colour;
}

/// From the 2nd to the 98th percentile, along each axis: strays do not make the rest small.
struct Extent {
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
};

Extent ExtentOf(const std::vector<Vector3d>& points) {
  Extent extent;
  for (int axis = 0; axis < 3 && !points.empty(); ++axis) {
    std::vector<double> values;
    for (const Vector3d& p : points)
      values.push_back(p[axis]);
    std::ranges::sort(values);
    const double last = static_cast<double>(values.size() - 1);
    extent.low[axis] = values[static_cast<std::size_t>(0.02 * last)];
    extent.high[axis] = values[static_cast<std::size_t>(std::ceil(0.98 * last))];
  }
  return extent;
}

ViewPoint ChooseView(const PictureOptions& options, const Extent& extent) {
  if (options.from_W && options.to_W)
    return {*options.from_W, *options.to_W, kFov_deg, options.width, options.height};
  const Vector3d centre = 0.5 * (extent.low + extent.high);
  const double radius = std::max(0.5 * (extent.high - extent.low).norm(), 0.5);
  const Vector3d direction =
      options.view == "top" ? Vector3d(0, -1e-3, 1) : Vector3d(-0.55, -0.75, 0.75);
  const double narrow = std::min(1.0, static_cast<double>(options.width) / options.height);
  const double distance =
      0.8 * radius / (std::tan(0.5 * kFov_deg * std::numbers::pi / 180) * narrow);
  return {
      centre + distance * direction.normalized(), centre, kFov_deg, options.width, options.height};
}

class Colouring {
 public:
  Colouring(const TriangleMesh& mesh, const std::string& by, const Extent& extent)
      : mesh_(mesh), by_(by), extent_(extent) {}

  Colour At(std::size_t face, int vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    if (by_ == "normal") {
      const Vector3d n = mesh_.normals[v];
      return {127.5 + 127.5 * n.x(), 127.5 + 127.5 * n.y(), 127.5 + 127.5 * n.z()};
    }
    if (by_ == "height") {
      const double span = std::max(extent_.high.z() - extent_.low.z(), 1e-3);
      return AmountColour((mesh_.vertices[v].z() - extent_.low.z()) / span);
    }
    if (by_ == "image" && !mesh_.colours.empty())
      return {1.0 * mesh_.colours[v][0], 1.0 * mesh_.colours[v][1], 1.0 * mesh_.colours[v][2]};
    return PlaneColour(by_ == "plane" && !mesh_.plane_ids.empty() ? mesh_.plane_ids[face] : -1);
  }

 private:
  const TriangleMesh& mesh_;
  const std::string& by_;
  const Extent& extent_;
};

void DrawMesh(const TriangleMesh& mesh,
              const Colouring& colouring,
              const ViewPoint& view,
              bool has_back_sides,
              Rasteriser& out) {
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    std::array<Vector3d, 3> p;
    std::array<Colour, 3> colours;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = mesh.vertices[static_cast<std::size_t>(mesh.faces[f][k])];
    const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
    if (!has_back_sides && normal.dot(view.eye_W() - p[0]) <= 0) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const int vertex = mesh.faces[f][k];
      colours[k] = colouring.At(f, vertex);
      // Light comes from above the camera.
      const Vector3d to_light = (view.eye_W() - p[k]).normalized() + Vector3d(0.2, 0.1, 0.5);
      const Vector3d& n = mesh.normals[static_cast<std::size_t>(vertex)];
      const double light = 0.45 + 0.6 * std::abs(n.dot(to_light.normalized()));
      for (double& channel : colours[k])
        channel *= std::min(light, 1.0);
    }
    out.DrawTriangle(view, p, colours);
  }
}

void DrawPath(const std::filesystem::path& result, const ViewPoint& view, Rasteriser& out) {
  if (!std::filesystem::exists(result / "trajectory.tum")) return;
  const std::vector<StampedPose> poses = ReadTrajectory(result / "trajectory.tum").poses;
  const double width_px = std::max(2.0, 3e-3 * view.height());
  for (std::size_t i = 1; i < poses.size(); ++i)
    out.DrawLine(view, poses[i - 1].T_WB.p, poses[i].T_WB.p, kPath, width_px);
}

void DrawOutlines(const std::vector<EstimatedPlane>& planes,
                  const ViewPoint& view,
                  Rasteriser& out) {
  for (const EstimatedPlane& plane : planes) {
    for (std::size_t i = 0; i < plane.outline_W.size(); ++i) {
      const Vector3d& next = plane.outline_W[(i + 1) % plane.outline_W.size()];
      out.DrawLine(view, plane.outline_W[i], next, PlaneColour(plane.id), 1.5);
    }
  }
}

/// Largest planes first; labels that would overlap are left out.
void DrawLabels(std::vector<EstimatedPlane> planes,
                const ViewPoint& view,
                bool is_dark,
                cv::Mat& image) {
  std::ranges::sort(planes, std::greater(), &EstimatedPlane::area_m2);
  std::vector<cv::Rect> taken;
  const double size = std::max(0.4, view.height() / 1900.0);
  const cv::Rect whole(0, 0, image.cols, image.rows);
  for (const EstimatedPlane& plane : planes) {
    const Vector3d p_C = view.ToCamera(plane.centre_W);
    if (!(p_C.z() > 0)) continue;
    const Vector3d px = view.ToImage(p_C);
    constexpr double kFar_px = 1e6;
    if (!(px.head<2>().cwiseAbs().maxCoeff() < kFar_px)) continue;
    const std::string text = plane.label + " " + std::to_string(plane.id);
    const cv::Size letters = cv::getTextSize(text, cv::FONT_HERSHEY_DUPLEX, size, 1, nullptr);
    const int border = letters.height / 2;
    const cv::Rect box(static_cast<int>(px.x()) - letters.width / 2 - border,
                       static_cast<int>(px.y()) - letters.height / 2 - border,
                       letters.width + 2 * border,
                       letters.height + 2 * border);
    const bool is_free = std::ranges::none_of(
        taken, [&](const cv::Rect& other) { return (other & box).area() > 0; });
    if (!is_free || (box & whole) != box) continue;
    taken.push_back(box);
    const Colour c = PlaneColour(plane.id);
    cv::rectangle(image, box, is_dark ? cv::Scalar(30, 35, 41) : cv::Scalar(255, 255, 255), -1);
    cv::rectangle(image, box, {c[0], c[1], c[2]}, 2, cv::LINE_AA);
    cv::putText(image,
                text,
                {box.x + border, box.y + border + letters.height},
                cv::FONT_HERSHEY_DUPLEX,
                size,
                is_dark ? cv::Scalar(230, 233, 237) : cv::Scalar(26, 33, 41),
                1,
                cv::LINE_AA);
  }
}

}  // namespace

cv::Mat DrawResult(const std::filesystem::path& result, const PictureOptions& options) {
  if (!std::filesystem::is_directory(result))
    throw InputError(result.string() + ": is not a result folder of 'facet run'");
  TriangleMesh mesh = ReadPly(result / (options.mesh == "horizon" ? "mesh.ply" : "map.ply"));
  if (mesh.normals.empty()) SetVertexNormals(mesh);
  std::vector<EstimatedPlane> planes;
  if (std::filesystem::exists(result / "planes.csv"))
    planes = ReadEstimatedPlanes(result / "planes.csv");

  const Extent extent = ExtentOf(mesh.vertices);
  const ViewPoint view = ChooseView(options, extent);
  const Colour background = options.is_dark ? Colour{27, 31, 37} : Colour{255, 255, 255};
  Rasteriser rasteriser(options.width, options.height, background);
  DrawMesh(mesh, Colouring(mesh, options.colour, extent), view, options.has_back_sides, rasteriser);
  if (options.has_trajectory) DrawPath(result, view, rasteriser);
  const bool shows_planes = options.has_labels && options.colour == "plane";
  if (shows_planes) DrawOutlines(planes, view, rasteriser);
  cv::Mat image = rasteriser.Image();
  if (shows_planes) DrawLabels(planes, view, options.is_dark, image);
  return image;
}

}  // namespace facet
