// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/euroc_csv.h"

#include <charconv>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

namespace facet {

namespace {

struct Row {
  Timestamp t;
  std::vector<double> values;
};

template <class T>
bool ParseNumber(std::string_view text, T& value) {
  while (!text.empty() && text.front() == ' ')
    text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\r'))
    text.remove_suffix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

bool ParseRow(std::string_view line, Row& row) {
  std::size_t comma = line.find(',');
  if (comma == line.npos || !ParseNumber(line.substr(0, comma), row.t.ns)) return false;
  row.values.clear();
  while (comma != line.npos) {
    const std::size_t begin = comma + 1;
    comma = line.find(',', begin);
    double value = 0;
    const std::size_t length = comma == line.npos ? line.npos : comma - begin;
    if (!ParseNumber(line.substr(begin, length), value)) return false;
    row.values.push_back(value);
  }
  return true;
}

/// Calls visit(row) for each line that is not a comment.
template <class Visit>
void ForEachRow(const std::filesystem::path& path, std::size_t min_values, const Visit& visit) {
  std::ifstream file(path);
  const auto fail = [&](int line, const std::string& reason) {
    throw std::runtime_error(path.string() + ":" + std::to_string(line) + ": " + reason);
  };
  if (!file) fail(0, "cannot be opened");
  std::string text;
  Row row;
  Timestamp previous{INT64_MIN};
  for (int line = 1; std::getline(file, text); ++line) {
    if (text.empty() || text[0] == '#' || text[0] == '\r') continue;
    if (!ParseRow(text, row)) fail(line, "not a row of numbers");
    if (row.values.size() < min_values) fail(line, "too few columns");
    if (row.t <= previous) fail(line, "stamps are not in order");
    previous = row.t;
    visit(row);
  }
  if (previous.ns == INT64_MIN) fail(0, "has no rows");
}

/// Three values from column `first`, or `missing` where they are not there or not finite.
Vector3d OptionalVector(const Row& row, std::size_t first, double missing) {
  const Vector3d none = Vector3d::Constant(missing);
  if (row.values.size() < first + 3) return none;
  const Vector3d x = Eigen::Map<const Vector3d>(row.values.data() + first);
  return x.allFinite() ? x : none;
}

}  // namespace

std::vector<NavState> LoadGroundTruthCsv(const std::filesystem::path& path) {
  std::vector<NavState> states;
  ForEachRow(path, 7, [&](const Row& row) {
    const auto& x = row.values;
    NavState state;
    state.t = row.t;
    state.T_WB = SE3(Quaterniond(x[3], x[4], x[5], x[6]).normalized(), {x[0], x[1], x[2]});
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    state.v_WB = OptionalVector(row, 7, 0);
    state.bias = {OptionalVector(row, 10, kNan), OptionalVector(row, 13, kNan)};
    states.push_back(state);
  });
  return states;
}

std::vector<ImuSample> LoadImuCsv(const std::filesystem::path& path) {
  std::vector<ImuSample> samples;
  ForEachRow(path, 6, [&](const Row& row) {
    const auto& x = row.values;
    samples.push_back({row.t, {x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
  });
  return samples;
}

}  // namespace facet
