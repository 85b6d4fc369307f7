// SPDX-License-Identifier: BSD-2-Clause
// A folder in the ASL/EuRoC layout as a stream.
#pragma once

#include <filesystem>

#include "facet/io/asl_dataset.h"
#include "facet/recording/recording.h"

namespace facet {

/// The lists of images and the IMU are read when it is opened (some 100 bytes per image and
/// sample), images when they are decoded.
class AslRecording : public Recording {
 public:
  /// Throws InputError as AslDataset does.
  explicit AslRecording(const std::filesystem::path& sequence,
                        const CalibrationFiles& calibration = {});

  const std::string& name() const override { return dataset_.name(); }
  const Calibration* calibration() const override { return &dataset_.calibration(); }
  std::optional<RecordingEvent> Next() override;
  void Rewind() override;
  int NumFrames(Timestamp from, Timestamp to) const override;
  std::vector<std::string> Warnings() const override { return dataset_.warnings(); }

 private:
  bool IsImuNext() const;

  AslDataset dataset_;
  std::size_t next_imu_ = 0, next_frame_ = 0;
};

}  // namespace facet
