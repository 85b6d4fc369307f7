// SPDX-License-Identifier: BSD-2-Clause
// A recording as a folder in the ASL layout.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "facet/recording/recording_writer.h"

namespace facet {

/// A text file that appears under its name when it is complete; before, it is called FILE.partial.
class StagedFile {
 public:
  explicit StagedFile(const std::filesystem::path& file);
  void Line(const std::string& line) { stream_ << line << '\n'; }
  void Commit();  ///< throws OutputError

 private:
  std::filesystem::path Partial() const { return file_.string() + ".partial"; }
  std::filesystem::path file_;
  std::ofstream stream_;
};

/// Images become PNG, the IMU keeps all digits, the calibration goes to camchain-imucam.yaml and
/// imu.yaml. Images that are there already are kept, so that a conversion that was interrupted goes
/// on; the lists appear with Commit.
class AslWriter : public RecordingWriter {
 public:
  /// `calibration` may be null. Creates the folders.
  AslWriter(const std::filesystem::path& folder, const Calibration* calibration);

  void Add(const ImuSample& sample) override;
  void Add(const RecordedFrame& frame) override;
  void Commit() override;

 private:
  void AddImage(std::size_t camera, Timestamp t, const EncodedImage& image);

  std::filesystem::path mav0_;
  std::array<StagedFile, 2> lists_;
  StagedFile imu_;
  ImageReader reader_;
  cv::Mat grey_;
};

}  // namespace facet
