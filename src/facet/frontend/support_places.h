// SPDX-License-Identifier: BSD-2-Clause
// Chooses where the mesh needs more points than the tracked corners, and what depth to expect
// there: the tracks of this keyframe span triangles, which predict the depth between them.
#pragma once

#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/depth_query.h"
#include "facet/frontend/frontend_options.h"
#include "facet/geometry/delaunay.h"
#include "facet/map/observation.h"

namespace facet {

/// Not thread-safe; keeps its buffers.
class SupportPlaces {
 public:
  explicit SupportPlaces(const SupportPointOptions& options) : options_(options) {}

  /// At most one place for each cell of the image that holds no feature: the one with the strongest
  /// contrast along the rows, if that is enough. `inverse_distances`: of the features, 0 where not
  /// known. The result is valid until the next call.
  const std::vector<DepthQuery>& Choose(const cv::Mat& left,
                                        std::span<const FeatureObservation> features,
                                        std::span<const double> inverse_distances);

 private:
  void MarkOccupied(std::span<const FeatureObservation> features);
  void FindPlaces(const cv::Mat& left);
  Vector2d StrongestPlace(const cv::Mat& left, const cv::Rect& cell);
  void FillDifferences(const cv::Mat& left, const cv::Point& first, int width, int height);
  void PredictDepths(std::span<const FeatureObservation> features,
                     std::span<const double> inverse_distances);
  void PredictOutside();
  void PredictInside(const std::array<Vector2d, 3>& px, const std::array<double, 3>& depths);

  /// A place in the left image whose inverse distance [1/m] is known.
  struct KnownDepth {
    Vector2d px = Vector2d::Zero();
    double inverse_distance = 0;
  };

  SupportPointOptions options_;
  int columns_ = 0, rows_ = 0;
  int turn_ = 0;                   // which cells of the chessboard are next
  std::vector<char> is_occupied_;  // by cell
  std::vector<int> place_;         // by cell; index into queries_ or -1
  std::vector<DepthQuery> queries_;
  std::vector<std::uint8_t> differences_;  // buffers of StrongestPlace
  std::vector<int> column_sums_;
  Delaunay delaunay_;
  std::vector<GridPoint> grid_;
  std::vector<KnownDepth> known_;
};

}  // namespace facet
