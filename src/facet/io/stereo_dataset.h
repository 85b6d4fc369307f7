// SPDX-License-Identifier: BSD-2-Clause
// A stereo-inertial recording of image files and a table of IMU samples, whatever the layout of its
// folders. Ground truth is not touched.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/io/asl_files.h"
#include "facet/io/calibration_file.h"
#include "facet/io/image_reader.h"

namespace facet {

/// One left image and the right image of the same moment.
struct FrameEntry {
  Timestamp t;        ///< of the left image
  Timestamp t_right;  ///< of the right image, if there is one
  std::string left;   ///< file name in the folder of the left camera
  std::string right;  ///< file name in the folder of the right camera; empty: a mono frame
  bool HasRight() const { return !right.empty(); }
};

/// The images of one camera.
struct ImageFolder {
  std::filesystem::path list;          ///< what names them, for messages: a file or a folder
  std::filesystem::path folder;        ///< that they lie in
  std::vector<ImageListEntry> images;  ///< stamps rise strictly
};

/// What a layout says, before it is known whether it fits together.
struct RecordingFiles {
  std::string name;
  std::array<ImageFolder, 2> cameras;  ///< left, right; none empty
  std::filesystem::path imu_file;      ///< for messages
  std::vector<ImuSample> imu;          ///< IMU clock, stamps rise strictly, not empty
  Calibration calibration;
  std::vector<std::string> warnings;
  StampCounts images_left_out, imu_left_out;  ///< images of both cameras
};

/// Everything but the pixels is in memory (some 100 bytes per image and sample); images are decoded
/// one pair at a time. Not thread-safe.
class StereoDataset {
 public:
  /// Left and right images are paired by stamp (nearest, within an eighth of the frame interval).
  /// Images that are listed but not there count as missing. A left image without a right one is a
  /// mono frame, frames begin with the first full pair. 16-bit PNG files of which only the lower 10
  /// or 12 bits are used, judged by ten of them, are scaled from those. Throws InputError when the
  /// recording cannot be used: no images, no pair, not one pair of readable images of the
  /// calibrated size, stamps of camera and IMU that do not overlap. Everything smaller is a
  /// warning.
  explicit StereoDataset(RecordingFiles files);

  const std::string& name() const { return files_.name; }
  const Calibration& calibration() const { return files_.calibration; }
  const StereoRig& rig() const { return calibration().rig; }
  const ImuNoise& imu_noise() const { return calibration().imu_noise; }
  const std::string& calibration_source() const { return calibration().source; }
  const std::vector<FrameEntry>& frames() const { return frames_; }
  const std::vector<ImuSample>& imu() const { return files_.imu; }  ///< IMU clock
  const std::vector<std::string>& warnings() const { return files_.warnings; }
  const StampCounts& images_left_out() const { return files_.images_left_out; }
  const StampCounts& imu_left_out() const { return files_.imu_left_out; }
  int sample_bits() const { return sample_bits_; }  ///< used of samples with 16: 10, 12 or 16

  /// Decodes pair `i` into 8-bit grey images of the calibrated size. Throws InputError when the
  /// left image is unusable. An unusable or absent right image leaves `right` empty; the returned
  /// text says what is wrong with it and is empty when it is fine or not in the recording.
  std::string ReadPair(std::size_t i, cv::Mat& left, cv::Mat& right);

  /// Where an image of camera 0 or 1 lies.
  std::filesystem::path ImagePath(int camera, const std::string& file) const {
    return files_.cameras[camera].folder / file;
  }

 private:
  void PairImages();
  void CheckOverlap();
  void FindSampleBits();
  void RequireReadablePair();
  void ReadImage(int camera, const std::string& file, cv::Mat& image);

  RecordingFiles files_;
  std::vector<FrameEntry> frames_;
  int sample_bits_ = 16;
  ImageReader reader_;
};

}  // namespace facet
