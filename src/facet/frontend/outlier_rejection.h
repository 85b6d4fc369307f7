// SPDX-License-Identifier: BSD-2-Clause
// Two-point RANSAC for the direction of translation with the rotation from the gyroscope, which is
// refined together with it: before its bias is known the gyroscope is wrong by several pixels.
#pragma once

#include <span>
#include <vector>

#include "facet/base/random.h"
#include "facet/base/types.h"
#include "facet/frontend/frontend_options.h"

namespace facet {

/// One point seen from two places, as unit bearings in the same orientation (known rotation
/// removed).
struct BearingPair {
  Vector3d before;
  Vector3d now;
};

enum class OutlierVerdict {
  kTrusted,      ///< `is_outlier` is meaningful
  kFewPoints,    ///< too few pairs to tell
  kLowParallax,  ///< the camera hardly moved; every point agrees with some translation
  kNoModel,      ///< no translation explains enough of the pairs (for example a wrong rotation)
};

/// Not thread-safe. Deterministic: every call starts from the same seed.
class OutlierRejection {
 public:
  /// Bearings are compared in pixels of this focal length.
  OutlierRejection(const OutlierOptions& options, double focal_px)
      : options_(options), focal_px_(focal_px), max_angle_(options.max_error_px / focal_px) {}

  /// Finds the pairs that contradict the common translation. Unless the verdict is kTrusted nothing
  /// is marked as an outlier.
  OutlierVerdict Find(std::span<const BearingPair> pairs, std::vector<unsigned char>& is_outlier);

 private:
  /// `now` turned by `turn` and `before` lie in a plane with the translation `t` (unit length).
  struct Model {
    Quaterniond turn = Quaterniond::Identity();
    Vector3d t = Vector3d::UnitX();
    int num_inliers = 0;
  };

  /// The best translation for a fixed rotation.
  Model SampleTranslation(std::span<const BearingPair> pairs, const Quaterniond& turn) const;
  /// The rotation that explains the pairs best without any translation.
  Quaterniond AlignBearings(std::span<const BearingPair> pairs) const;
  void Refine(std::span<const BearingPair> pairs, Model& model) const;
  int CountInliers(std::span<const BearingPair> pairs, const Model& model) const;
  double MedianParallaxPx(std::span<const BearingPair> pairs, const Quaterniond& turn);

  OutlierOptions options_;
  double focal_px_;
  double max_angle_;
  std::vector<double> parallax_px_;
};

}  // namespace facet
