// SPDX-License-Identifier: BSD-2-Clause
// Why a run has no pose: what its images look like and what the estimator said of each frame.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/frontend/stereo_frontend.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

/// What a few hundred pixels of an image tell.
struct ImageLook {
  bool is_dark = false;
  bool has_contrast = true;
  bool has_two_values = false;  ///< and no others: one bit per pixel

  static ImageLook Of(const cv::Mat& image);
};

/// Watches the frames up to the first pose. Not thread-safe.
class StartTrouble {
 public:
  /// Each pair that is handed to the estimator. Costs nothing after the first pose.
  void AddImages(const StereoFrame& frame);
  /// What the estimator said of the next of them.
  void AddOutput(const VioOutput& output);

  /// What was in the way most of the time, with figures, and what to do about it. For a run without
  /// a pose.
  std::string Explain() const;

 private:
  struct Camera {
    int num = 0, num_dark = 0, num_flat = 0, num_two_valued = 0;
    void Add(const cv::Mat& image);
    std::string Explain(const std::string& name) const;
  };
  std::string ExplainImages() const;
  std::string MostFrequentReason() const;

  bool has_started_ = false;
  Camera left_, right_;
  cv::Size size_;
  std::map<std::string, int> reasons_;  // without their figures
  std::string newest_reason_;
  std::vector<double> num_tracks_;  // per frame
};

}  // namespace facet
