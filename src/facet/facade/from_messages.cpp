// SPDX-License-Identifier: BSD-2-Clause
// What drivers publish: images as they are encoded, and CameraInfo.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>

#include <opencv2/core.hpp>

#include "facet/facade/plain_calibration.h"
#include "facet/io/errors.h"
#include "facet/messages/message_image.h"
#include "facet/messages/ros_calibration.h"

namespace facet::api {

namespace {

CameraInfoMessage Internal(const CameraInfo& plain, const std::string& frame) {
  CameraInfoMessage info;
  info.header.frame = frame;
  info.width = static_cast<std::uint32_t>(std::max(plain.width, 0));
  info.height = static_cast<std::uint32_t>(std::max(plain.height, 0));
  info.distortion_model = plain.distortion_model;
  info.D = plain.D;
  info.K = plain.K;
  info.R = plain.R;
  info.P = plain.P;
  return info;
}

}  // namespace

Calibration CalibrationFromCameraInfo(const CameraInfo& left,
                                      const CameraInfo& right,
                                      const CameraMount& mount) try {
  const std::array infos = {Internal(left, "left"), Internal(right, "right")};
  const std::optional<SE3> T_C0C1 =
      mount.T_C0C1 ? Internal(*mount.T_C0C1, "T_C0C1") : RightToLeft(infos);
  if (!T_C0C1)
    throw Error("camera_info of the right camera has no baseline in P, and no transform is given");
  RosCalibrationMessages messages;
  messages.cameras = {infos[0], infos[1]};
  messages.are_rectified = {mount.are_rectified, mount.are_rectified};
  messages.imu_frame = "imu";
  const SE3 T_BC = Internal(mount.T_BC, "T_BC");
  messages.transforms = {{"imu", "left", T_BC}, {"left", "right", *T_C0C1}};
  const RosCalibration found = CalibrationFromMessages(messages, mount.imu_noise);
  if (!found.calibration) throw Error(found.problem);
  return PlainCalibration(found.calibration->rig, found.calibration->imu_noise);
} catch (const InputError& error) {
  throw Error(error.what());
}

struct ImageDecoder::Impl {
  int sample_bits = 16;
  ImageReader reader;
};

ImageDecoder::ImageDecoder(int sample_bits) : impl_(std::make_unique<Impl>()) {
  if (sample_bits < 8 || sample_bits > 16) throw Error("sample_bits must be 8 to 16");
  impl_->sample_bits = sample_bits;
}
ImageDecoder::~ImageDecoder() = default;
ImageDecoder::ImageDecoder(ImageDecoder&&) noexcept = default;
ImageDecoder& ImageDecoder::operator=(ImageDecoder&&) noexcept = default;

Image ImageDecoder::Decode(const EncodedImage& image) try {
  ImageMessage message;
  message.encoding = image.encoding;
  message.width = static_cast<std::uint32_t>(std::max(image.width, 0));
  message.height = static_cast<std::uint32_t>(std::max(image.height, 0));
  message.step = static_cast<std::uint32_t>(image.step_bytes);
  message.is_big_endian = image.is_big_endian;
  message.data = {image.bytes, image.bytes == nullptr ? 0 : image.num_bytes};
  const auto grey = std::make_shared<cv::Mat>();
  DecodeToGrey(message, impl_->sample_bits, {}, impl_->reader, *grey);
  return {grey->data, grey->cols, grey->rows, grey->step[0], grey};
} catch (const InputError& error) {
  throw Error(error.what());
}

}  // namespace facet::api
