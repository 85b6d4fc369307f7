// SPDX-License-Identifier: BSD-2-Clause
#include "start_trouble.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "facet/base/median.h"

namespace facet {

namespace {

constexpr int kSamplesPerSide = 40;
constexpr double kDarkMean = 12;       // grey values; black with some noise
constexpr double kFlatDeviation = 2;   // grey values; noise alone
constexpr int kSmallestSide_px = 100;  // below it hardly a patch fits between the borders
constexpr double kFewTracks = 12;      // what a start needs at least

// Reasons without their figures, so that they can be counted.
std::string KindOf(const std::string& reason) {
  return reason.substr(0, reason.find_first_of("0123456789"));
}

// What to do about a reason that the estimator gave.
std::string AdviceFor(const std::string& reason, bool has_tracks) {
  const auto is = [&](const char* begin) { return reason.starts_with(begin); };
  if (is("collecting frames")) return "the part of the recording is too short";
  if (is("no IMU") || is("too little IMU"))
    return "check the IMU's stamps and its clock against the cameras'";
  if (is("gravity")) {
    return "check the units of the IMU (m/s^2, rad/s), T_BS or T_cam_imu, the baseline, and "
           "estimator.imu.gravity_mps2 if this is not on Earth";
  }
  if (is("too few") && has_tracks) {
    return "the left images have corners, but the right ones do not show them where the "
           "calibration "
           "says: cameras swapped, calibration of another rig, or right images missing";
  }
  if (is("too few")) return "the images show too few corners: blurred, or without texture";
  return "too few landmarks, or an IMU much noisier than its calibration says";
}

}  // namespace

ImageLook ImageLook::Of(const cv::Mat& image) {
  ImageLook look;
  if (image.empty() || image.type() != CV_8UC1) return look;
  std::array<int, 256> counts{};
  const int step_x = std::max(1, image.cols / kSamplesPerSide);
  const int step_y = std::max(1, image.rows / kSamplesPerSide);
  double num = 0, sum = 0, squares = 0;
  for (int y = step_y / 2; y < image.rows; y += step_y) {
    for (int x = step_x / 2; x < image.cols; x += step_x) {
      const int value = image.at<std::uint8_t>(y, x);
      ++counts[static_cast<std::size_t>(value)];
      num += 1;
      sum += value;
      squares += value * value;
    }
  }
  const double mean = sum / num;
  look.is_dark = mean < kDarkMean;
  look.has_contrast = std::sqrt(std::max(squares / num - mean * mean, 0.0)) > kFlatDeviation;
  look.has_two_values = std::ranges::count_if(counts, [](int n) { return n > 0; }) == 2;
  return look;
}

void StartTrouble::Camera::Add(const cv::Mat& image) {
  const ImageLook look = ImageLook::Of(image);
  ++num;
  num_dark += look.is_dark ? 1 : 0;
  num_flat += !look.is_dark && !look.has_contrast ? 1 : 0;
  num_two_valued += look.has_contrast && look.has_two_values ? 1 : 0;
}

// What is wrong with most images of the camera.
std::string StartTrouble::Camera::Explain(const std::string& name) const {
  const auto share = [&](int n) {
    return std::to_string(n) + " of " + std::to_string(num) + " " + name + " images ";
  };
  if (2 * num_dark > num)
    return share(num_dark) + "are black or nearly so; check exposure, light and lens cap";
  if (2 * num_flat > num) {
    return share(num_flat) + "have no texture, one grey value nearly everywhere; " +
           "check exposure and focus";
  }
  if (2 * num_two_valued > num)
    return share(num_two_valued) + "have two grey values only; 8-bit grey or colour is expected";
  return {};
}

void StartTrouble::AddImages(const StereoFrame& frame) {
  if (has_started_) return;
  left_.Add(frame.left);
  size_ = frame.left.size();
  if (!frame.right.empty()) right_.Add(frame.right);
}

void StartTrouble::AddOutput(const VioOutput& output) {
  has_started_ = has_started_ || output.has_pose;
  if (has_started_) return;
  newest_reason_ = output.reason;
  ++reasons_[KindOf(output.reason)];
  num_tracks_.push_back(output.num_tracks);
}

std::string StartTrouble::ExplainImages() const {
  for (const std::string& trouble : {left_.Explain("left"), right_.Explain("right")}) {
    if (!trouble.empty()) return trouble;
  }
  if (right_.num == 0) return "there are no right images; a start needs stereo pairs";
  if (std::min(size_.width, size_.height) < kSmallestSide_px) {
    return "the images have " + std::to_string(size_.width) + " x " + std::to_string(size_.height) +
           " pixels, too few to track corners in";
  }
  return {};
}

// Every start begins by collecting frames.
std::string StartTrouble::MostFrequentReason() const {
  std::string most = "collecting frames";
  int num = 0;
  for (const auto& [reason, count] : reasons_) {
    if (reason == "collecting frames" || count <= num) continue;
    most = reason;
    num = count;
  }
  // With its figures.
  return KindOf(newest_reason_) == most ? newest_reason_ : most;
}

std::string StartTrouble::Explain() const {
  const std::string reason = MostFrequentReason();
  const std::string images =
      reason.find("IMU") == std::string::npos || reason.starts_with("gravity") ? ExplainImages()
                                                                               : std::string();
  std::vector<double> num_tracks = num_tracks_;
  const bool has_tracks = Median(num_tracks).value_or(0) >= kFewTracks;
  return reason + "; " +
         (images.empty() ? AdviceFor(reason, has_tracks) + ". Or try another --start" : images);
}

}  // namespace facet
