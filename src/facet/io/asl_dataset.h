// SPDX-License-Identifier: BSD-2-Clause
// A stereo-inertial recording in the ASL/EuRoC layout. Ground truth is not touched.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/io/calibration_file.h"
#include "facet/io/image_reader.h"

namespace facet {

/// One left image and the right image of the same moment.
struct FrameEntry {
  Timestamp t;        ///< of the left image
  std::string left;   ///< file name in cam0/data
  std::string right;  ///< file name in cam1/data; empty: a mono frame
  bool HasRight() const { return !right.empty(); }
};

/// Everything but the pixels is read when it is opened (some 100 bytes per image and sample);
/// images are decoded one pair at a time. Not thread-safe.
class AslDataset {
 public:
  /// `sequence` is the folder that holds mav0/, or mav0/ itself.
  ///
  /// Left and right images are paired by stamp (nearest, within an eighth of the frame interval).
  /// Images that are listed but not there count as missing. A left image without a right one is a
  /// mono frame, frames begin with the first full pair. Throws InputError when the recording cannot
  /// be used: folders or files missing or empty, no calibration, no pair, not one pair of readable
  /// images of the calibrated size, stamps of camera and IMU that do not overlap. Everything
  /// smaller is a warning.
  explicit AslDataset(const std::filesystem::path& sequence,
                      const CalibrationFiles& calibration = {});

  const std::string& name() const { return name_; }  ///< of the folder, for example MH_01_easy
  const Calibration& calibration() const { return calibration_; }
  const StereoRig& rig() const { return calibration_.rig; }
  const ImuNoise& imu_noise() const { return calibration_.imu_noise; }
  const std::string& calibration_source() const { return calibration_.source; }
  const std::vector<FrameEntry>& frames() const { return frames_; }
  const std::vector<ImuSample>& imu() const { return imu_; }  ///< IMU clock
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Decodes pair `i` into 8-bit grey images of the calibrated size. Throws InputError when the
  /// left image is unusable. An unusable or absent right image leaves `right` empty; the returned
  /// text says what is wrong with it and is empty when it is fine or not in the recording.
  std::string ReadPair(std::size_t i, cv::Mat& left, cv::Mat& right);

  /// Where an image of camera 0 or 1 lies.
  std::filesystem::path ImagePath(int camera, const std::string& file) const {
    return DataFolder(camera) / file;
  }

 private:
  void PairImages();
  void RequireReadablePair();
  void CheckOverlap();
  void ReadImage(int camera, const std::string& file, cv::Mat& image);
  std::filesystem::path DataFolder(int camera) const;

  std::filesystem::path mav0_;
  std::string name_;
  Calibration calibration_;
  std::vector<FrameEntry> frames_;
  std::vector<ImuSample> imu_;
  std::vector<std::string> warnings_;
  ImageReader reader_;
};

/// The mav0 folder of a sequence, given either. Throws InputError when there is none.
std::filesystem::path FindMav0(const std::filesystem::path& sequence);

/// Ground truth of a sequence: state_groundtruth_estimate0, mocap0 or vicon0; empty path if none.
std::filesystem::path FindTruth(const std::filesystem::path& sequence);

/// The same for programs that cannot do without: throws InputError if there is none.
std::filesystem::path RequireTruth(const std::filesystem::path& sequence);

}  // namespace facet
