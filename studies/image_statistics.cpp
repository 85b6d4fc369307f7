// SPDX-License-Identifier: BSD-2-Clause
// Question: what do the images of a sequence offer to a tracker? One line of key=value pairs per
//   sequence, which studies/realism.py compares.
// Command: image_statistics SEQUENCE...
// Answer: with studies/realism.py.
// Date: 2026-11-21.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "facet/io/asl_dataset.h"

namespace facet {
namespace {

double Median(std::vector<double> v) {
  if (v.empty()) return 0;
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

struct ImageFigures {
  std::vector<double> corners, cells, response, gradient, saturated, grey, right_gain;

  void Add(const cv::Mat& left, const cv::Mat& right) {
    constexpr int kThreshold = 20, kCell_px = 40;
    std::vector<cv::KeyPoint> points;
    cv::FAST(left, points, kThreshold, true);
    corners.push_back(static_cast<double>(points.size()));
    // The front end takes one point per cell: what counts is how many cells have one, how good.
    cv::Mat1d best(left.rows / kCell_px, left.cols / kCell_px, 0.0);
    for (const cv::KeyPoint& p : points) {
      const int row = std::min(best.rows - 1, static_cast<int>(p.pt.y) / kCell_px);
      const int column = std::min(best.cols - 1, static_cast<int>(p.pt.x) / kCell_px);
      best(row, column) = std::max(best(row, column), static_cast<double>(p.response));
    }
    std::vector<double> responses;
    for (const double r : best) {
      if (r > 0) responses.push_back(r);
    }
    cells.push_back(static_cast<double>(responses.size()));
    if (!responses.empty()) response.push_back(Median(responses));
    cv::Mat dx, dy, length;
    cv::Sobel(left, dx, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(left, dy, CV_32F, 0, 1, 3, 0.125);
    cv::magnitude(dx, dy, length);
    gradient.push_back(cv::mean(length)[0]);
    grey.push_back(cv::mean(left)[0]);
    saturated.push_back(100.0 * cv::countNonZero(left >= 254) / static_cast<double>(left.total()));
    if (!right.empty()) right_gain.push_back(cv::mean(right)[0] / std::max(1.0, grey.back()));
  }
};

void Print(const std::string& sequence) {
  AslDataset dataset(sequence);
  ImageFigures figures;
  for (std::size_t i = 0; i < dataset.frames().size(); i += 5) {
    cv::Mat left, right;
    dataset.ReadPair(i, left, right);
    figures.Add(left, right);
  }
  std::printf(
      "fast_corners=%.1f fast_cells=%.1f fast_response=%.1f gradient=%.2f grey=%.1f "
      "saturated_percent=%.2f right_over_left=%.3f\n",
      Median(figures.corners),
      Median(figures.cells),
      Median(figures.response),
      Median(figures.gradient),
      Median(figures.grey),
      Median(figures.saturated),
      Median(figures.right_gain));
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  try {
    cv::setNumThreads(1);
    for (int i = 1; i < argc; ++i)
      facet::Print(argv[i]);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "image_statistics: " << error.what() << '\n';
    return 1;
  }
}
