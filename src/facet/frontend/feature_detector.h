// SPDX-License-Identifier: BSD-2-Clause
// New points where the image has corners and no tracks.
#pragma once

#include <span>
#include <vector>

#include "facet/base/types.h"
#include "facet/frontend/fast_corners.h"
#include "facet/frontend/patch_tracker.h"

namespace facet {

/// So many corners an image of this size has at most: one per grid cell.
int NumCells(const cv::Size& image, const DetectorOptions& options);

/// One corner per empty grid cell, best first. Keeps its buffers; not thread-safe.
class FeatureDetector {
 public:
  /// The strength of a corner is how well a tracker with these options can locate it.
  FeatureDetector(const DetectorOptions& options, const KltOptions& klt);

  /// At most max_points corners of the image, each at least min_distance_px from the `occupied`
  /// points and from each other; the result is valid until the next call. `level`: the same pixels
  /// as a level of a pyramid.
  std::span<const Vector2d> Detect(const cv::Mat& image,
                                   const ImageLevel& level,
                                   std::span<const Vector2d> occupied,
                                   int max_points);

 private:
  struct Candidate {
    Vector2d px;
    float strength = 0;
  };

  void MarkOccupied(const cv::Mat& image, std::span<const Vector2d> occupied);
  void ListEmptyCells(const cv::Mat& image, std::span<const Vector2d> occupied);
  /// Adds the cell's best corner to candidates_. False: there was no corner at all to choose from.
  bool SearchCell(const ImageLevel& level, const cv::Rect& cell, int threshold);
  bool BestCorner(const ImageLevel& level, Candidate& best);

  DetectorOptions options_;
  PatchTracker tracker_;
  cv::Mat mask_;                      // 255 where a new point may be
  std::vector<unsigned char> taken_;  // by cell
  std::vector<cv::Rect> empty_cells_;
  FastCorners fast_;
  std::vector<FastCorner> corners_;
  std::vector<Candidate> candidates_;
  std::vector<Vector2d> points_;
  PatchPyramid scratch_;  // one level
};

}  // namespace facet
