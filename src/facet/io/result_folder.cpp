// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/result_folder.h"

#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include "facet/io/errors.h"

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

}  // namespace

ResultFolder::ResultFolder(const fs::path& target) {
  std::error_code error;
  target_ = fs::weakly_canonical(fs::absolute(target), error);
  if (error) target_ = fs::absolute(target);
  if (!target_.has_filename()) target_ = target_.parent_path();
  CheckReplaceable(target_);
  std::string name = ".";
  name += target_.filename().string();
  name += ".partial-" + std::to_string(getpid());
  const fs::path staging = target_.parent_path() / name;
  fs::create_directories(target_.parent_path(), error);
  if (!error) fs::remove_all(staging, error);
  if (!error) fs::create_directory(staging, error);
  if (error) {
    throw ConfigError("--out " + target.string() + ": cannot be created: " + error.message());
  }
  staging_ = staging;
}

ResultFolder::~ResultFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
}

void ResultFolder::Commit() {
  CheckReplaceable(target_);
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
    const fs::path old = staging_.string() + "-old";
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
