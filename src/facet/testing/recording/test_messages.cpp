// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/recording/test_messages.h"

#include <algorithm>

#include "facet/io/asl_dataset.h"

namespace facet {
namespace {

void WriteVector(FieldWriter& writer, const Vector3d& v) {
  for (int i = 0; i < 3; ++i)
    writer.Number(v[i]);
}

void WriteZeros(FieldWriter& writer, int num) {
  for (int i = 0; i < num; ++i)
    writer.Number(0.0);
}

}  // namespace

FieldWriter::FieldWriter(MessageEncoding encoding) : is_cdr_(encoding == MessageEncoding::kCdr) {
  if (is_cdr_) bytes_ = std::string("\0\1\0\0", 4);
}

void FieldWriter::Align(std::size_t size) {
  while (is_cdr_ && (bytes_.size() - 4) % size != 0)
    bytes_.push_back('\0');
}

void FieldWriter::Text(const std::string& text) {
  Number(static_cast<std::uint32_t>(text.size() + (is_cdr_ ? 1 : 0)));
  bytes_ += text;
  if (is_cdr_) bytes_.push_back('\0');
}

void FieldWriter::Blob(const std::string& bytes) {
  Number(static_cast<std::uint32_t>(bytes.size()));
  bytes_ += bytes;
}

void FieldWriter::Header(Timestamp t, const std::string& frame) {
  if (!is_cdr_) Number(std::uint32_t{7});
  Number(static_cast<std::uint32_t>(t.ns / 1000000000));
  Number(static_cast<std::uint32_t>(t.ns % 1000000000));
  Text(frame);
}

std::string ImageBytes(MessageEncoding encoding,
                       Timestamp t,
                       const std::string& frame,
                       const TestRawImage& image) {
  FieldWriter writer(encoding);
  writer.Header(t, frame);
  writer.Number(image.height);
  writer.Number(image.width);
  writer.Text(image.encoding);
  writer.Number(static_cast<std::uint8_t>(image.is_big_endian ? 1 : 0));
  const auto tight = static_cast<std::uint32_t>(image.data.size() / std::max(1U, image.height));
  writer.Number(image.step > 0 ? image.step : tight);
  writer.Blob(image.data);
  return writer.bytes();
}

std::string CompressedImageBytes(MessageEncoding encoding, Timestamp t, const std::string& file) {
  FieldWriter writer(encoding);
  writer.Header(t, "camera");
  writer.Text("mono8; png compressed");
  writer.Blob(file);
  return writer.bytes();
}

std::string ImuBytes(MessageEncoding encoding, const ImuSample& sample, const std::string& frame) {
  FieldWriter writer(encoding);
  writer.Header(sample.t, frame);
  WriteZeros(writer, 4 + 9);
  WriteVector(writer, sample.gyro);
  WriteZeros(writer, 9);
  WriteVector(writer, sample.accel);
  WriteZeros(writer, 9);
  return writer.bytes();
}

std::string CameraInfoBytes(MessageEncoding encoding, const CameraInfoMessage& info) {
  FieldWriter writer(encoding);
  writer.Header(info.header.t, info.header.frame);
  writer.Number(info.height);
  writer.Number(info.width);
  writer.Text(info.distortion_model);
  writer.Number(static_cast<std::uint32_t>(info.D.size()));
  for (const double d : info.D)
    writer.Number(d);
  for (const double k : info.K)
    writer.Number(k);
  for (const double r : info.R)
    writer.Number(r);
  for (const double p : info.P)
    writer.Number(p);
  for (int i = 0; i < 6; ++i)
    writer.Number(std::uint32_t{0});  // binning and region
  writer.Number(std::uint8_t{0});
  return writer.bytes();
}

std::string TransformsBytes(MessageEncoding encoding,
                            const std::vector<FrameTransform>& transforms) {
  FieldWriter writer(encoding);
  writer.Number(static_cast<std::uint32_t>(transforms.size()));
  for (const FrameTransform& transform : transforms) {
    writer.Header({}, transform.parent);
    writer.Text(transform.child);
    WriteVector(writer, transform.T_parent_child.p);
    const Quaterniond& q = transform.T_parent_child.q;
    for (const double value : {q.x(), q.y(), q.z(), q.w()})
      writer.Number(value);
  }
  return writer.bytes();
}

std::vector<TestMessage> MessagesOfSequence(const std::filesystem::path& sequence,
                                            MessageEncoding encoding) {
  AslDataset dataset(sequence);
  ImageReader reader;
  std::vector<TestMessage> messages;
  for (const ImuSample& sample : dataset.imu())
    messages.push_back({"/imu0", kImuType, sample.t, ImuBytes(encoding, sample, "imu0")});
  for (const FrameEntry& frame : dataset.frames()) {
    for (int camera = 0; camera < 2; ++camera) {
      const std::string name = "cam" + std::to_string(camera);
      cv::Mat grey;
      reader.Read(dataset.ImagePath(camera, camera == 0 ? frame.left : frame.right), grey);
      TestRawImage image;
      image.width = static_cast<std::uint32_t>(grey.cols);
      image.height = static_cast<std::uint32_t>(grey.rows);
      image.encoding = "mono8";
      image.data.assign(grey.begin<char>(), grey.end<char>());
      messages.push_back({"/" + name + "/image_raw",
                          kImageType,
                          frame.t,
                          ImageBytes(encoding, frame.t, name, image)});
    }
  }
  std::ranges::stable_sort(messages, {}, &TestMessage::received);
  return messages;
}

std::vector<TestMessage> CalibrationMessagesOfSequence(const std::filesystem::path& sequence,
                                                       MessageEncoding encoding) {
  const AslDataset dataset(sequence);
  const StereoRig& rig = dataset.rig();
  const Timestamp t = dataset.imu().front().t;
  std::vector<TestMessage> messages;
  std::vector<FrameTransform> transforms;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name = "cam" + std::to_string(i);
    const CameraIntrinsics& k = rig.cameras[i].intrinsics();
    CameraInfoMessage info;
    info.header = {t, name};
    info.width = static_cast<std::uint32_t>(k.width);
    info.height = static_cast<std::uint32_t>(k.height);
    info.distortion_model = "plumb_bob";
    info.D.assign(k.coefficients.begin(), k.coefficients.begin() + 4);
    info.D.push_back(0);
    info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
    messages.push_back(
        {"/" + name + "/camera_info", kCameraInfoType, t, CameraInfoBytes(encoding, info)});
    transforms.push_back({"imu0", name, rig.T_BC[i]});
  }
  // The right camera hangs on the left one, so that a chain must be followed.
  transforms[1] = {"cam0", "cam1", rig.T_BC[0].Inverse() * rig.T_BC[1]};
  messages.push_back({"/tf_static", kTransformsType, t, TransformsBytes(encoding, transforms)});
  return messages;
}

}  // namespace facet
