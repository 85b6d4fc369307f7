// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/sync_to_disk.h"

#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "facet/io/errors.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

void SyncOne(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  int error = descriptor < 0 ? errno : 0;
  if (descriptor >= 0) {
    if (fsync(descriptor) != 0 && errno != EINVAL && errno != ENOSYS && errno != EROFS)
      error = errno;
    close(descriptor);
  }
  if (error == 0) return;
  throw OutputError(path.string() +
                    ": cannot be brought to the disk: " + std::generic_category().message(error));
}

}  // namespace

void SyncToDisk(const fs::path& file_or_folder) {
  if (fs::is_directory(file_or_folder)) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(file_or_folder)) {
      if (entry.is_regular_file() || entry.is_directory()) SyncOne(entry.path());
    }
  }
  SyncOne(file_or_folder);
}

}  // namespace facet
