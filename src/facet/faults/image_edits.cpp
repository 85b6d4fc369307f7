// SPDX-License-Identifier: BSD-2-Clause
#include "facet/faults/image_edits.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "facet/base/random.h"

namespace facet {

namespace {

// Random squares, softened as by a lens.
cv::Mat BoardTexture(int columns, int rows) {
  constexpr int kSquare = 9;
  Rng rng(17);
  cv::Mat squares(rows / kSquare + 1, columns / kSquare + 1, CV_8UC1);
  for (int y = 0; y < squares.rows; ++y) {
    for (int x = 0; x < squares.cols; ++x)
      squares.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(40 + rng.Index(180));
  }
  cv::Mat texture;
  cv::resize(squares, texture, {columns, rows}, 0, 0, cv::INTER_NEAREST);
  cv::GaussianBlur(texture, texture, {0, 0}, 1.0);
  return texture;
}

}  // namespace

ImageEdit Filled(int grey) {
  return [grey](cv::Mat& image) { image.setTo(grey); };
}

ImageEdit Brightened(double gain) {
  return [gain](cv::Mat& image) { image.convertTo(image, CV_8U, gain); };
}

ImageEdit Covered(double share) {
  return [share](cv::Mat& image) {
    const int first = static_cast<int>(std::lround((1 - share) * image.rows));
    image.rowRange(std::clamp(first, 0, image.rows), image.rows).setTo(12);
  };
}

ImageEdit Noisy(double sigma, std::uint64_t seed) {
  return [sigma, seed](cv::Mat& image) {
    Rng rng(seed);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        auto& pixel = image.at<std::uint8_t>(y, x);
        pixel = cv::saturate_cast<std::uint8_t>(pixel + sigma * rng.Normal());
      }
    }
  };
}

ImageEdit DarkenedTo(double mean) {
  return [mean](cv::Mat& image) {
    const double now = cv::mean(image)[0];
    if (now > mean) image.convertTo(image, CV_8U, mean / now);
  };
}

ImageEdit ClippedAtTop(double share) {
  return [share](cv::Mat& image) {
    std::array<int, 256> histogram{};
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x)
        ++histogram[image.at<std::uint8_t>(y, x)];
    }
    int grey = 255;
    for (double above = histogram[255]; grey > 1 && above < share * image.rows * image.cols;)
      above += histogram[static_cast<std::size_t>(--grey)];
    image.convertTo(image, CV_8U, 255.0 / grey);
  };
}

ImageEdit Blurred(double sigma_px) {
  return [sigma_px](cv::Mat& image) { cv::GaussianBlur(image, image, {0, 0}, sigma_px); };
}

ImageEdit Faded(double contrast) {
  return [contrast](cv::Mat& image) {
    image.convertTo(image, CV_8U, contrast, (1 - contrast) * cv::mean(image)[0]);
  };
}

ImageEdit Dotted(double grey, int num_dots, std::uint64_t seed) {
  return [=](cv::Mat& image) {
    Rng rng(seed);
    cv::Mat dots(image.size(), CV_8UC1, cv::Scalar(0));
    for (int i = 0; i < num_dots; ++i) {
      const int x = rng.Index(image.cols - 1), y = rng.Index(image.rows - 1);
      dots(cv::Rect(x, y, 2, 2)).setTo(grey);
    }
    cv::add(image, dots, image);
  };
}

ImageEdit WithBoard(
    const StereoRig& rig, std::size_t camera, double share, double depth_m, double phase) {
  const CameraIntrinsics& k = rig.cameras[camera].intrinsics();
  const double side = std::sqrt(share);
  const int columns = static_cast<int>(side * k.width), rows = static_cast<int>(side * k.height);
  // The left edge in the left image, and where the right camera sees the same points.
  const CameraIntrinsics& left = rig.cameras[0].intrinsics();
  const double x_left = phase * (left.width - columns), y_left = 0.5 * (left.height - rows);
  const Vector3d corner_C0(
      (x_left - left.cx) / left.fx * depth_m, (y_left - left.cy) / left.fy * depth_m, depth_m);
  const Vector3d corner = camera == 0 ? corner_C0 : rig.T_C1C0() * corner_C0;
  const double x = k.fx * corner.x() / corner.z() + k.cx;
  const double y = k.fy * corner.y() / corner.z() + k.cy;
  return [=](cv::Mat& image) {
    const cv::Mat texture = BoardTexture(columns, rows);
    const cv::Matx23d place(1, 0, x, 0, 1, y);
    cv::warpAffine(texture, image, place, image.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
  };
}

ImageEdit Turned(const CameraModel& camera, const Matrix3d& R) {
  cv::Mat from(camera.height(), camera.width(), CV_32FC2);
  for (int y = 0; y < from.rows; ++y) {
    for (int x = 0; x < from.cols; ++x) {
      const auto ray = camera.Unproject(Vector2d(x, y));
      const auto px = ray ? camera.Project(R * *ray) : std::nullopt;
      from.at<cv::Vec2f>(y, x) =
          px ? cv::Vec2f(static_cast<float>(px->x()), static_cast<float>(px->y()))
             : cv::Vec2f(static_cast<float>(x), static_cast<float>(y));
    }
  }
  return [from](cv::Mat& image) {
    cv::Mat turned;
    cv::remap(image, turned, from, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    image = turned;
  };
}

}  // namespace facet
