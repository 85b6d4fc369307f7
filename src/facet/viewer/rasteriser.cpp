// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/rasteriser.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "facet/base/check.h"

namespace facet {
namespace {

constexpr int kSamples = 2;  // per pixel, along each side
constexpr double kNearest_m = 0.05;

std::uint8_t ByteOf(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

/// The part of a triangle in front of the camera: up to four corners.
struct Corner {
  Vector3d p_C;
  Colour colour;
};

Corner Between(const Corner& a, const Corner& b) {
  const double t = (kNearest_m - a.p_C.z()) / (b.p_C.z() - a.p_C.z());
  Corner corner{a.p_C + t * (b.p_C - a.p_C), {}};
  for (std::size_t i = 0; i < 3; ++i)
    corner.colour[i] = a.colour[i] + t * (b.colour[i] - a.colour[i]);
  return corner;
}

std::vector<Corner> InFront(const std::array<Corner, 3>& triangle) {
  std::vector<Corner> polygon;
  for (std::size_t i = 0; i < 3; ++i) {
    const Corner &a = triangle[i], &b = triangle[(i + 1) % 3];
    const bool a_is_in = a.p_C.z() > kNearest_m, b_is_in = b.p_C.z() > kNearest_m;
    if (a_is_in) polygon.push_back(a);
    if (a_is_in != b_is_in) polygon.push_back(Between(a, b));
  }
  return polygon;
}

double Cross(const Vector3d& a, const Vector3d& b, double x, double y) {
  return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

// The sample at a coordinate, or the nearest one of the picture.
int Within(double x, int size) {
  return static_cast<int>(std::clamp<double>(x, 0, size - 1));
}

}  // namespace

ViewPoint::ViewPoint(
    const Vector3d& eye_W, const Vector3d& target_W, double fov_deg, int width, int height)
    : eye_W_(eye_W), width_(width), height_(height) {
  const Vector3d forward = (target_W - eye_W).normalized();
  FACET_CHECK(forward.allFinite()) << "eye and target are one point";
  Vector3d right = forward.cross(Vector3d::UnitZ());
  if (right.norm() < 1e-6) right = Vector3d::UnitX();  // straight down or up
  right.normalize();
  R_CW_.row(0) = right;
  R_CW_.row(1) = forward.cross(right);
  R_CW_.row(2) = forward;
  focal_px_ = 0.5 * height / std::tan(0.5 * fov_deg * std::numbers::pi / 180);
}

Vector3d ViewPoint::ToImage(const Vector3d& p_C) const {
  const double scale = focal_px_ / p_C.z();
  return {0.5 * width_ + scale * p_C.x(), 0.5 * height_ + scale * p_C.y(), p_C.z()};
}

Rasteriser::Rasteriser(int width, int height, const Colour& background)
    : width_(kSamples * width), height_(kSamples * height) {
  FACET_CHECK(width > 0 && height > 0) << width << " x " << height;
  Pixel empty;
  for (std::size_t i = 0; i < 3; ++i)
    empty.colour[i] = ByteOf(background[i]);
  pixels_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), empty);
}

void Rasteriser::Put(int x, int y, double inverse_depth, const Colour& colour) {
  Pixel& pixel = pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                         static_cast<std::size_t>(x)];
  if (inverse_depth <= pixel.inverse_depth) return;
  pixel.inverse_depth = static_cast<float>(inverse_depth);
  for (std::size_t i = 0; i < 3; ++i)
    pixel.colour[i] = ByteOf(colour[i]);
}

