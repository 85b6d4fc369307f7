// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <cstdarg>
#include <cstdio>

#include "facet/check/finding.h"

namespace facet {

bool CheckReport::Has(const std::string& name) const {
  return std::ranges::any_of(findings, [&](const Finding& f) { return f.name == name; });
}

std::string Text(const char* format, ...) {
  char text[600];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

double MedianOf(std::vector<double>& values) {
  return QuantileOf(values, 0.5);
}

double QuantileOf(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  const double place = share * static_cast<double>(values.size());
  const auto nth = std::min(static_cast<std::size_t>(std::max(place, 0.0)), values.size() - 1);
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(nth));
  return values[nth];
}

}  // namespace facet
