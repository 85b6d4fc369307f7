// SPDX-License-Identifier: BSD-2-Clause
// large_recording [--megabytes N] [--folder DIR]
// Writes an MCAP file of that size (raw images, no compression) into the folder, reads it as a
// recording without decoding its images, and removes it. Prints speed and memory. Exit code 1 if
// resident memory changes by more than 20 MB behind the first tenth, or if less than 500 MB are
// read per second of processor time (from the page cache, if the file fits into it).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <variant>

#include "program.h"
#include <CLI/CLI.hpp>
#include <unistd.h>

#include "facet/base/random.h"
#include "facet/recording/mcap_writer.h"
#include "facet/recording/message_writer.h"
#include "facet/recording/open_recording.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kFrameNs = 50000000, kImuNs = 5000000;
constexpr double kMaxGrowthMb = 20, kMinMbPerSecond = 500;

/// Removes the file at the end.
struct TemporaryFile {
  fs::path path;
  ~TemporaryFile() {
    std::error_code error;
    fs::remove(path, error);
  }
};

cv::Mat Noise() {
  Rng rng(1);
  cv::Mat grey(480, 752, CV_8UC1);
  for (auto pixel = grey.begin<std::uint8_t>(); pixel != grey.end<std::uint8_t>(); ++pixel)
    *pixel = static_cast<std::uint8_t>(rng.Index(256));
  return grey;
}

/// Returns the number of stereo pairs.
int WriteLarge(const fs::path& file, double megabytes) {
  McapWriter writer(file, Compression::kNone);
  const auto add = [&](const char* topic, const char* type) {
    return writer.AddChannel(topic, type, MessageDefinition(type));
  };
  const auto left = add("/cam0/image_raw", kImageType), right = add("/cam1/image_raw", kImageType),
             imu = add("/imu0", kImuType);
  const cv::Mat grey = Noise();
  const ImuSample still{{}, Vector3d::Zero(), {0, 0, 9.81}};
  const int num_pairs =
      static_cast<int>(1e6 * megabytes / (2.0 * static_cast<double>(grey.total())));
  Timestamp t{1700000000000000000};
  for (int i = 0; i < num_pairs; ++i, t = t + Duration{kFrameNs}) {
    writer.AddMessage(left, t, WriteImageMessage({t, "cam0"}, grey));
    writer.AddMessage(right, t, WriteImageMessage({t, "cam1"}, grey));
    for (Timestamp s = t; s < t + Duration{kFrameNs}; s = s + Duration{kImuNs})
      writer.AddMessage(imu, s, WriteImuMessage({s, "imu0"}, still));
  }
  writer.Commit();
  return num_pairs;
}

double ResidentMb() {
  std::ifstream stream("/proc/self/statm");
  double all_pages = 0, resident_pages = 0;
  if (!(stream >> all_pages >> resident_pages)) throw std::runtime_error("no /proc/self/statm");
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

struct Reading {
  int num_pairs = 0;
  double wall_s = 0, cpu_s = 0, least_mb = 1e9, most_mb = 0;
};

Reading ReadAll(const fs::path& file, int num_expected) {
  RecordingOptions options;
  options.needs_calibration = false;
  const auto recording = OpenRecording(file, options);
  Reading reading;
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  while (const auto event = recording->Next()) {
    if (!std::holds_alternative<RecordedFrame>(*event)) continue;
    if (++reading.num_pairs < num_expected / 10 || reading.num_pairs % 10 != 0) continue;
    const double mb = ResidentMb();
    reading.least_mb = std::min(reading.least_mb, mb);
    reading.most_mb = std::max(reading.most_mb, mb);
  }
  reading.cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  reading.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
  return reading;
}

int Main(int argc, char** argv) {
  double megabytes = 2000;
  std::string folder = fs::temp_directory_path().string();
  CLI::App app("Reads a large recording");
  app.add_option("--megabytes", megabytes, "size of the file")->check(CLI::Range(100, 1000000));
  app.add_option("--folder", folder, "for the file, which is removed at the end");
  CLI11_PARSE(app, argc, argv);
  const TemporaryFile file{fs::path(folder) /
                           ("large_recording_" + std::to_string(getpid()) + ".mcap")};
  const int num_pairs = WriteLarge(file.path, megabytes);
  const double size_mb = static_cast<double>(fs::file_size(file.path)) / 1e6;
  const Reading reading = ReadAll(file.path, num_pairs);
  if (reading.num_pairs != num_pairs) throw std::runtime_error("pairs are missing");
  const double speed = size_mb / reading.cpu_s, growth_mb = reading.most_mb - reading.least_mb;
  std::printf(
      "%d pairs, %.0f MB: %.0f MB/s of processor time, %.0f MB/s of wall time; resident memory "
      "%.1f "
      "to %.1f MB\n",
      num_pairs,
      size_mb,
      speed,
      size_mb / reading.wall_s,
      reading.least_mb,
      reading.most_mb);
  return growth_mb <= kMaxGrowthMb && speed >= kMinMbPerSecond ? 0 : 1;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("large_recording", facet::Main, argc, argv);
}
