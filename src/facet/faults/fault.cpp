// SPDX-License-Identifier: BSD-2-Clause
#include "facet/faults/fault.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "facet/faults/fault_kind.h"
#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {

namespace {

const std::vector<FaultKind>& Kinds() {
  static const std::vector<FaultKind> kinds = [] {
    std::vector<FaultKind> all = ImuFaults();
    for (const auto& more : {StampFaults(), ImageFaults(), RigFaults()})
      all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return kinds;
}

std::string Parameters(const FaultKind& kind) {
  std::string text;
  for (const auto& [name, value] : kind.defaults) {
    std::ostringstream number;
    number << name << '=' << value;
    text += (text.empty() ? ":" : ",") + number.str();
  }
  return text;
}

FaultValues ParseValues(const std::string& text, const FaultKind& kind) {
  constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
  FaultValues values = kind.defaults;
  std::istringstream stream(text);
  for (std::string entry; std::getline(stream, entry, ',');) {
    const std::size_t equal = entry.find('=');
    const std::string name = entry.substr(0, equal);
    const double value = equal == std::string::npos
                             ? kNotANumber
                             : ParseDouble(entry.substr(equal + 1)).value_or(kNotANumber);
    if (values.count(name) == 0 || !std::isfinite(value)) {
      throw ConfigError("--fault " + kind.name + ": '" + entry +
                        "' is no parameter with a number; known: " + kind.name + Parameters(kind));
    }
    values[name] = value;
  }
  const auto axis = values.find("axis");
  if (axis != values.end() && axis->second != 0 && axis->second != 1 && axis->second != 2)
    throw ConfigError("--fault " + kind.name + ": axis is 0, 1 or 2");
  return values;
}

}  // namespace

void PlantFault(const std::string& fault, RecordingCopy& recording) {
  const std::size_t colon = fault.find(':');
  const std::string name = fault.substr(0, colon);
  const auto kind = std::find_if(
      Kinds().begin(), Kinds().end(), [&](const FaultKind& k) { return k.name == name; });
  if (kind == Kinds().end())
    throw ConfigError("--fault '" + name + "' is not known; known are\n" + ListFaults());
  const std::string rest = colon == std::string::npos ? "" : fault.substr(colon + 1);
  kind->plant(ParseValues(rest, *kind), recording);
}

std::string ListFaults() {
  std::string text;
  for (const FaultKind& kind : Kinds())
    text += "  " + kind.name + Parameters(kind) + "\n      " + kind.meaning + "\n";
  return text;
}

}  // namespace facet
