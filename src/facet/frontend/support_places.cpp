// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/support_places.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace facet {
namespace {

constexpr int kBorder_px = 10;
constexpr int kStep_px = 4;   // between the places that are tried
constexpr int kReach_px = 4;  // half the side of the window whose contrast counts

// The window is sampled at every second pixel of every second row.
constexpr int kSampling_px = 2;
constexpr int kWindow = 2 * kReach_px / kSampling_px + 1;  // samples along its side
static_assert(kStep_px == 2 * kSampling_px);
constexpr int kNumDifferences = kWindow * kWindow;

// [1/m]. A triangle whose corners differ by more is also searched around the nearest and the
// farthest of them: it may span a gap between surfaces.
constexpr double kMinDepthStep = 0.12;

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

// Sums of differences between pixels two apart along the rows, in windows around places kStep_px
// apart: first over the rows of each window, then over its columns.
Vector2d SupportPlaces::StrongestPlace(const cv::Mat& left, const cv::Rect& cell) {
  const int columns = (cell.width - kStep_px / 2 + kStep_px - 1) / kStep_px;
  const int rows = (cell.height - kStep_px / 2 + kStep_px - 1) / kStep_px;
  Vector2d strongest(-1, -1);
  if (columns <= 0 || rows <= 0) return strongest;
  const int width = 2 * (columns - 1) + kWindow;
  const int x0 = cell.x + kStep_px / 2, y0 = cell.y + kStep_px / 2;
  FillDifferences(left, {x0 - kReach_px, y0 - kReach_px}, width, 2 * (rows - 1) + kWindow);
  int best = static_cast<int>(options_.min_contrast * kNumDifferences);
  column_sums_.resize(static_cast<std::size_t>(width));
  for (int j = 0; j < rows; ++j) {
    const std::uint8_t* window = differences_.data() + 2 * j * width;
    for (int i = 0; i < width; ++i) {
      int sum = 0;
      for (int k = 0; k < kWindow; ++k)
        sum += window[k * width + i];
      column_sums_[i] = sum;
    }
    for (int i = 0; i < columns; ++i) {
      const int* sums = column_sums_.data() + 2 * i;
      const int contrast = std::accumulate(sums, sums + kWindow, 0);
      if (contrast <= best) continue;
      best = contrast;
      strongest = Vector2d(x0 + i * kStep_px, y0 + j * kStep_px);
    }
  }
  return strongest;
}

// At every second pixel of every second row, from `first` on.
void SupportPlaces::FillDifferences(const cv::Mat& left,
                                    const cv::Point& first,
                                    int width,
                                    int height) {
  differences_.resize(static_cast<std::size_t>(width * height));
  for (int j = 0; j < height; ++j) {
    const std::uint8_t* row = left.ptr<std::uint8_t>(first.y + j * kSampling_px) + first.x;
    std::uint8_t* differences = differences_.data() + j * width;
    for (int i = 0; i < width; ++i) {
      const int difference = row[kSampling_px * i + 1] - row[kSampling_px * i - 1];
      differences[i] = static_cast<std::uint8_t>(std::abs(difference));
    }
  }
}

void SupportPlaces::FindPlaces(const cv::Mat& left) {
  queries_.clear();
  turn_ = 1 - turn_;
  place_.assign(is_occupied_.size(), -1);
  const int side = options_.cell_px;
  const cv::Rect inside(
      kBorder_px, kBorder_px, left.cols - 2 * kBorder_px, left.rows - 2 * kBorder_px);
  for (int i = 0; i < columns_ * rows_; ++i) {
    if (is_occupied_[i] != 0 || (i % columns_ + i / columns_ + turn_) % 2 != 0) continue;
    const cv::Rect cell(i % columns_ * side, i / columns_ * side, side, side);
    const Vector2d px = StrongestPlace(left, cell & inside);
    if (px.x() < 0) continue;
    place_[i] = static_cast<int>(queries_.size());
    queries_.push_back({px, {}, 0});
  }
}

// The inverse distance of a plane is linear in the bearing. What the lens makes of that inside one
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
      query.inverse_distances = {
          depths[0] + b1 * (depths[1] - depths[0]) + b2 * (depths[2] - depths[0]),
          *farthest,
          *nearest};
      query.num_depths = *farthest - *nearest > kMinDepthStep ? 3 : 1;
    }
  }
}

// Corners keep away from the border of the image. What lies outside their hull is expected to be as
// far away as one of the three that are nearest to it.
void SupportPlaces::PredictOutside() {
  if (known_.size() < 3) return;
  for (DepthQuery& query : queries_) {
    if (query.num_depths > 0) continue;
    const auto is_nearer = [&](const KnownDepth& a, const KnownDepth& b) {
      return (a.px - query.px).squaredNorm() < (b.px - query.px).squaredNorm();
    };
    std::array<KnownDepth, 3> nearest;
    std::partial_sort_copy(known_.begin(), known_.end(), nearest.begin(), nearest.end(), is_nearer);
    const auto& [a, b, c] = nearest;
    query.inverse_distances = {a.inverse_distance, b.inverse_distance, c.inverse_distance};
    const auto [low, high] =
        std::minmax({a.inverse_distance, b.inverse_distance, c.inverse_distance});
    query.num_depths = high - low > kMinDepthStep ? 3 : 1;
  }
}

void SupportPlaces::PredictDepths(std::span<const FeatureObservation> features,
                                  std::span<const double> inverse_distances) {
  constexpr double kGridPerPixel = 16;
  known_.clear();
  grid_.clear();
  for (std::size_t i = 0; i < std::min(features.size(), inverse_distances.size()); ++i) {
    if (!(inverse_distances[i] > 0)) continue;
    known_.push_back({features[i].px_left, inverse_distances[i]});
    const Vector2d place = features[i].px_left * kGridPerPixel;
    grid_.push_back({static_cast<std::int32_t>(std::lround(place.x())),
                     static_cast<std::int32_t>(std::lround(place.y()))});
  }
  for (const auto& [a, b, c] : delaunay_.Triangulate(grid_)) {
    const KnownDepth &i = known_[a], &j = known_[b], &k = known_[c];
    PredictInside({i.px, j.px, k.px}, {i.inverse_distance, j.inverse_distance, k.inverse_distance});
  }
  PredictOutside();
}

const std::vector<DepthQuery>& SupportPlaces::Choose(const cv::Mat& left,
                                                     std::span<const FeatureObservation> features,
                                                     std::span<const double> inverse_distances) {
  columns_ = (left.cols + options_.cell_px - 1) / options_.cell_px;
  rows_ = (left.rows + options_.cell_px - 1) / options_.cell_px;
  MarkOccupied(features);
  FindPlaces(left);
  PredictDepths(features, inverse_distances);
  std::erase_if(queries_, [](const DepthQuery& query) { return query.num_depths == 0; });
  return queries_;
}

}  // namespace facet
