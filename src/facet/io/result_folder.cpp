// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/result_folder.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include "facet/io/errors.h"
#include "facet/io/sync_to_disk.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

void CheckReplaceable(const fs::path& target) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(target, error))) return;
  if (!fs::is_directory(target, error)) {
    throw ConfigError("--out " + target.string() +
                      ": exists and is not a folder; choose another name");
  }
  if (fs::is_empty(target, error) || fs::exists(target / "summary.json", error)) return;
  throw ConfigError("--out " + target.string() +
                    ": exists and is not a result of Facet (no summary.json); choose another name");
}

// Hidden, and with the number of the process: two may write the same result, the last one wins.
std::string StagingStem(const fs::path& target) {
  std::string name = ".";
  name += target.filename().string();
  return name + ".partial-";
}

bool IsNumber(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

// What follows the name of a result that could not be exchanged but had to make room.
constexpr const char* kOld = "-old";

}  // namespace

ResultFolder::ResultFolder(const fs::path& target) {
  std::error_code error;
  target_ = fs::weakly_canonical(fs::absolute(target), error);
  if (error) target_ = fs::absolute(target);
  if (!target_.has_filename()) target_ = target_.parent_path();
  CheckReplaceable(target_);
  RemoveLeftOvers();
  CreateStaging(target);
}

void ResultFolder::CreateStaging(const fs::path& named) {
  const fs::path staging =
      target_.parent_path() / (StagingStem(target_) + std::to_string(getpid()));
  std::error_code error;
  fs::create_directories(target_.parent_path(), error);
  // A process that begins at the same time may take it for a left-over before it is locked.
  constexpr int kMaxTries = 5;
  for (int i = 0; i < kMaxTries && !error; ++i) {
    fs::remove_all(staging, error);
    if (!error) fs::create_directory(staging, error);
    if (!error && (lock_.Take(staging) || i + 1 == kMaxTries) && fs::exists(staging)) break;
  }
  if (error) {
    throw ConfigError("--out " + named.string() + ": cannot be created: " + error.message());
  }
  staging_ = staging;
}

// Whoever was killed could not remove what it had written.
void ResultFolder::RemoveLeftOvers() const {
  const std::string stem = StagingStem(target_);
  std::error_code error;
  std::vector<std::string> numbers;
  for (const fs::directory_entry& entry : fs::directory_iterator(target_.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(stem)) numbers.push_back(name.substr(stem.size()));
  }
  for (std::string number : numbers) {
    const fs::path left_over = target_.parent_path() / (stem + number);
    const bool is_old = number.ends_with(kOld);
    if (is_old) number.resize(number.size() - std::strlen(kOld));
    if (!IsNumber(number)) continue;
    const fs::path staging = target_.parent_path() / (stem + number);
    FolderLock lock;
    if (fs::exists(staging, error) && !lock.Take(staging)) continue;
    // Killed between two renames: the old result is still the only one.
    if (is_old && !fs::exists(target_, error)) {
      fs::rename(left_over, target_, error);
    } else {
      fs::remove_all(left_over, error);
    }
  }
}

ResultFolder::~ResultFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
}

void ResultFolder::Commit() {
  CheckReplaceable(target_);
  SyncToDisk(staging_);
  std::error_code error;
  if (!fs::exists(target_, error)) {
    fs::rename(staging_, target_, error);
    if (error) throw OutputError(target_.string() + ": cannot be created: " + error.message());
    staging_.clear();
    return;
  }
  ExchangeWithTarget();
  fs::remove_all(staging_, error);
  staging_.clear();
}

/// Afterwards the old result is in the staging folder.
void ResultFolder::ExchangeWithTarget() {
  if (renameat2(AT_FDCWD, staging_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0)
    return;
  std::error_code error(errno, std::generic_category());
  if (error.value() == EINVAL || error.value() == ENOSYS) {
    // A file system that cannot exchange: the target is absent for a moment.
    const fs::path old = staging_.string() + kOld;
    fs::rename(target_, old, error);
    if (!error) {
      fs::rename(staging_, target_, error);
      if (error) fs::rename(old, target_);
    }
    if (!error) staging_ = old;
  }
  if (error) throw OutputError(target_.string() + ": cannot be replaced: " + error.message());
}

}  // namespace facet
