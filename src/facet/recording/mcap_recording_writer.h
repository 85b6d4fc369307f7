// SPDX-License-Identifier: BSD-2-Clause
// A recording as an MCAP file of ROS 2 messages.
#pragma once

#include <array>
#include <filesystem>
#include <optional>

#include "facet/recording/mcap_writer.h"
#include "facet/recording/recording_writer.h"
#include "facet/recording/sensor_messages.h"

namespace facet {

/// Topics /cam0/image_raw, /cam1/image_raw (mono8) and /imu0; with a calibration also
/// /cam0/camera_info, /cam1/camera_info and /tf_static. These have no place for a time offset
/// between camera and IMU and for noise densities.
class McapRecordingWriter : public RecordingWriter {
 public:
  /// `calibration` may be null.
  McapRecordingWriter(const std::filesystem::path& file,
                      Compression compression,
                      const Calibration* calibration);

  void Add(const ImuSample& sample) override;
  void Add(const RecordedFrame& frame) override;
  void Commit() override { writer_.Commit(); }

 private:
  void AddTransforms(Timestamp t);
  void AddImage(std::size_t camera, Timestamp t, const EncodedImage& image);

  McapWriter writer_;
  std::optional<StereoRig> rig_;
  std::uint16_t imu_ = 0, transforms_ = 0;
  std::array<std::uint16_t, 2> images_{}, infos_{};
  bool has_transforms_ = false;
  ImageReader reader_;
  cv::Mat grey_;
};

/// What CameraInfo says of a camera; the frame is empty.
CameraInfoMessage CameraInfoOf(const CameraModel& camera);

}  // namespace facet
