// SPDX-License-Identifier: BSD-2-Clause
// Two-point RANSAC for the direction of translation, rotation known.
#pragma once

#include <span>
#include <vector>

#include "facet/base/random.h"
#include "facet/base/types.h"
#include "facet/frontend/frontend_options.h"

namespace facet {

/// One point seen from two places, as unit bearings in the same orientation (rotation removed).
struct BearingPair {
  Vector3d before;
  Vector3d now;
};

enum class OutlierVerdict {
  kTrusted,        ///< `is_outlier` is meaningful
  kFewPoints,      ///< too few pairs to tell
  kLowParallax,    ///< the camera hardly moved; every point agrees with some translation
  kNoModel,        ///< no translation explains enough of the pairs (for example a wrong rotation)
};

/// Not thread-safe. Deterministic: every call starts from the same seed.
class OutlierRejection {
 public:
  /// Bearings are compared in pixels of this focal length.
  OutlierRejection(const OutlierOptions& options, double focal_px)
      : options_(options), focal_px_(focal_px) {}

  /// Finds the pairs that contradict the common translation. Unless the verdict is kTrusted nothing is
  /// marked as an outlier.
  OutlierVerdict Find(std::span<const BearingPair> pairs, std::vector<unsigned char>& is_outlier);

 private:
  int CountInliers(std::span<const BearingPair> pairs, const Vector3d& direction) const;
  Vector3d Refine(std::span<const BearingPair> pairs, const Vector3d& direction) const;

  OutlierOptions options_;
  double focal_px_;
  std::vector<double> parallax_px_;
};

}  // namespace facet
