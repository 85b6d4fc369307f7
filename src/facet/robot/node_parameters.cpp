// SPDX-License-Identifier: BSD-2-Clause
#include "facet/robot/node_parameters.h"

#include <optional>
#include <set>

namespace facet {
namespace robot {

namespace {

/// Reads one parameter after the other, and remembers which there are.
class Reader {
 public:
  explicit Reader(const ParameterSource& source) : source_(source) {}

  /// Leaves `value` as it is where the parameter is not set.
  template <class T>
  void Read(const std::string& name, T& value) {
    known_.insert(name);
    source_.Get(name, value);
  }

  /// Seven numbers: x y z qx qy qz qw. True if it is set.
  bool Read(const std::string& name, api::Pose& pose) {
    std::vector<double> numbers;
    Read(name, numbers);
    if (numbers.empty()) return false;
    if (numbers.size() != 7) throw api::Error("~" + name + " must be [x, y, z, qx, qy, qz, qw]");
    pose.p = {{numbers[0], numbers[1], numbers[2]}};
    pose.q = {{numbers[6], numbers[3], numbers[4], numbers[5]}};
    return true;
  }

  /// Throws where one is set that nobody has read: it is misspelt.
  void RefuseOthers() const {
    for (const std::string& name : source_.Names()) {
      if (known_.count(name) == 0)
        throw api::Error("~" + name + " is not a parameter; there are: " + Known());
    }
  }

 private:
  std::string Known() const {
    std::string text;
    for (const std::string& name : known_)
      text += (text.empty() ? "" : ", ") + name;
    return text;
  }

  const ParameterSource& source_;
  std::set<std::string> known_;
};

/// Files with a calibration, or what CameraInfo does not tell.
struct CalibrationSource {
  std::string cameras;
  bool has_mount = false;
};

CalibrationSource ReadSource(Reader& reader, api::CameraMount& mount) {
  CalibrationSource source;
  reader.Read("calibration", source.cameras);
  reader.Read("imu_calibration", mount.imu_noise);
  source.has_mount = reader.Read("T_imu_left", mount.T_BC);
  api::Pose T_left_right;
  if (reader.Read("T_left_right", T_left_right)) mount.T_C0C1 = T_left_right;
  reader.Read("rectified", mount.are_rectified);
  return source;
}

/// Empty where CameraInfo is to be used.
std::optional<api::Calibration> OpenCalibration(const CalibrationSource& source,
                                                const std::string& imu_noise) {
  if (source.cameras.empty() && !source.has_mount)
    throw api::Error("set ~calibration (Kalibr's camchain.yaml), or ~T_imu_left for camera_info");
  if (source.cameras.empty()) return std::nullopt;
  try {
    return api::ReadCalibration(source.cameras, imu_noise);
  } catch (const api::Error& error) {
    throw CalibrationError(std::string("~calibration: ") + error.what());
  }
}

int ReadQueue(Reader& reader, const std::string& name, int value) {
  reader.Read(name, value);
  if (value < 1) throw api::Error("~" + name + " must be 1 or more");
  return value;
}

}  // namespace

bool IsOfMiddleware(const std::string& name) {
  return name == "reliable" || name == "use_sim_time" || name == "start_type_description_service" ||
         name.rfind("qos_overrides.", 0) == 0;
}

NodeParameters ReadParameters(const ParameterSource& source) {
  NodeParameters parameters;
  RobotOptions& options = parameters.robot;
  Reader reader(source);
  reader.Read("T_base_imu", options.T_base_imu);
  reader.Read("config", options.config_file);
  reader.Read("set", options.overrides);
  reader.Read("known_map", options.known_map);
  reader.Read("start", options.is_started);
  reader.Read("smoothing_s", options.smoothing_s);
  reader.Read("max_age_s", options.max_age_s);
  reader.Read("max_waiting_pairs", options.max_waiting_pairs);
  reader.Read("two_threads", options.two_threads);
  reader.Read("pair_tolerance_s", options.pair_tolerance_s);
  reader.Read("sample_bits", options.sample_bits);
  reader.Read("silence_s", options.silence_s);
  reader.Read("scene_period_s", options.scene_period_s);
  reader.Read("path_period_s", options.path_period_s);
  reader.Read("map_frame", parameters.frames.map);
  reader.Read("odom_frame", parameters.frames.odom);
  reader.Read("base_frame", parameters.frames.base);
  reader.Read("compressed", parameters.has_compressed_images);
  reader.Read("publish_tf", parameters.publishes_tf);
  reader.Read("publish_map_tf", parameters.publishes_map_tf);
  parameters.imu_queue = ReadQueue(reader, "imu_queue", parameters.imu_queue);
  parameters.image_queue = ReadQueue(reader, "image_queue", parameters.image_queue);
  const CalibrationSource files = ReadSource(reader, options.mount);
  reader.RefuseOthers();
  options.calibration = OpenCalibration(files, options.mount.imu_noise);
  return parameters;
}

}  // namespace robot
}  // namespace facet
