// SPDX-License-Identifier: BSD-2-Clause
#include "warning_log.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <sstream>

namespace facet {

namespace {

void EraseFigures(std::string& text) {
  std::erase_if(text, [](unsigned char c) {
    return std::isdigit(c) != 0 || c == '.' || c == '-' || c == '+';
  });
}

// The first words, and a list between ": " and "; ", both without figures.
std::string KindOf(const std::string& text) {
  constexpr int kNumWords = 6;
  std::istringstream stream(text);
  std::string kind, word;
  for (int i = 0; i < kNumWords && stream >> word; ++i)
    kind += word + ' ';
  const std::size_t begin = text.find(": "), end = text.find("; ", begin);
  if (begin != std::string::npos && end != std::string::npos)
    kind += text.substr(begin, end - begin);
  EraseFigures(kind);
  return kind;
}

}  // namespace

std::string Occurrences::WhenLast(Timestamp begin) const {
  char text[60];
  std::snprintf(text, sizeof(text), ", the last at %.1f s", ToSeconds(last - begin));
  return text;
}

void WarningLog::Add(Timestamp t, const std::string& text) {
  const std::string kind = KindOf(text);
  auto entry = std::ranges::find(entries_, kind, &Entry::kind);
  if (entry == entries_.end()) entry = entries_.insert(entry, {kind, text, {}});
  entry->occurrences.Add(t);
}

std::vector<std::string> WarningLog::Texts(Timestamp begin) const {
  std::vector<std::string> texts;
  for (const auto& [kind, text, occurrences] : entries_) {
    texts.push_back(text);
    if (occurrences.num == 1) continue;
    texts.back() +=
        " (" + std::to_string(occurrences.num) + " times" + occurrences.WhenLast(begin) + ")";
  }
  return texts;
}

}  // namespace facet
