// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/grey_canvas.h"

#include <algorithm>
#include <array>
#include <string>

#include <opencv2/imgproc.hpp>

namespace facet {
namespace {

/// One octave: independent values on a lattice that repeats, enlarged by cubic interpolation.
GreyCanvas Octave(int size_px, int columns, int rows, Rng& rng) {
  constexpr int kPad = 3;
  cv::Mat1f lattice(rows, columns);
  for (float& value : lattice)
    value = static_cast<float>(rng.Uniform(-1, 1));
  if (columns == size_px && rows == size_px) return lattice;
  cv::Mat1f padded, enlarged;
  cv::copyMakeBorder(lattice, padded, kPad, kPad, kPad, kPad, cv::BORDER_WRAP);
  const int step_x = size_px / columns, step_y = size_px / rows;
  cv::resize(padded, enlarged, {padded.cols * step_x, padded.rows * step_y}, 0, 0, cv::INTER_CUBIC);
  return enlarged(cv::Rect(kPad * step_x, kPad * step_y, size_px, size_px)).clone();
}

cv::Point RandomPoint(const GreyCanvas& canvas, Rng& rng) {
  return {rng.Index(canvas.cols), rng.Index(canvas.rows)};
}

void DrawRandomShape(GreyCanvas& canvas, double radius, Rng& rng) {
  const cv::Point center = RandomPoint(canvas, rng);
  const cv::Scalar albedo(rng.Uniform(0.05, 0.95));
  const int kind = rng.Index(3);
  if (kind == 0) {
    const cv::Size axes(std::max(1, static_cast<int>(radius)),
                        std::max(1, static_cast<int>(radius * rng.Uniform(0.4, 1))));
    cv::ellipse(canvas, center, axes, rng.Uniform(0, 180), 0, 360, albedo, cv::FILLED, cv::LINE_AA);
    return;
  }
  std::array<cv::Point, 5> corners;
  const int num_corners = kind == 1 ? 4 : 5;
  const double turn = rng.Uniform(0, 2 * std::numbers::pi);
  for (int k = 0; k < num_corners; ++k) {
    const double angle = turn + 2 * std::numbers::pi * k / num_corners;
    const double reach = radius * (kind == 1 ? 1.0 : rng.Uniform(0.5, 1.3));
    corners[static_cast<std::size_t>(k)] = {center.x + static_cast<int>(reach * std::cos(angle)),
                                            center.y + static_cast<int>(reach * std::sin(angle))};
  }
  cv::fillConvexPoly(canvas, corners.data(), num_corners, albedo, cv::LINE_AA);
}

}  // namespace

GreyCanvas FractalNoise(const NoiseOptions& options, Rng& rng) {
  GreyCanvas sum(options.size_px, options.size_px, 0.0F);
  double amplitude = 1;
  for (int period = options.min_period; period <= options.size_px; period *= 2) {
    const int columns = std::max(1, static_cast<int>(period / options.stretch));
    cv::scaleAdd(Octave(options.size_px, columns, period, rng), amplitude, sum, sum);
    amplitude *= options.persistence;
  }
  cv::Scalar mean, deviation;
  cv::meanStdDev(sum, mean, deviation);
  return GreyCanvas((sum - mean[0]) / std::max(1e-9, deviation[0]));
}

GreyCanvas DeadLeaves(int size_px, Rng& rng) {
  GreyCanvas canvas(size_px, size_px, 0.5F);
  // Radii have the density r^-3 between these two, painted back to front.
  const double smallest = 1.5, largest = size_px / 4.0;
  const int num_shapes = size_px * size_px / 60;
  for (int i = 0; i < num_shapes; ++i) {
    const double u = rng.Uniform();
    const double a = 1 / (smallest * smallest), b = 1 / (largest * largest);
    DrawRandomShape(canvas, 1 / std::sqrt(a + u * (b - a)), rng);
  }
  // Big shapes last but sparse, so that the small ones show between them.
  for (int i = 0; i < 12; ++i)
    DrawRandomShape(canvas, rng.Uniform(size_px / 20.0, size_px / 6.0), rng);
  cv::GaussianBlur(canvas, canvas, {}, size_px / 600.0);  // no print is sharper
  return GreyCanvas(0.12 + 0.6 * canvas + 0.03 * FractalNoise({size_px, 4, 1, 1}, rng));
}

GreyCanvas PrintedSheet(int size_px, Rng& rng) {
  static constexpr char kLetters[] =
      "ABCDEFGHIKLMNOPRSTUVWXYZabcdefghiklmnoprstuvwxyz0123456789+-=";
  GreyCanvas canvas(size_px, size_px, 0.9F);
  for (int y = size_px / 16; y < size_px;) {
    const double scale = size_px / 512.0 * (rng.Index(4) == 0 ? rng.Uniform(2, 4) : 1.0);
    y += static_cast<int>(26 * scale);
    std::string line;
    for (int i = rng.Index(12) + 10; i > 0; --i)
      line += rng.Index(6) == 0 ? ' ' : kLetters[rng.Index(sizeof(kLetters) - 1)];
    cv::putText(canvas,
                line,
                {size_px / 16, y},
                cv::FONT_HERSHEY_SIMPLEX,
                0.8 * scale,
                cv::Scalar(0.1),
                std::max(1, static_cast<int>(2 * scale)),
                cv::LINE_AA);
  }
  return GreyCanvas(canvas + 0.01 * FractalNoise({size_px, 4, 1, 1}, rng));
}

void Scratch(GreyCanvas& canvas, int count, double strength, Rng& rng) {
  GreyCanvas lines(canvas.size(), 0.0F);
  for (int i = 0; i < count; ++i) {
    const cv::Point from = RandomPoint(canvas, rng);
    const double angle = rng.Uniform(0, 2 * std::numbers::pi);
    const double length = canvas.cols * rng.Uniform(0.005, 0.06);
    const cv::Point to(from.x + static_cast<int>(length * std::cos(angle)),
                       from.y + static_cast<int>(length * std::sin(angle)));
    cv::line(lines, from, to, cv::Scalar(rng.Uniform(-strength, strength)), 1, cv::LINE_8);
  }
  canvas += lines;
}

void Speckle(GreyCanvas& canvas, int count, double max_radius_px, double strength, Rng& rng) {
  GreyCanvas spots(canvas.size(), 0.0F);
  for (int i = 0; i < count; ++i) {
    const double u = rng.Uniform();
    const int radius = static_cast<int>(max_radius_px * u * u * u);
    cv::circle(spots,
               RandomPoint(canvas, rng),
               radius,
               cv::Scalar(rng.Uniform(-strength, strength)),
               cv::FILLED,
               cv::LINE_8);
  }
  canvas += spots;
}

}  // namespace facet
