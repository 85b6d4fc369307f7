// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/random_access_file.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "facet/io/errors.h"

namespace facet {

RandomAccessFile::RandomAccessFile(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw InputError(path.string() + ": no such file");
  }
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) {
    throw InputError(path.string() +
                     ": cannot be opened: " + std::generic_category().message(errno));
  }
  struct stat status {};
  if (fstat(descriptor_, &status) != 0 || status.st_size <= 0) {
    close(descriptor_);
    throw InputError(path.string() + ": the file is empty; copy it again");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

RandomAccessFile::~RandomAccessFile() {
  close(descriptor_);
}

void RandomAccessFile::Fail(std::uint64_t offset, const std::string& text) const {
  throw InputError(PlaceOf(offset) + ": " + text);
}

std::string RandomAccessFile::PlaceOf(std::uint64_t offset) const {
  return path_.string() + ": at byte " + std::to_string(offset);
}

ByteSpan RandomAccessFile::Read(std::uint64_t offset,
                                std::uint64_t size,
                                std::vector<std::uint8_t>& buffer) const {
  if (offset > size_ || size > size_ - offset) {
    Fail(offset,
         "the file ends at byte " + std::to_string(size_) + " where " + std::to_string(size) +
             " bytes are expected; it is truncated or damaged; copy it again, or use the part "
             "before with --duration");
  }
  if (buffer.size() < size) buffer.resize(size);
  std::uint64_t done = 0;
  while (done < size) {
    const ssize_t got =
        pread(descriptor_, buffer.data() + done, size - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) Fail(offset + done, "cannot be read: " + std::generic_category().message(errno));
    done += static_cast<std::uint64_t>(got);
  }
  return {buffer.data(), size};
}

}  // namespace facet
