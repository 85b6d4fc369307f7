// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/support_points.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace facet {
namespace {

constexpr int kBorder_px = 10;
constexpr int kStep_px = 4;   // between the places that are tried
constexpr int kReach_px = 4;  // half the side of the window whose contrast counts

/// Mean difference between pixels two apart along the rows, in a window.
int Contrast(const cv::Mat& image, int x, int y) {
  int sum = 0;
  for (int dy = -kReach_px; dy <= kReach_px; dy += 2) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y + dy) + x;
    for (int dx = -kReach_px; dx <= kReach_px; dx += 2)
      sum += std::abs(row[dx + 1] - row[dx - 1]);
  }
  return sum;
}

constexpr int kNumDifferences = 25;

}  // namespace

void SupportPlaces::MarkOccupied(std::span<const FeatureObservation> features) {
  is_occupied_.assign(static_cast<std::size_t>(columns_ * rows_), 0);
  const double cell = options_.cell_px;
  for (const FeatureObservation& feature : features) {
    const int column = static_cast<int>(feature.px_left.x() / cell);
    const int row = static_cast<int>(feature.px_left.y() / cell);
    if (column >= 0 && row >= 0 && column < columns_ && row < rows_)
      is_occupied_[row * columns_ + column] = 1;
  }
}

void SupportPlaces::FindPlaces(const cv::Mat& left) {
  queries_.clear();
  turn_ = 1 - turn_;
  place_.assign(is_occupied_.size(), -1);
  const int cell = options_.cell_px;
  for (int i = 0; i < columns_ * rows_; ++i) {
    if (is_occupied_[i] != 0 || (i % columns_ + i / columns_ + turn_) % 2 != 0) continue;
    const int x0 = std::max(i % columns_ * cell, kBorder_px);
    const int y0 = std::max(i / columns_ * cell, kBorder_px);
    const int x1 = std::min(i % columns_ * cell + cell, left.cols - kBorder_px);
    const int y1 = std::min(i / columns_ * cell + cell, left.rows - kBorder_px);
    int best = static_cast<int>(options_.min_contrast * kNumDifferences);
    Vector2d px(-1, -1);
    for (int y = y0 + kStep_px / 2; y < y1; y += kStep_px) {
      for (int x = x0 + kStep_px / 2; x < x1; x += kStep_px) {
        const int contrast = Contrast(left, x, y);
        if (contrast <= best) continue;
        best = contrast;
        px = Vector2d(x, y);
      }
    }
    if (px.x() < 0) continue;
    place_[i] = static_cast<int>(queries_.size());
    queries_.push_back({px, {}, 0});
  }
}

// The inverse depth is linear over a plane in the (undistorted) image. The distortion inside one
// triangle is neglected: this is only where the search begins.
void SupportPlaces::PredictInside(const std::array<Vector2d, 3>& px,
                                  const std::array<double, 3>& depths) {
  const double cell = options_.cell_px;
  const Vector2d low = px[0].cwiseMin(px[1]).cwiseMin(px[2]) / cell;
  const Vector2d high = px[0].cwiseMax(px[1]).cwiseMax(px[2]) / cell;
  const Vector2d u = px[1] - px[0], v = px[2] - px[0];
  const double area = u.x() * v.y() - u.y() * v.x();
  if (!(area > 0)) return;
  const auto [nearest, farthest] = std::minmax_element(depths.begin(), depths.end());
  for (int row = std::max(0, static_cast<int>(low.y()));
       row <= std::min(rows_ - 1, static_cast<int>(high.y()));
       ++row) {
    for (int column = std::max(0, static_cast<int>(low.x()));
         column <= std::min(columns_ - 1, static_cast<int>(high.x()));
         ++column) {
      const int place = place_[row * columns_ + column];
      if (place < 0) continue;
      DepthQuery& query = queries_[place];
      const Vector2d d = query.px - px[0];
      const double b1 = (d.x() * v.y() - d.y() * v.x()) / area;
      const double b2 = (u.x() * d.y() - u.y() * d.x()) / area;
      if (b1 < 0 || b2 < 0 || b1 + b2 > 1) continue;
      query.inverse_depths = {
          depths[0] + b1 * (depths[1] - depths[0]) + b2 * (depths[2] - depths[0]),
          *farthest,
          *nearest};
      query.num_depths = *farthest - *nearest > options_.min_depth_step ? 3 : 1;
    }
  }
}

void SupportPlaces::PredictDepths(std::span<const FeatureObservation> features,
                                  std::span<const double> inverse_depths) {
  constexpr double kGridPerPixel = 16;
  grid_.clear();
  known_.clear();
  for (std::size_t i = 0; i < std::min(features.size(), inverse_depths.size()); ++i) {
    if (!(inverse_depths[i] > 0)) continue;
    known_.push_back(static_cast<int>(i));
    const Vector2d place = features[i].px_left * kGridPerPixel;
    grid_.push_back({static_cast<std::int32_t>(std::lround(place.x())),
                     static_cast<std::int32_t>(std::lround(place.y()))});
  }
  for (const auto& [a, b, c] : delaunay_.Triangulate(grid_)) {
    const int i = known_[a], j = known_[b], k = known_[c];
    PredictInside({features[i].px_left, features[j].px_left, features[k].px_left},
                  {inverse_depths[i], inverse_depths[j], inverse_depths[k]});
  }
}

const std::vector<DepthQuery>& SupportPlaces::Choose(const cv::Mat& left,
                                                     std::span<const FeatureObservation> features,
                                                     std::span<const double> inverse_depths) {
  columns_ = (left.cols + options_.cell_px - 1) / options_.cell_px;
  rows_ = (left.rows + options_.cell_px - 1) / options_.cell_px;
  MarkOccupied(features);
  FindPlaces(left);
  PredictDepths(features, inverse_depths);
  std::erase_if(queries_, [](const DepthQuery& query) { return query.num_depths == 0; });
  return queries_;
}

}  // namespace facet
