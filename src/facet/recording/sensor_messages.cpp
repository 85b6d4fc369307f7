// SPDX-License-Identifier: BSD-2-Clause
// ROS 1 writes fields one after the other, little-endian. CDR (the classic one and the second one
// without type information) aligns numbers to their size, counted from behind its own four bytes.
#include "facet/recording/sensor_messages.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "facet/recording/byte_reader.h"

namespace facet {
namespace {

class FieldReader {
 public:
  FieldReader(std::span<const std::uint8_t> bytes, MessageEncoding encoding)
      : is_cdr_(encoding == MessageEncoding::kCdr), reader_(bytes) {
    if (encoding == MessageEncoding::kOther) throw InputError("neither CDR nor ROS 1 messages");
    if (!is_cdr_) return;
    const auto head = reader_.Block(4);
    const int kind = head[1];
    if (head[0] != 0 || (kind != 0 && kind != 1 && kind != 6 && kind != 7)) {
      throw InputError("a message in an unknown kind of CDR (" + std::to_string(head[0]) + ", " +
                       std::to_string(kind) + ")");
    }
    is_swapped_ = kind % 2 == 0;
    max_alignment_ = kind >= 6 ? 4 : 8;
  }

  std::size_t remaining() const { return reader_.remaining(); }

  template <class T>
  T Number() {
    if (is_cdr_) {
      const std::size_t alignment = std::min(sizeof(T), max_alignment_);
      const std::size_t over = (reader_.position() - 4) % alignment;
      if (over > 0) reader_.Block(alignment - over);
    }
    auto value = reader_.Number<T>();
    if (is_swapped_) {
      auto* begin = reinterpret_cast<unsigned char*>(&value);
      std::reverse(begin, begin + sizeof(T));
    }
    return value;
  }

  std::string Text() {
    std::string_view text = reader_.Text(Number<std::uint32_t>());
    if (is_cdr_ && !text.empty() && text.back() == '\0') text.remove_suffix(1);
    return std::string(text);
  }

  std::span<const std::uint8_t> Blob() { return reader_.Block(Number<std::uint32_t>()); }

  Vector3d Vector() {
    Vector3d v;
    for (int i = 0; i < 3; ++i)
      v[i] = Number<double>();
    return v;
  }

  MessageHeader Header() {
    MessageHeader header;
    if (!is_cdr_) Number<std::uint32_t>();  // sequence number
    const std::int64_t s =
        is_cdr_ ? std::int64_t{Number<std::int32_t>()} : std::int64_t{Number<std::uint32_t>()};
    header.t.ns = s * 1000000000 + std::int64_t{Number<std::uint32_t>()};
    header.frame = Text();
    return header;
  }

 private:
  bool is_cdr_, is_swapped_ = false;
  std::size_t max_alignment_ = 8;
  ByteReader reader_;
};

/// Of the frames in transforms and headers; ROS 1 knows them with and without a slash.
std::string CleanFrame(std::string frame) {
  if (frame.starts_with('/')) frame.erase(0, 1);
  return frame;
}

}  // namespace

ImageMessage ReadImageMessage(std::span<const std::uint8_t> bytes, MessageEncoding encoding) {
  FieldReader reader(bytes, encoding);
  ImageMessage image;
  image.header = reader.Header();
  image.height = reader.Number<std::uint32_t>();
  image.width = reader.Number<std::uint32_t>();
  image.encoding = reader.Text();
  image.is_big_endian = reader.Number<std::uint8_t>() != 0;
  image.step = reader.Number<std::uint32_t>();
  image.data = reader.Blob();
  if (image.encoding.empty()) throw InputError("an image without an encoding");
  return image;
}

ImageMessage ReadCompressedImageMessage(std::span<const std::uint8_t> bytes,
                                        MessageEncoding encoding) {
  FieldReader reader(bytes, encoding);
  ImageMessage image;
  image.header = reader.Header();
  reader.Text();  // the format; the data say better what they are
  image.data = reader.Blob();
  return image;
}

ImageMessage ReadAnyImageMessage(const Topic& topic, std::span<const std::uint8_t> bytes) {
  return topic.type == kImageType ? ReadImageMessage(bytes, topic.encoding)
                                  : ReadCompressedImageMessage(bytes, topic.encoding);
}

ImuMessage ReadImuMessage(std::span<const std::uint8_t> bytes, MessageEncoding encoding) {
  FieldReader reader(bytes, encoding);
  constexpr int kOrientation = 4, kCovariance = 9;
  ImuMessage imu;
  imu.header = reader.Header();
  imu.sample.t = imu.header.t;
  for (int i = 0; i < kOrientation + kCovariance; ++i)
    reader.Number<double>();
  imu.sample.gyro = reader.Vector();
  for (int i = 0; i < kCovariance; ++i)
    reader.Number<double>();
  imu.sample.accel = reader.Vector();
  return imu;
}

CameraInfoMessage ReadCameraInfoMessage(std::span<const std::uint8_t> bytes,
                                        MessageEncoding encoding) {
  FieldReader reader(bytes, encoding);
  CameraInfoMessage info;
  info.header = reader.Header();
  info.header.frame = CleanFrame(info.header.frame);
  info.height = reader.Number<std::uint32_t>();
  info.width = reader.Number<std::uint32_t>();
  info.distortion_model = reader.Text();
  const auto num = reader.Number<std::uint32_t>();
  if (num > reader.remaining() / sizeof(double)) throw InputError("more coefficients than bytes");
  for (std::uint32_t i = 0; i < num; ++i)
    info.D.push_back(reader.Number<double>());
  for (double& k : info.K)
    k = reader.Number<double>();
  for (double& r : info.R)
    r = reader.Number<double>();
  for (double& p : info.P)
    p = reader.Number<double>();
  return info;
}

std::vector<FrameTransform> ReadTransformsMessage(std::span<const std::uint8_t> bytes,
                                                  MessageEncoding encoding) {
  FieldReader reader(bytes, encoding);
  std::vector<FrameTransform> transforms;
  const auto num = reader.Number<std::uint32_t>();
  for (std::uint32_t i = 0; i < num; ++i) {  // ends with an exception where there are fewer
    FrameTransform transform;
    transform.parent = CleanFrame(reader.Header().frame);
    transform.child = CleanFrame(reader.Text());
    transform.T_parent_child.p = reader.Vector();
    Vector4d xyzw;
    for (int k = 0; k < 4; ++k)
      xyzw[k] = reader.Number<double>();
    const double norm = xyzw.norm();
    if (!(std::abs(norm - 1) < 0.01) || !transform.T_parent_child.p.allFinite()) {
      throw InputError("the transform from " + transform.child + " to " + transform.parent +
                       " is no rigid motion");
    }
    xyzw /= norm;
    transform.T_parent_child.q = Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
    transforms.push_back(transform);
  }
  return transforms;
}

}  // namespace facet
