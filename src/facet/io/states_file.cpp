// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/states_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr double kMaxNormError = 0.01;

std::map<std::string, std::size_t> ColumnsByName(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string header;
  std::getline(stream, header);
  std::map<std::string, std::size_t> columns;
  std::istringstream names(header);
  std::string name;
  for (std::size_t i = 0; std::getline(names, name, ','); ++i)
    columns.emplace(Trim(name), i);
  return columns;
}

double NumberOrNan(const CsvReader& row, std::size_t column) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (column >= row.fields().size()) return kNan;
  const auto value = ParseDouble(row.fields()[column]);
  return value && std::isfinite(*value) ? *value : kNan;
}

Quaterniond UnitQuaternion(const CsvReader& row, double w, double x, double y, double z) {
  const Quaterniond q(w, x, y, z);
  if (!(std::abs(q.norm() - 1) <= kMaxNormError)) {
    throw InputError(row.Where() + ": the quaternion has norm " + std::to_string(q.norm()) +
                     " instead of 1 (columns qw qx qy qz)");
  }
  return q.normalized();
}

// The columns of states.csv, by name.
class StateColumns {
 public:
  explicit StateColumns(const std::filesystem::path& file)
      : file_(file), columns_(ColumnsByName(file)) {
    for (const char* name : {"timestamp_ns", "px", "qw", "vx", "sigma_px", "sigma_rx"}) {
      if (!columns_.contains(name)) {
        throw InputError(file.string() + ":1: there is no column '" + name +
                         "'; is it the states.csv of 'facet run'?");
      }
    }
  }

  // A line that was cut short would pass for one whose values are unknown.
  void RequireAll(const CsvReader& row) const {
    if (row.fields().size() >= columns_.size()) return;
    throw InputError(row.Where() + ": " + std::to_string(row.fields().size()) +
                     " columns, the header has " + std::to_string(columns_.size()));
  }

  double Get(const CsvReader& row, const std::string& name) const {
    const auto column = columns_.find(name);
    return NumberOrNan(row, column == columns_.end() ? row.fields().size() : column->second);
  }

  // px, py, pz for "p"; all nan if one of them is.
  Vector3d Get3(const CsvReader& row, const std::string& stem) const {
    const Vector3d v(Get(row, stem + "x"), Get(row, stem + "y"), Get(row, stem + "z"));
    return v.allFinite() ? v : Unknown3();
  }

  // The same for a 1-sigma, which is unknown only where it is empty or "nan": what is negative or
  // infinite would drop out of every statistic without a word.
  Vector3d GetSigma3(const CsvReader& row, const std::string& stem) const {
    for (const char* axis : {"x", "y", "z"}) {
      const auto column = columns_.find(stem + axis);
      // Where a name stands twice in the header, a row that has enough columns may still end early.
      if (column == columns_.end() || column->second >= row.fields().size()) continue;
      const std::string_view text = row.fields()[column->second];
      const auto sigma = ParseDouble(text);
      const bool is_unknown = text.empty() || (sigma && std::isnan(*sigma));
      if (is_unknown || (sigma && *sigma >= 0 && std::isfinite(*sigma))) continue;
      throw InputError(row.Where() + ": " + column->first + " is '" + std::string(text) +
                       "'; a 1-sigma is a number from 0 on, or empty where it is unknown");
    }
    return Get3(row, stem);
  }

 private:
  std::filesystem::path file_;
  std::map<std::string, std::size_t> columns_;
};

Timestamp StampOf(const CsvReader& row) {
  const auto ns = ParseScaledDecimal(row.fields().front(), 0);
  if (!ns) {
    throw InputError(row.Where() + ": stamp '" + std::string(row.fields().front()) +
                     "' is not a number of nanoseconds");
  }
  return {*ns};
}

}  // namespace

std::vector<EstimatedState> ReadStates(const std::filesystem::path& file) {
  CsvReader row(file);
  const StateColumns columns(file);
  std::vector<EstimatedState> states;
  while (row.Next()) {
    columns.RequireAll(row);
    EstimatedState s;
    s.state.t = StampOf(row);
    s.state.T_WB.p = columns.Get3(row, "p");
    if (!s.state.T_WB.p.allFinite()) continue;
    s.state.T_WB.q = UnitQuaternion(row,
                                    columns.Get(row, "qw"),
                                    columns.Get(row, "qx"),
                                    columns.Get(row, "qy"),
                                    columns.Get(row, "qz"));
    const double segment = columns.Get(row, "segment");
    if (segment >= 0 && segment < 1e6) s.segment = static_cast<int>(segment);
    s.state.v_WB = columns.Get3(row, "v");
    s.state.bias = {columns.Get3(row, "bg"), columns.Get3(row, "ba")};
    s.sigma_p = columns.GetSigma3(row, "sigma_p");
    s.sigma_theta = columns.GetSigma3(row, "sigma_r");
    s.sigma_v = columns.GetSigma3(row, "sigma_v");
    s.sigma_b_g = columns.GetSigma3(row, "sigma_bg");
    s.sigma_b_a = columns.GetSigma3(row, "sigma_ba");
    states.push_back(s);
  }
  return states;
}

std::vector<NavState> ReadTrueStates(const std::filesystem::path& file) {
  CsvReader row(file);
  std::vector<NavState> states;
  while (row.Next()) {
    const auto vector = [&row](std::size_t i) {
      return Vector3d(NumberOrNan(row, i), NumberOrNan(row, i + 1), NumberOrNan(row, i + 2));
    };
    NavState s;
    s.t = StampOf(row);
    s.T_WB.p = vector(1);
    if (!s.T_WB.p.allFinite()) throw InputError(row.Where() + ": the position is not finite");
    s.T_WB.q = UnitQuaternion(
        row, NumberOrNan(row, 4), NumberOrNan(row, 5), NumberOrNan(row, 6), NumberOrNan(row, 7));
    s.v_WB = vector(8);
    s.bias = {vector(11), vector(14)};
    states.push_back(s);
  }
  std::ranges::stable_sort(states, {}, &NavState::t);
  return states;
}

}  // namespace facet
