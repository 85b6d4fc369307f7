// SPDX-License-Identifier: BSD-2-Clause
// What happened in a run more than once is told once, with how often and when last.
#pragma once

#include <string>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// Of one kind.
struct Occurrences {
  int num = 0;
  Timestamp last;

  void Add(Timestamp t, int count = 1) {
    if (count <= 0) return;
    num += count;
    last = t;
  }
  /// ", the last at 12.3 s": seconds from `begin`.
  std::string WhenLast(Timestamp begin) const;
};

/// Not thread-safe.
class WarningLog {
 public:
  /// Texts are of the same kind if their first words are the same but for figures, and so is what
  /// they list between ": " and "; ".
  void Add(Timestamp t, const std::string& text);

  /// In the order in which they came first; those that came again with " (3 times, the last at
  /// 12.3 s)", seconds from `begin`.
  std::vector<std::string> Texts(Timestamp begin) const;

 private:
  struct Entry {
    std::string kind, text;  // as it came first
    Occurrences occurrences;
  };
  std::vector<Entry> entries_;
};

}  // namespace facet
