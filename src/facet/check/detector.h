// SPDX-License-Identifier: BSD-2-Clause
// One kind of defect, or a few that show in the same quantities, sought in a recording that passes
// by once. docs/check.md lists the defects.
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/check/finding.h"
#include "facet/recording/recording.h"

namespace facet {

/// A left image that was decoded, and now and then its right one.
struct ImagePair {
  Timestamp t;
  cv::Mat left;   ///< never empty; new pixels every time
  cv::Mat right;  ///< empty where it was not decoded or there is none
  /// Whether the frame before was looked at, too: otherwise a new stretch begins.
  bool follows = false;
};

/// Keeps a bounded amount of what it has seen. Not thread-safe.
class Detector {
 public:
  virtual ~Detector() = default;

  /// In order of time; stamps are on the camera's clock, as the calibration says.
  virtual void OnImu(const ImuSample& /*sample*/) {}
  virtual void OnFrame(const RecordedFrame& /*frame*/) {}
  /// Behind OnFrame, of frames that are looked at.
  virtual void OnImages(const ImagePair& /*pair*/) {}
  /// Adds what was found, and what could not be judged.
  virtual void Finish(CheckReport& report) = 0;
};

/// All there are, in the order in which they report. `calibration` may be null: then those that
/// need one are left out. It must live as long as they do.
std::vector<std::unique_ptr<Detector>> MakeDetectors(const Calibration* calibration);

}  // namespace facet
