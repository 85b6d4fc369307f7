// SPDX-License-Identifier: BSD-2-Clause
// What a run that is killed leaves: a folder beside the result that is valid at every moment.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "facet/io/folder_lock.h"

namespace facet {

/// What a run with this target that was killed has left, TARGET.partial, becomes TARGET.interrupted
/// (-2, -3 ... where there are some). Whatever was cut off within a line goes. One that has no
/// summary yet holds nothing (the process ended while it began, or the disk was full) and is
/// removed. Does nothing where there is none, where a live process writes it, or where it holds
/// other files than a run begins with. Returns the new name, or an empty path.
std::filesystem::path KeepInterrupted(const std::filesystem::path& target);

/// TARGET.partial while a run goes on. Not thread-safe.
class PartialFolder {
 public:
  /// Creates it. Throws ConfigError when that is impossible, or when something is there that
  /// KeepInterrupted leaves alone.
  explicit PartialFolder(const std::filesystem::path& target);
  /// Leaves the folder.
  ~PartialFolder() = default;
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// With these a run begins; summary.json is the last of them.
  static constexpr const char* kStates = "states.csv";
  static constexpr const char* kTiming = "timing.csv";
  static constexpr const char* kTrajectory = "trajectory.tum";
  static constexpr const char* kConfig = "config.yaml";
  static constexpr const char* kSummary = "summary.json";

  /// `write` writes a file of the name that it is told; then it takes the place of `name` in one
  /// step, or none does. Throws what `write` throws, and OutputError.
  void Replace(const std::string& name,
               const std::function<void(const std::filesystem::path&)>& write);

  /// The result is complete: removes the folder.
  void Remove();

 private:
  std::filesystem::path path_;
  FolderLock lock_;
};

/// A text file of which every line is there as a whole: each is written by a call of its own, so
/// that a kill falls between two of them. Not thread-safe.
class LineFile {
 public:
  /// Begins the file with these lines. Throws OutputError.
  LineFile(const std::filesystem::path& file, const std::string& first_lines);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  /// Whole lines, each with its line end. Throws OutputError.
  void Add(const std::string& lines);

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace facet
