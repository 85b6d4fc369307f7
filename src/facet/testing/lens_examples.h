// SPDX-License-Identifier: BSD-2-Clause
// One camera of each lens model, with coefficients as calibrations find them. All of them see 0.9
// of their images' width and 47 deg from the axis.
#pragma once

#include <algorithm>
#include <vector>

#include "facet/camera/camera_intrinsics.h"

namespace facet::testing {

inline std::vector<CameraIntrinsics> LensExamples() {
  return {
      {640, 480, 500, 510, 320, 240, DistortionModel::kNone, {}},
      {752,
       480,
       458.654,
       457.296,
       367.215,
       248.375,
       DistortionModel::kRadialTangential,
       {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}},
      {752,
       480,
       330.0,
       329.0,
       367.215,
       248.375,
       DistortionModel::kEquidistant,
       {0.0034, 0.0008, -0.0024, 0.0003}},
      {1280,
       720,
       612.3,
       612.1,
       637.9,
       367.2,
       DistortionModel::kRational,
       {0.42, -2.51, 0.0006, -0.0003, 1.42, 0.3, -2.34, 1.35}},
      // OpenCV's five, as of a moderately wide lens.
      {848,
       480,
       425.0,
       424.0,
       420.5,
       238.25,
       DistortionModel::kRational,
       {-0.05, 0.06, 0.0005, 0.0007, -0.02, 0, 0, 0}},
      {640, 480, 310, 311, 322, 238, DistortionModel::kFieldOfView, {0.93}},
      {360, 360, 158.3, 158.3, 180.4, 178.9, DistortionModel::kDoubleSphere, {-0.172, 0.594}},
      {640, 480, 290, 291, 318, 243, DistortionModel::kExtendedUnified, {0.62, 1.08}},
      {752,
       480,
       905,
       903,
       370,
       246,
       DistortionModel::kUnified,
       {-0.12, 0.09, 0.0006, -0.0004, 1.75}},
  };
}

/// The first of that model.
inline CameraIntrinsics LensExample(DistortionModel model) {
  const std::vector<CameraIntrinsics> all = LensExamples();
  return *std::find_if(
      all.begin(), all.end(), [&](const auto& k) { return k.distortion == model; });
}

}  // namespace facet::testing
