// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/message_writer.h"

#include <cstring>
#include <string_view>

#include "facet/base/check.h"

namespace facet {
namespace {

class CdrWriter {
 public:
  template <class T>
  void Number(T value) {
    constexpr std::size_t kHead = 4;
    while ((bytes_.size() - kHead) % sizeof(T) != 0)
      bytes_.push_back(0);
    Append(&value, sizeof(T));
  }

  template <class Values>
  void Numbers(const Values& values) {
    for (const double value : values)
      Number(value);
  }

  void Text(const std::string& text) {
    Number(static_cast<std::uint32_t>(text.size() + 1));
    Append(text.c_str(), text.size() + 1);
  }

  void Append(const void* data, std::size_t size) {
    const std::size_t end = bytes_.size();
    bytes_.resize(end + size);
    std::memcpy(bytes_.data() + end, data, size);
  }

  /// Nanoseconds are those since the second before, also for stamps before 1970.
  void Header(const MessageHeader& header) {
    constexpr std::int64_t kSecond = 1000000000;
    std::int64_t s = header.t.ns / kSecond, ns = header.t.ns % kSecond;
    if (ns < 0) --s, ns += kSecond;
    Number(static_cast<std::int32_t>(s));
    Number(static_cast<std::uint32_t>(ns));
    Text(header.frame);
  }

  void Reserve(std::size_t size) { bytes_.reserve(size); }
  std::vector<std::uint8_t> Take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_ = {0, 1, 0, 0};  // little-endian
};

constexpr std::array<double, 9> kUnknown{};

struct Definition {
  std::string_view type, text;
  std::vector<std::string_view> parts;  ///< all that it is made of
};

const std::vector<Definition>& Definitions() {
  static const std::vector<Definition> kDefinitions = {
      {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n", {}},
      {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n", {}},
      {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n", {}},
      {"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n", {}},
      {"geometry_msgs/Transform",
       "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
       {}},
      {"geometry_msgs/TransformStamped",
       "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
       {}},
      {"sensor_msgs/RegionOfInterest",
       "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
       {}},
      {kImageType,
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
       "uint8 is_bigendian\nuint32 step\nuint8[] data\n",
       {"std_msgs/Header", "builtin_interfaces/Time"}},
      {kImuType,
       "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
       "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
       "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
       "float64[9] linear_acceleration_covariance\n",
       {"std_msgs/Header",
        "builtin_interfaces/Time",
        "geometry_msgs/Quaternion",
        "geometry_msgs/Vector3"}},
      {kCameraInfoType,
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
       "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\n"
       "uint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
       {"std_msgs/Header", "builtin_interfaces/Time", "sensor_msgs/RegionOfInterest"}},
      {kTransformsType,
       "geometry_msgs/TransformStamped[] transforms\n",
       {"geometry_msgs/TransformStamped",
        "std_msgs/Header",
        "builtin_interfaces/Time",
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3",
        "geometry_msgs/Quaternion"}},
  };
  return kDefinitions;
}

const Definition& RequireDefinition(std::string_view type) {
  for (const Definition& definition : Definitions()) {
    if (definition.type == type) return definition;
  }
  FACET_CHECK(false) << "no definition of " << std::string(type);
  return Definitions().front();
}

}  // namespace

std::vector<std::uint8_t> WriteImageMessage(const MessageHeader& header, const cv::Mat& grey) {
  FACET_CHECK(grey.type() == CV_8UC1) << "the image is not 8-bit grey";
  CdrWriter writer;
  const auto width = static_cast<std::uint32_t>(grey.cols);
  writer.Reserve(grey.total() + 200);
  writer.Header(header);
  writer.Number(static_cast<std::uint32_t>(grey.rows));
  writer.Number(width);
  writer.Text("mono8");
  writer.Number(std::uint8_t{0});  // little-endian
  writer.Number(width);            // bytes per row
  writer.Number(static_cast<std::uint32_t>(grey.total()));
  for (int y = 0; y < grey.rows; ++y)
    writer.Append(grey.ptr(y), width);
  return writer.Take();
}

std::vector<std::uint8_t> WriteImuMessage(const MessageHeader& header, const ImuSample& sample) {
  std::array<double, 9> no_orientation{};
  no_orientation[0] = -1;
  CdrWriter writer;
  writer.Header(header);
  writer.Numbers(std::array<double, 4>{0, 0, 0, 1});
  writer.Numbers(no_orientation);
  writer.Numbers(sample.gyro);
  writer.Numbers(kUnknown);
  writer.Numbers(sample.accel);
  writer.Numbers(kUnknown);
  return writer.Take();
}

std::vector<std::uint8_t> WriteCameraInfoMessage(const CameraInfoMessage& info) {
  CdrWriter writer;
  writer.Header(info.header);
  writer.Number(info.height);
  writer.Number(info.width);
  writer.Text(info.distortion_model);
  writer.Number(static_cast<std::uint32_t>(info.D.size()));
  writer.Numbers(info.D);
  writer.Numbers(info.K);
  writer.Numbers(info.R);
  writer.Numbers(info.P);
  for (int i = 0; i < 6; ++i)
    writer.Number(std::uint32_t{0});  // binning and region: the whole image
  writer.Number(std::uint8_t{0});
  return writer.Take();
}

std::vector<std::uint8_t> WriteTransformsMessage(Timestamp t,
                                                 const std::vector<FrameTransform>& transforms) {
  CdrWriter writer;
  writer.Number(static_cast<std::uint32_t>(transforms.size()));
  for (const FrameTransform& transform : transforms) {
    writer.Header({t, transform.parent});
    writer.Text(transform.child);
    writer.Numbers(transform.T_parent_child.p);
    writer.Numbers(transform.T_parent_child.q.coeffs());  // x y z w
  }
  return writer.Take();
}

std::string MessageDefinition(const std::string& type) {
  const Definition& definition = RequireDefinition(type);
  std::string text(definition.text);
  for (const std::string_view part : definition.parts) {
    text += std::string(80, '=') + "\nMSG: " + std::string(part) + "\n";
    text += RequireDefinition(part).text;
  }
  return text;
}

}  // namespace facet
