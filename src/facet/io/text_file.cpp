// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/text_file.h"

#include <fstream>
#include <system_error>

#include "facet/io/errors.h"
#include "facet/io/sync_to_disk.h"

namespace facet {

namespace fs = std::filesystem;

namespace {

bool Write(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  return static_cast<bool>(stream);
}

[[noreturn]] void Fail(const fs::path& file) {
  throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
}

}  // namespace

void WriteTextFile(const fs::path& file, const std::string& text) {
  if (!Write(file, text)) Fail(file);
}

void ReplaceTextFile(const fs::path& file, const std::string& text) {
  const fs::path partial = file.string() + ".partial";
  std::error_code error;
  try {
    if (!Write(partial, text)) Fail(file);
    SyncToDisk(partial);
    fs::rename(partial, file, error);
    if (error) Fail(file);
  } catch (const OutputError&) {
    fs::remove(partial, error);
    throw;
  }
}

}  // namespace facet
