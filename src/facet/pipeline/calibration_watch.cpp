// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/calibration_watch.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace facet {
namespace {

constexpr Duration kStretch{3'000'000'000};
constexpr double kAgreement = 0.75;
constexpr std::size_t kMinKeyframes = 8;
// Too few corners say nothing about the rest of the image.
constexpr int kMinFeatures = 15;
// Far below what good recordings have (frontend_report prints it), far above what wrong extrinsics
// leave (wrong_calibration_test).
constexpr double kMinStereoShare = 0.1;
// No wrong pair has so many.
constexpr double kRightStereoShare = 0.3;
// A good calibration is at about 1; wrong_calibration_test has those that must be beyond.
constexpr double kMaxImuErrorSigma = 5;

// A calibration that was right does not become wrong but by a knock.
std::string StereoWarning(double share, bool was_right) {
  const std::string found = "for 3 s only " + std::to_string(std::lround(100 * share)) +
                            " % of the corners were found in the right image";
  if (was_right) {
    return found +
           ", where more were found before: is the right camera covered, frozen, out of "
           "step, or was it knocked?";
  }
  return found +
         ": are the cameras swapped (cam0 is the left one), is a T_BS inverted (it takes "
         "points from the camera to the IMU), or is the right camera covered or out of step?";
}

// Nobody needs to know more than that it is far too much.
std::string Times(double sigma) {
  return sigma < 100 ? std::to_string(std::lround(sigma)) : "more than 100";
}

std::string ImuWarning(double sigma) {
  return "for 3 s the IMU contradicted the images by " + Times(sigma) +
         " times its noise: is the time offset wrong (timeshift_cam_imu: t_imu - t_camera in "
         "seconds), is a T_BS inverted (it takes points from the camera to the IMU), or are the "
         "IMU's units or axes not as expected (rad/s, m/s^2; at rest it measures +9.8 upwards)?";
}

}  // namespace

void CalibrationWatch::RecentValues::Add(Timestamp t, double value) {
  if (!values_.empty() && (t <= values_.back().t || t - values_.back().t > kStretch)) {
    values_.clear();
  }
  if (values_.empty()) begin_ = t;
  values_.push_back({t, value});
  while (t - values_.front().t > kStretch)
    values_.pop_front();
}

std::optional<double> CalibrationWatch::RecentValues::Quantile(double share) const {
  if (values_.size() < kMinKeyframes || values_.back().t - begin_ < kStretch) return std::nullopt;
  std::vector<double> values;
  for (const Value& v : values_)
    values.push_back(v.value);
  const double rank = share * static_cast<double>(values.size() - 1);
  const auto place = values.begin() + std::lround(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

std::string CalibrationWatch::Add(const CalibrationEvidence& evidence) {
  std::string warning = FromStretch(evidence);
  if (!warning.empty()) return warning;
  bool is_new = false;
  for (const CalibrationDeviation& deviation : evidence.gross_deviations)
    is_new |= named_.insert(deviation.part).second;
  if (!is_new) return {};
  return "the calibration is off by more than a careful one is: " +
         InWords(evidence.gross_deviations) +
         "; this was estimated and the run goes on with it, but calibrate again";
}

std::string CalibrationWatch::FromStretch(const CalibrationEvidence& evidence) {
  if (evidence.num_stereo && evidence.num_features >= kMinFeatures) {
    stereo_share_.Add(evidence.t,
                      static_cast<double>(*evidence.num_stereo) / evidence.num_features);
  }
  if (evidence.imu_error_sigma) imu_error_sigma_.Add(evidence.t, *evidence.imu_error_sigma);
  const auto share = stereo_share_.Quantile(kAgreement);
  const auto sigma = imu_error_sigma_.Quantile(1 - kAgreement);
  // The images alone come first: what is wrong between them also makes them contradict the IMU.
  std::string warning;
  const bool is_one_eyed = share && *share < kMinStereoShare;
  if (share && *share > kRightStereoShare) was_stereo_right_ = true;
  if (is_one_eyed) {
    warning = StereoWarning(*share, was_stereo_right_);
  } else if (sigma && *sigma > kMaxImuErrorSigma) {
    warning = ImuWarning(*sigma);
  }
  return stretches_.Begins(evidence.t, !warning.empty()) ? warning : std::string();
}

std::string ContradictionWarning(double sigma) {
  return "the IMU and the images contradicted each other by " + Times(sigma) +
         " times the IMU's noise: did something large move in front of the cameras, or did a "
         "sensor fail for a moment? From there on the sigmas contain what they differed by";
}

}  // namespace facet
