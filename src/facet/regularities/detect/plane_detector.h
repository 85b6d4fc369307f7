// SPDX-License-Identifier: BSD-2-Clause
// Planes among the faces of the mesh, without iterating over hypotheses (paper II-A.3): level
// planes from a histogram of heights, upright ones from a histogram of azimuth and distance, any
// others by growing regions.
#pragma once

#include <vector>

#include "facet/regularities/detect/plane_candidate.h"
#include "facet/regularities/detect/plane_votes.h"

namespace facet {

/// Keeps its storage. Not thread-safe.
class PlaneDetector {
 public:
  explicit PlaneDetector(const DetectionOptions& options) : options_(options) {}

  /// Planes among the faces that may vote, are in view (unless all are searched) and not `taken`
  /// (one flag per face). Faces of one candidate are in no other.
  std::vector<PlaneCandidate> Detect(const SurfaceFaces& faces, const std::vector<char>& taken);

 private:
  void FindLevel(const SurfaceFaces& faces, int layer, std::vector<PlaneCandidate>& out);
  void FindUpright(const SurfaceFaces& faces, int layer, std::vector<PlaneCandidate>& out);
  void FindOblique(const SurfaceFaces& faces, std::vector<PlaneCandidate>& out);
  /// Has the faces marked in `has_voted_` vote, and accepts what stands behind the highest peaks.
  template <class Votes, class Vote>
  void TakePeaks(const SurfaceFaces& faces,
                 Votes& histogram,
                 const Vote& vote,
                 std::vector<PlaneCandidate>& out);
  /// The free faces; keeps what passes and marks its faces. Returns all faces near the plane.
  std::vector<int> Accept(const SurfaceFaces& faces,
                          const Plane& start,
                          double min_area_m2,
                          std::vector<PlaneCandidate>& out);

  DetectionOptions options_;
  std::vector<int> pool_;                // faces that may vote and are free
  std::vector<char> taken_, has_voted_;  // by face
  HeightVotes heights_;
  WallVotes walls_;
};

}  // namespace facet
