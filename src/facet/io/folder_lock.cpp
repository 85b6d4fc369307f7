// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace facet {

bool FolderLock::Take(const std::filesystem::path& folder) {
  Release();
  descriptor_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) return false;
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return true;
  Release();
  return false;
}

void FolderLock::Release() {
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = -1;
}

}  // namespace facet
