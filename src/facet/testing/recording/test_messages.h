// SPDX-License-Identifier: BSD-2-Clause
// For tests: the bytes of ROS messages, written by hand.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "facet/recording/sensor_messages.h"

namespace facet {

/// Writes fields as ROS 1 or CDR (little-endian) does.
class FieldWriter {
 public:
  explicit FieldWriter(MessageEncoding encoding);

  template <class T>
  void Number(T value) {
    Align(sizeof(T));
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void Text(const std::string& text);
  void Blob(const std::string& bytes);
  void Header(Timestamp t, const std::string& frame);
  const std::string& bytes() const { return bytes_; }

 private:
  void Align(std::size_t size);

  bool is_cdr_;
  std::string bytes_;
};

struct TestMessage {
  std::string topic;
  std::string type;  ///< as ROS 1 writes it
  Timestamp received;
  std::string bytes;
};

struct TestRawImage {
  std::uint32_t width = 0, height = 0;
  std::string encoding;
  std::string data;
  std::uint32_t step = 0;  ///< 0: without gaps between rows
  bool is_big_endian = false;
};

std::string ImageBytes(MessageEncoding encoding,
                       Timestamp t,
                       const std::string& frame,
                       const TestRawImage& image);
std::string CompressedImageBytes(MessageEncoding encoding, Timestamp t, const std::string& file);
std::string ImuBytes(MessageEncoding encoding, const ImuSample& sample, const std::string& frame);
std::string CameraInfoBytes(MessageEncoding encoding, const CameraInfoMessage& info);
std::string TransformsBytes(MessageEncoding encoding,
                            const std::vector<FrameTransform>& transforms);

/// The images (raw, mono8) and the IMU of a sequence in the ASL layout, by time; topics
/// /cam0/image_raw, /cam1/image_raw and /imu0, frames cam0, cam1 and imu0.
std::vector<TestMessage> MessagesOfSequence(const std::filesystem::path& sequence,
                                            MessageEncoding encoding);

/// camera_info and tf_static that say what the calibration of the sequence says.
std::vector<TestMessage> CalibrationMessagesOfSequence(const std::filesystem::path& sequence,
                                                       MessageEncoding encoding);

}  // namespace facet