void Rasteriser::DrawTriangle(const ViewPoint& view,
                              const std::array<Vector3d, 3>& p_W,
                              const std::array<Colour, 3>& colours) {
  std::array<Corner, 3> corners;
  for (std::size_t i = 0; i < 3; ++i)
    corners[i] = {view.ToCamera(p_W[i]), colours[i]};
  const std::vector<Corner> polygon = InFront(corners);
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const std::array<const Corner*, 3> part = {&polygon[0], &polygon[i - 1], &polygon[i]};
    std::array<Vector3d, 3> q;  // pixel and inverse depth, which is linear in the image
    for (std::size_t k = 0; k < 3; ++k) {
      q[k] = view.ToImage(part[k]->p_C);
      q[k] = {kSamples * q[k].x(), kSamples * q[k].y(), 1 / q[k].z()};
    }
    const double area = Cross(q[0], q[1], q[2].x(), q[2].y());
    if (!(std::abs(area) > 1e-9)) continue;
    const auto [x0, x1] = std::minmax({q[0].x(), q[1].x(), q[2].x()});
    const auto [y0, y1] = std::minmax({q[0].y(), q[1].y(), q[2].y()});
    if (x1 < 0 || y1 < 0 || x0 > width_ || y0 > height_) continue;
    if (!std::isfinite(area)) continue;
    const int first_x = Within(x0, width_), last_x = Within(x1, width_);
    const int first_y = Within(y0, height_), last_y = Within(y1, height_);
    for (int y = first_y; y <= last_y; ++y) {
      for (int x = first_x; x <= last_x; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double a = Cross(q[1], q[2], px, py) / area, b = Cross(q[2], q[0], px, py) / area;
        const double c = 1 - a - b;
        if (a < 0 || b < 0 || c < 0) continue;
        const double inverse = a * q[0].z() + b * q[1].z() + c * q[2].z();
        Colour colour;
        for (std::size_t k = 0; k < 3; ++k) {
          colour[k] = (a * q[0].z() * part[0]->colour[k] + b * q[1].z() * part[1]->colour[k] +
                       c * q[2].z() * part[2]->colour[k]) /
                      inverse;
        }
        Put(x, y, inverse, colour);
      }
    }
  }
}

void Rasteriser::DrawLine(const ViewPoint& view,
                          const Vector3d& a_W,
                          const Vector3d& b_W,
                          const Colour& colour,
                          double width_px,
                          double nearer_m) {
  Corner a{view.ToCamera(a_W), colour}, b{view.ToCamera(b_W), colour};
  if (a.p_C.z() <= kNearest_m && b.p_C.z() <= kNearest_m) return;
  if (a.p_C.z() <= kNearest_m) a = Between(b, a);
  if (b.p_C.z() <= kNearest_m) b = Between(a, b);
  const Vector3d p = view.ToImage(a.p_C), q = view.ToImage(b.p_C);
  const double length = kSamples * (q - p).head<2>().norm();
  constexpr double kLongest = 1e5;  // a line to a place beside the camera has no end
  if (!(length < kLongest)) return;
  const double radius = 0.5 * kSamples * width_px;
  const int steps = std::max(1, static_cast<int>(std::ceil(length / std::max(0.5 * radius, 0.5))));
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const double x = kSamples * (p.x() + t * (q.x() - p.x()));
    const double y = kSamples * (p.y() + t * (q.y() - p.y()));
    const double inverse = 1 / p.z() + t * (1 / q.z() - 1 / p.z());
    const double shown = 1 / std::max(1 / inverse - nearer_m, 0.5 / inverse);
    if (!(x + radius >= 0 && y + radius >= 0 && x - radius < width_ && y - radius < height_))
      continue;
    for (int v = Within(y - radius, height_); v <= Within(y + radius, height_); ++v) {
      for (int u = Within(x - radius, width_); u <= Within(x + radius, width_); ++u) {
        if ((u - x) * (u - x) + (v - y) * (v - y) <= radius * radius) Put(u, v, shown, colour);
      }
    }
  }
}

cv::Mat Rasteriser::Image() const {
  cv::Mat fine(height_, width_, CV_8UC3);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Pixel& pixel = pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                   static_cast<std::size_t>(x)];
      fine.at<cv::Vec3b>(y, x) = {pixel.colour[0], pixel.colour[1], pixel.colour[2]};
    }
  }
  cv::Mat image;
  cv::resize(fine, image, {width_ / kSamples, height_ / kSamples}, 0, 0, cv::INTER_AREA);
  return image;
}

}  // namespace facet
