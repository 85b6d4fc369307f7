// SPDX-License-Identifier: BSD-2-Clause
// A folder that appears as a whole or not at all.
#pragma once

#include <filesystem>

namespace facet {

/// Files are written into a hidden sibling of the target, which takes the target's place in one
/// step.
class ResultFolder {
 public:
  /// Creates the sibling (and the parent folders), and removes those that dead processes left
  /// behind for the same target; live ones hold a lock on theirs. Throws ConfigError when that is
  /// impossible, or when the target exists and is neither an earlier result (it has a summary.json)
  /// nor an empty folder: nobody's other files are ever deleted.
  explicit ResultFolder(const std::filesystem::path& target);
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;
  /// Without Commit everything that was written is removed.
  ~ResultFolder();

  const std::filesystem::path& target() const { return target_; }
  const std::filesystem::path& staging() const { return staging_; }  ///< write here

  /// Puts the new folder in place of the old one, as soon as it is on the disk. Throws OutputError;
  /// the old one is then untouched.
  void Commit();

 private:
  /// An open folder that is locked until it is closed, or the process ends in whatever way.
  class Lock {
   public:
    Lock() = default;
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;
    ~Lock() { Release(); }
    /// False if another process has it, or there is no such folder.
    bool Take(const std::filesystem::path& folder);
    void Release();

   private:
    int descriptor_ = -1;
  };

  void RemoveLeftOvers() const;
  void CreateStaging(const std::filesystem::path& named);
  void ExchangeWithTarget();

  std::filesystem::path target_;
  std::filesystem::path staging_;
  Lock lock_;  ///< on the staging folder
};

}  // namespace facet
