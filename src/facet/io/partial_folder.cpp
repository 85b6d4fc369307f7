// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/partial_folder.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "facet/io/errors.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

// Of files that have not taken their place yet; hidden.
constexpr const char* kNew = ".new-";

// The folder's name, also where it was given with a slash at the end, as ResultFolder reads it.
fs::path WithSuffix(const fs::path& target, const std::string& suffix) {
  std::error_code error;
  fs::path path = fs::weakly_canonical(fs::absolute(target), error);
  if (error) path = fs::absolute(target);
  if (!path.has_filename()) path = path.parent_path();
  return path.string() + suffix;
}

// A kill in the middle of a line is unlikely, and would make the file one that readers refuse.
void EndWithLastLine(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  std::streamoff size = stream.tellg(), end = size;
  char last = '\0';
  while (end > 0) {
    stream.seekg(end - 1);
    stream.get(last);
    if (last == '\n') break;
    --end;
  }
  stream.close();
  std::error_code ignored;
  if (end < size) fs::resize_file(file, static_cast<std::uintmax_t>(end), ignored);
}

void Repair(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, ignored)) {
    const std::string extension = entry.path().extension().string();
    if (entry.path().filename().string().starts_with(kNew)) fs::remove(entry.path(), ignored);
    if (extension == ".csv" || extension == ".tum") EndWithLastLine(entry.path());
  }
}

bool HasJustBegun(const fs::path& folder) {
  using Partial = PartialFolder;
  std::error_code error;
  return std::ranges::all_of(
      fs::directory_iterator(folder, error), [](const fs::directory_entry& entry) {
        const std::string name = entry.path().filename().string();
        return name.starts_with(kNew) || name == Partial::kStates || name == Partial::kTiming ||
               name == Partial::kTrajectory || name == Partial::kConfig;
      });
}

[[noreturn]] void Fail(const fs::path& file) {
  throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
}

}  // namespace

fs::path KeepInterrupted(const fs::path& target) {
  const fs::path partial = WithSuffix(target, ".partial");
  std::error_code error;
  if (!fs::is_directory(partial, error)) return {};
  FolderLock lock;
  if (!lock.Take(partial)) return {};
  if (!fs::exists(partial / PartialFolder::kSummary, error)) {
    if (HasJustBegun(partial)) fs::remove_all(partial, error);
    return {};
  }
  Repair(partial);
  const fs::path kept = WithSuffix(target, ".interrupted");
  fs::path free = kept;
  for (int i = 2; fs::exists(fs::symlink_status(free, error)); ++i)
    free = kept.string() + "-" + std::to_string(i);
  fs::rename(partial, free, error);
  return error ? fs::path() : free;
}

PartialFolder::PartialFolder(const fs::path& target) : path_(WithSuffix(target, ".partial")) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(path_, error))) {
    throw ConfigError("--out " + target.string() + ": " + path_.string() +
                      " is there, and is written by another run or is not a result of Facet; "
                      "choose another name");
  }
  fs::create_directories(path_, error);
  if (error)
    throw ConfigError("--out " + path_.string() + ": cannot be created: " + error.message());
  lock_.Take(path_);
}

void PartialFolder::Replace(const std::string& name,
                            const std::function<void(const fs::path&)>& write) {
  const fs::path file = path_ / name;
  const fs::path fresh = file.parent_path() / (kNew + file.filename().string());
  std::error_code error;
  try {
    write(fresh);
    fs::rename(fresh, file, error);
    if (error) Fail(file);
  } catch (...) {
    fs::remove(fresh, error);
    throw;
  }
}

void PartialFolder::Remove() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

LineFile::LineFile(const fs::path& file, const std::string& first_lines) : file_(file) {
  constexpr mode_t kEverybodyReads = 0666;  // less what the process's mask takes away
  descriptor_ =
      open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, kEverybodyReads);
  if (descriptor_ < 0) Fail(file);
  Add(first_lines);
}

LineFile::~LineFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void LineFile::Add(const std::string& lines) {
  for (std::string_view left = lines; !left.empty();) {
    std::string_view line = left.substr(0, left.find('\n') + 1);
    left.remove_prefix(line.size());
    while (!line.empty()) {
      const ssize_t written = write(descriptor_, line.data(), line.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) Fail(file_);
      line.remove_prefix(static_cast<std::size_t>(written));
    }
  }
}

}  // namespace facet
