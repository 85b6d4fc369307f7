// SPDX-License-Identifier: BSD-2-Clause
// A folder that appears as a whole or not at all.
#pragma once

#include <filesystem>

#include "facet/io/folder_lock.h"

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
  void RemoveLeftOvers() const;
  void CreateStaging(const std::filesystem::path& named);
  void ExchangeWithTarget();

  std::filesystem::path target_;
  std::filesystem::path staging_;
  FolderLock lock_;  ///< on the staging folder
};

}  // namespace facet
