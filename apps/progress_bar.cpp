// SPDX-License-Identifier: BSD-2-Clause
#include "progress_bar.h"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

namespace facet {

ProgressBar::ProgressBar(bool is_wanted) : is_active_(is_wanted && isatty(STDERR_FILENO) == 1) {}

void ProgressBar::Update(int done, int total, const std::string& note) {
  if (!is_active_) return;
  const auto now = std::chrono::steady_clock::now();
  if (is_drawn_ && done < total && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  is_drawn_ = true;
  constexpr int kWidth = 40;
  const int filled = std::clamp(kWidth * done / std::max(total, 1), 0, kWidth);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kWidth - filled), '.');
  std::fprintf(stderr, "\r\033[K[%s] %d/%d  %s", bar.c_str(), done, total, note.c_str());
  std::fflush(stderr);
}

void ProgressBar::Clear() {
  if (is_drawn_) std::fputs("\r\033[K", stderr);
  is_drawn_ = false;
}

}  // namespace facet
