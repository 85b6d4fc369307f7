// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <chrono>
#include <string>

namespace facet {

/// A progress bar on stderr, drawn at most ten times a second; nothing where stderr is no terminal.
class ProgressBar {
 public:
  explicit ProgressBar(bool is_wanted);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar() { Clear(); }

  void Update(int done, int total, const std::string& note);
  void Clear();  ///< removes it from the screen

 private:
  bool is_active_;
  bool is_drawn_ = false;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace facet
