// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/mcap_recording_writer.h"

#include <string>

#include "facet/io/errors.h"
#include "facet/messages/ros_calibration.h"
#include "facet/recording/message_writer.h"

namespace facet {
namespace {

constexpr const char* kImuFrame = "imu0";

std::string FrameOf(std::size_t camera) {
  return "cam" + std::to_string(camera);
}

}  // namespace

CameraInfoMessage CameraInfoOf(const CameraModel& camera) {
  const CameraIntrinsics& k = camera.intrinsics();
  CameraInfoMessage info;
  info.width = static_cast<std::uint32_t>(k.width);
  info.height = static_cast<std::uint32_t>(k.height);
  SetLens(k, info);
  info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {k.fx, 0, k.cx, 0, 0, k.fy, k.cy, 0, 0, 0, 1, 0};
  return info;
}

McapRecordingWriter::McapRecordingWriter(const std::filesystem::path& file,
                                         Compression compression,
                                         const Calibration* calibration)
    : writer_(file, compression) {
  const auto add = [&](const std::string& topic, const char* type) {
    return writer_.AddChannel(topic, type, MessageDefinition(type));
  };
  imu_ = add("/imu0", kImuType);
  for (std::size_t i = 0; i < 2; ++i)
    images_[i] = add("/" + FrameOf(i) + "/image_raw", kImageType);
  if (calibration == nullptr) return;
  rig_ = calibration->rig;
  transforms_ = add("/tf_static", kTransformsType);
  for (std::size_t i = 0; i < 2; ++i)
    infos_[i] = add("/" + FrameOf(i) + "/camera_info", kCameraInfoType);
}

/// Before everything else, so that whoever reads the file knows them.
void McapRecordingWriter::AddTransforms(Timestamp t) {
  if (!rig_ || has_transforms_) return;
  has_transforms_ = true;
  std::vector<FrameTransform> transforms;
  for (std::size_t i = 0; i < 2; ++i)
    transforms.push_back({kImuFrame, FrameOf(i), rig_->T_BC[i]});
  writer_.AddMessage(transforms_, t, WriteTransformsMessage(t, transforms));
}

void McapRecordingWriter::Add(const ImuSample& sample) {
  AddTransforms(sample.t);
  writer_.AddMessage(imu_, sample.t, WriteImuMessage({sample.t, kImuFrame}, sample));
}

void McapRecordingWriter::Add(const RecordedFrame& frame) {
  AddTransforms(frame.t);
  AddImage(0, frame.t, *frame.left);
  if (frame.HasRight()) AddImage(1, frame.t_right, *frame.right);
}

void McapRecordingWriter::AddImage(std::size_t camera, Timestamp t, const EncodedImage& image) {
  const MessageHeader header{t, FrameOf(camera)};
  try {
    image.Decode({}, reader_, grey_);
  } catch (const InputError&) {
    ++num_unusable_;
    return;
  }
  writer_.AddMessage(images_[camera], t, WriteImageMessage(header, grey_));
  if (!rig_) return;
  CameraInfoMessage info = CameraInfoOf(rig_->cameras[camera]);
  info.header = header;
  writer_.AddMessage(infos_[camera], t, WriteCameraInfoMessage(info));
}

}  // namespace facet
