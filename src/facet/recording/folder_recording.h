// SPDX-License-Identifier: BSD-2-Clause
// A recording of image files as a stream.
#pragma once

#include "facet/io/stereo_dataset.h"
#include "facet/recording/recording.h"

namespace facet {

/// Images are read when they are decoded.
class FolderRecording : public Recording {
 public:
  explicit FolderRecording(StereoDataset dataset) : dataset_(std::move(dataset)) {}

  const std::string& name() const override { return dataset_.name(); }
  const Calibration* calibration() const override { return &dataset_.calibration(); }
  std::optional<RecordingEvent> Next() override;
  void Rewind() override;
  int NumFrames(Timestamp from, Timestamp to) const override;
  std::vector<std::string> Warnings() const override { return dataset_.warnings(); }
  StampCounts ImagesLeftOut() const override { return dataset_.images_left_out(); }
  StampCounts ImuLeftOut() const override { return dataset_.imu_left_out(); }

 private:
  bool IsImuNext() const;

  StereoDataset dataset_;
  std::size_t next_imu_ = 0, next_frame_ = 0;
};

}  // namespace facet
