// SPDX-License-Identifier: BSD-2-Clause
// Draws triangles and lines in space into an image, with a depth buffer; needs no display.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/base/types.h"

namespace facet {

using Colour = std::array<double, 3>;  ///< red, green, blue from 0 to 255, as on the screen

/// A pinhole camera that looks from one point to another; z of the world is up in the image.
class ViewPoint {
 public:
  /// `fov_deg`: the angle of view over the height of the image.
  ViewPoint(const Vector3d& eye_W, const Vector3d& target_W, double fov_deg, int width, int height);

  /// x to the right, y down, z depth along the optical axis [m].
  Vector3d ToCamera(const Vector3d& p_W) const { return R_CW_ * (p_W - eye_W_); }

  /// Pixel and depth of a point in the camera's frame, which must be in front of it.
  Vector3d ToImage(const Vector3d& p_C) const;

  const Vector3d& eye_W() const { return eye_W_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Vector3d eye_W_;
  Matrix3d R_CW_;
  double focal_px_;
  int width_, height_;
};

/// What is nearer hides what is farther. Everything is drawn with more pixels than the image has.
class Rasteriser {
 public:
  Rasteriser(int width, int height, const Colour& background);

  /// The view must have the size of the image.
  void DrawTriangle(const ViewPoint& view,
                    const std::array<Vector3d, 3>& p_W,
                    const std::array<Colour, 3>& colours);

  /// A line of some pixels' width; `nearer_m`: how much farther than what hides it it may lie.
  void DrawLine(const ViewPoint& view,
                const Vector3d& a_W,
                const Vector3d& b_W,
                const Colour& colour,
                double width_px,
                double nearer_m = 0.02);

  /// RGB, 8 bits.
  cv::Mat Image() const;

 private:
  struct Pixel {
    float inverse_depth = 0;  // 0: background
    std::array<std::uint8_t, 3> colour{};
  };
  void Put(int x, int y, double inverse_depth, const Colour& colour);

  int width_, height_;  // of the pixels that are drawn
  std::vector<Pixel> pixels_;
};

}  // namespace facet
