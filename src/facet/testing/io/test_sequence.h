// SPDX-License-Identifier: BSD-2-Clause
// For tests: temporary folders and tiny recordings in the ASL layout that a test can then damage.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace facet {

/// A fresh temporary folder that is removed with everything in it.
class TempFolder {
 public:
  TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder();
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Creates the parent folders, too.
void WriteText(const std::filesystem::path& file, const std::string& text);
std::string ReadText(const std::filesystem::path& file);

/// Replaces the first occurrence; throws if there is none, so that no test damages nothing.
void ReplaceInFile(const std::filesystem::path& file,
                   const std::string& from,
                   const std::string& to);

/// Cuts the file down to this many bytes.
void Truncate(const std::filesystem::path& file, std::uintmax_t size);

/// Lines of a text without their ends.
std::vector<std::string> Lines(const std::string& text);
std::string JoinLines(const std::vector<std::string>& lines);
/// Applies a change to the lines of a file.
void EditLines(const std::filesystem::path& file,
               const std::function<void(std::vector<std::string>&)>& edit);

struct TestSequenceOptions {
  int num_frames = 12;
  int width = 160, height = 120;
  std::int64_t first_ns = 1403636584763555584;
  std::int64_t frame_interval_ns = 50000000;
  std::int64_t imu_interval_ns = 5000000;
};

/// A still view of a random texture as PGM images, an IMU at rest, EuRoC calibration; the IMU
/// begins 0.1 s before the first frame and ends 0.1 s after the last one.
void WriteTestSequence(const std::filesystem::path& sequence,
                       const TestSequenceOptions& options = {});

/// The stamp of frame `i`.
std::int64_t FrameStamp(const TestSequenceOptions& options, int i);

/// EuRoC sensor.yaml of a camera of the test sequence, 0 or 1.
std::string TestCameraYaml(int camera, const TestSequenceOptions& options = {});
std::string TestImuYaml();

}  // namespace facet
