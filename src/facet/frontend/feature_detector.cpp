// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/feature_detector.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace facet {
namespace {

// The strength of a corner is how well shift, rotation and scale of its patch can be estimated.
constexpr int kStrengthParameters = 4;

// Empty cells are searched again with this threshold if the image gave too few points.
constexpr int kWeakFastThreshold = 7;

// Patches need this much room.
constexpr int kBorder_px = 8;

int NumCellsAlong(int side, int cell_px) {
  return std::max(0, (side - 2 * kBorder_px) / cell_px);
}

}  // namespace

int NumCells(const cv::Size& image, const DetectorOptions& options) {
  return NumCellsAlong(image.width, options.cell_px) * NumCellsAlong(image.height, options.cell_px);
}

FeatureDetector::FeatureDetector(const DetectorOptions& options, const KltOptions& klt)
    : options_(options), tracker_(klt, kStrengthParameters), scratch_(1, kStrengthParameters) {}

void FeatureDetector::MarkOccupied(const cv::Mat& image, std::span<const Vector2d> occupied) {
  mask_.create(image.size(), CV_8UC1);
  mask_.setTo(255);
  const int radius = static_cast<int>(options_.min_distance_px);
  for (const Vector2d& p : occupied) {
    const cv::Point centre(static_cast<int>(p.x() + 0.5), static_cast<int>(p.y() + 0.5));
    cv::circle(mask_, centre, radius, cv::Scalar(0), cv::FILLED);
  }
}

bool FeatureDetector::BestCorner(const ImageLevel& level, Candidate& best) {
  // FAST's own response prefers isolated dots; the information of the patch is what counts.
  constexpr std::size_t kMaxTried = 4;
  const auto stronger = [](const FastCorner& a, const FastCorner& b) {
    if (a.score != b.score) return a.score > b.score;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  };
  std::erase_if(corners_, [&](const FastCorner& corner) {
    return mask_.at<unsigned char>(corner.y, corner.x) == 0;
  });
  const auto tried = static_cast<std::ptrdiff_t>(std::min(kMaxTried, corners_.size()));
  std::partial_sort(corners_.begin(), corners_.begin() + tried, corners_.end(), stronger);
  best.strength = 0;
  for (auto corner = corners_.begin(); corner != corners_.begin() + tried; ++corner) {
    const auto x = static_cast<float>(corner->x), y = static_cast<float>(corner->y);
    PatchTemplate& patch = scratch_.levels.front();
    tracker_.ExtractLevel(level, x, y, patch);
    if (!patch.is_valid || patch.min_eigenvalue <= best.strength) continue;
    best.strength = patch.min_eigenvalue;
    best.px = Vector2d(x, y);
  }
  return best.strength >= options_.min_eigenvalue;
}

bool FeatureDetector::SearchCell(const ImageLevel& level, const cv::Rect& cell, int threshold) {
  const std::span<const FastCorner> found = fast_.Find(level, cell, threshold);
  corners_.assign(found.begin(), found.end());
  Candidate best;
  if (BestCorner(level, best)) candidates_.push_back(best);
  return !corners_.empty();
}

void FeatureDetector::ListEmptyCells(const cv::Mat& image, std::span<const Vector2d> occupied) {
  empty_cells_.clear();
  const int cell = options_.cell_px;
  const int columns = NumCellsAlong(image.cols, cell), rows = NumCellsAlong(image.rows, cell);
  // The grid is centred; what does not fill a cell widens the border.
  const int left = (image.cols - columns * cell) / 2, top = (image.rows - rows * cell) / 2;
  taken_.assign(static_cast<std::size_t>(columns * rows), 0);
  for (const Vector2d& p : occupied) {
    if (p.x() < left || p.y() < top) continue;
    if (p.x() >= left + columns * cell || p.y() >= top + rows * cell) continue;
    const int c = (static_cast<int>(p.x()) - left) / cell,
              r = (static_cast<int>(p.y()) - top) / cell;
    taken_[static_cast<std::size_t>(r * columns + c)] = 1;
  }
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      if (taken_[static_cast<std::size_t>(r * columns + c)] != 0) continue;
      empty_cells_.emplace_back(left + c * cell, top + r * cell, cell, cell);
    }
  }
}

std::span<const Vector2d> FeatureDetector::Detect(const cv::Mat& image,
                                                  const ImageLevel& level,
                                                  std::span<const Vector2d> occupied,
                                                  int max_points) {
  points_.clear();
  candidates_.clear();
  if (max_points <= 0 || level.width < FastCorners::kMinWidth) return points_;
  MarkOccupied(image, occupied);
  ListEmptyCells(image, occupied);
  std::erase_if(empty_cells_, [&](const cv::Rect& cell) {
    return SearchCell(level, cell, options_.fast_threshold);
  });
  // Weaker corners are only needed where there are not enough strong ones.
  if (static_cast<int>(candidates_.size()) < max_points) {
    for (const cv::Rect& cell : empty_cells_) {
      SearchCell(level, cell, kWeakFastThreshold);
    }
  }
  // Stable: equal strengths stay in the order of the cells.
  std::stable_sort(candidates_.begin(),
                   candidates_.end(),
                   [](const Candidate& a, const Candidate& b) { return a.strength > b.strength; });
  const double min_distance2 = options_.min_distance_px * options_.min_distance_px;
  for (const Candidate& candidate : candidates_) {
    if (static_cast<int>(points_.size()) == max_points) break;
    const bool too_close = std::any_of(points_.begin(), points_.end(), [&](const Vector2d& p) {
      return (p - candidate.px).squaredNorm() < min_distance2;
    });
    if (!too_close) points_.push_back(candidate.px);
  }
  return points_;
}

}  // namespace facet
