// SPDX-License-Identifier: BSD-2-Clause
// Says that a folder is being written by a process that lives.
#pragma once

#include <filesystem>

namespace facet {

/// An open folder that is locked until it is closed, or the process ends in whatever way.
class FolderLock {
 public:
  FolderLock() = default;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock() { Release(); }

  /// False if another process has it, or there is no such folder.
  bool Take(const std::filesystem::path& folder);
  void Release();

 private:
  int descriptor_ = -1;
};

}  // namespace facet
