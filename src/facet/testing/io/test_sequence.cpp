// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/io/test_sequence.h"

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include <stdlib.h>

#include "facet/base/random.h"

namespace facet {

namespace fs = std::filesystem;

TempFolder::TempFolder() {
  std::string name = (fs::temp_directory_path() / "facet-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder " + name);
  path_ = name;
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void WriteText(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.flush();
  if (!stream) throw std::runtime_error("cannot write " + file.string());
}

std::string ReadText(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void ReplaceInFile(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = ReadText(file);
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error(file.string() + " does not hold " + from);
  WriteText(file, text.replace(at, from.size(), to));
}

void Truncate(const fs::path& file, std::uintmax_t size) {
  fs::resize_file(file, size);
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    lines.push_back(line);
  return lines;
}

std::string JoinLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines)
    text += line + "\n";
  return text;
}

void EditLines(const fs::path& file, const std::function<void(std::vector<std::string>&)>& edit) {
  std::vector<std::string> lines = Lines(ReadText(file));
  edit(lines);
  WriteText(file, JoinLines(lines));
}

std::int64_t FrameStamp(const TestSequenceOptions& options, int i) {
  return options.first_ns + i * options.frame_interval_ns;
}

std::string TestCameraYaml(int camera, const TestSequenceOptions& options) {
  const std::string p_y = camera == 0 ? "-0.064676986768" : "0.0453689425024";
  std::ostringstream text;
  // The body axes of EuRoC: the camera looks along the body's z axis, its x axis is the body's y
  // axis.
  text << "sensor_type: camera\n"
          "T_BS:\n"
          "  cols: 4\n"
          "  rows: 4\n"
          "  data: [0.0, -1.0, 0.0, -0.0216401454975,\n"
          "         1.0, 0.0, 0.0, "
       << p_y
       << ",\n"
          "         0.0, 0.0, 1.0, 0.00981073058949,\n"
          "         0.0, 0.0, 0.0, 1.0]\n"
          "rate_hz: 20\n"
          "resolution: ["
       << options.width << ", " << options.height
       << "]\n"
          "camera_model: pinhole\n"
          "intrinsics: [100.5, 101.25, "
       << options.width / 2 << ", " << options.height / 2
       << "] #fu, fv, cu, cv\n"
          "distortion_model: radial-tangential\n"
          "distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n";
  return text.str();
}

std::string TestImuYaml() {
  return "sensor_type: imu\n"
         "T_BS:\n"
         "  cols: 4\n"
         "  rows: 4\n"
         "  data: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0,\n"
         "         0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\n"
         "rate_hz: 200\n"
         "gyroscope_noise_density: 1.6968e-04\n"
         "gyroscope_random_walk: 1.9393e-05\n"
         "accelerometer_noise_density: 2.0000e-3\n"
         "accelerometer_random_walk: 3.0000e-3\n";
}

void WriteTestSequence(const fs::path& sequence, const TestSequenceOptions& options) {
  const fs::path mav0 = sequence / "mav0";
  Rng rng(1);
  std::string image =
      "P5\n" + std::to_string(options.width) + " " + std::to_string(options.height) + "\n255\n";
  for (int i = 0; i < options.width * options.height; ++i) {
    image.push_back(static_cast<char>(rng.Index(256)));
  }
  for (int camera = 0; camera < 2; ++camera) {
    const fs::path folder = mav0 / ("cam" + std::to_string(camera));
    std::string csv = "#timestamp [ns],filename\n";
    for (int i = 0; i < options.num_frames; ++i) {
      const std::string stamp = std::to_string(FrameStamp(options, i));
      WriteText(folder / "data" / (stamp + ".pgm"), image);
      csv += stamp + "," + stamp + ".pgm\n";
    }
    WriteText(folder / "data.csv", csv);
    WriteText(folder / "sensor.yaml", TestCameraYaml(camera, options));
  }
  std::string csv = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
  constexpr std::int64_t kMarginNs = 100000000;
  for (std::int64_t t = options.first_ns - kMarginNs;
       t <= FrameStamp(options, options.num_frames - 1) + kMarginNs;
       t += options.imu_interval_ns) {
    csv += std::to_string(t) + ",0.001,-0.002,0.003,9.81,0.01,0.02\n";
  }
  WriteText(mav0 / "imu0" / "data.csv", csv);
  WriteText(mav0 / "imu0" / "sensor.yaml", TestImuYaml());
}

}  // namespace facet
