// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/trajectory_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr std::size_t kNumColumns = 8;
constexpr double kMaxNormError = 0.01;
// No stamp in seconds is that large, and every epoch stamp in nanoseconds is larger.
constexpr double kSmallestEpochNs = 1e14;
// Poses closer than this on the median are not in nanoseconds.
constexpr std::int64_t kSmallestIntervalNs = 20000;

std::string Name(TrajectoryFormat format) {
  return format == TrajectoryFormat::kTum ? "TUM (t tx ty tz qx qy qz qw)"
                                          : "EuRoC csv (t,px,py,pz,qw,qx,qy,qz)";
}

struct Columns {
  std::array<double, kNumColumns> value;  // value[0], the stamp, for its magnitude only
};

Columns ParseColumns(const CsvReader& row, TrajectoryFormat format) {
  if (row.fields().size() < kNumColumns) {
    throw InputError(row.Where() + ": " + std::to_string(row.fields().size()) + " columns, " +
                     Name(format) + " has " + std::to_string(kNumColumns));
  }
  Columns columns{};
  for (std::size_t i = 0; i < kNumColumns; ++i) {
    const auto number = ParseDouble(row.fields()[i]);
    if (!number || !std::isfinite(*number)) {
      throw InputError(row.Where() + ": column " + std::to_string(i + 1) + " is '" +
                       std::string(row.fields()[i]) + "', a finite number is expected in " +
                       Name(format));
    }
    columns.value[i] = *number;
  }
  return columns;
}

// No recording leads further, also not in coordinates of the earth's centre.
constexpr double kLargestPosition_m = 1e7;

SE3 ParsePose(const CsvReader& row, const Columns& columns, TrajectoryFormat format) {
  const auto& c = columns.value;
  const bool w_first = format == TrajectoryFormat::kEurocCsv;
  const Quaterniond q =
      w_first ? Quaterniond(c[4], c[5], c[6], c[7]) : Quaterniond(c[7], c[4], c[5], c[6]);
  if (std::abs(q.norm() - 1.0) > kMaxNormError) {
    throw InputError(row.Where() + ": the quaternion has norm " + std::to_string(q.norm()) +
                     " instead of 1; the columns are not those of " + Name(format));
  }
  const Vector3d p(c[1], c[2], c[3]);
  if (p.cwiseAbs().maxCoeff() > kLargestPosition_m) {
    throw InputError(row.Where() + ": the position is more than " +
                     std::to_string(static_cast<int>(kLargestPosition_m / 1000)) +
                     " km away; positions are in metres");
  }
  return {q.normalized(), p};
}

/// Stamp of a row; `is_ns` tells the unit that the first row of a TUM file was found to have.
Timestamp ParseStamp(const CsvReader& row, TrajectoryFormat format, bool is_ns) {
  const std::string_view text = row.fields().front();
  const bool has_fraction = text.find('.') != std::string_view::npos;
  if (format == TrajectoryFormat::kEurocCsv && has_fraction &&
      std::abs(ParseDouble(text).value_or(0)) < kSmallestEpochNs) {
    throw InputError(
        row.Where() + ": stamp '" + std::string(text) +
        "' looks like seconds; a file with commas is read as EuRoC csv, whose stamps are "
        "nanoseconds (use blanks instead of commas for a TUM file)");
  }
  const auto ns = ParseScaledDecimal(text, is_ns ? 0 : 9);
  if (!ns) {
    throw InputError(row.Where() + ": stamp '" + std::string(text) + "' is out of range for " +
                     Name(format));
  }
  return {*ns};
}

void CheckInterval(const std::filesystem::path& file, const std::vector<StampedPose>& poses) {
  if (poses.size() < 3) return;
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    intervals.push_back(poses[i].t.ns - poses[i - 1].t.ns);
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  if (*middle >= kSmallestIntervalNs) return;
  throw InputError(file.string() + ": poses are " + std::to_string(*middle) +
                   " ns apart; EuRoC csv stamps must be nanoseconds, these look like seconds, "
                   "milliseconds or microseconds");
}

/// Appends the pose, or counts it as a duplicate.
void Append(const CsvReader& row, const StampedPose& pose, Trajectory& trajectory) {
  if (trajectory.poses.empty() || pose.t > trajectory.poses.back().t) {
    trajectory.poses.push_back(pose);
    return;
  }
  if (pose.t < trajectory.poses.back().t) {
    throw InputError(row.Where() + ": the stamp runs backwards by " +
                     std::to_string(ToSeconds(trajectory.poses.back().t - pose.t)) +
                     " s; sort the file by its first column");
  }
  if (trajectory.num_duplicates++ == 0) {
    trajectory.warnings.push_back(row.Where() + ": stamp " + FormatSeconds(pose.t) +
                                  " appears twice");
  }
}

}  // namespace

Trajectory ReadTrajectory(const std::filesystem::path& file) {
  CsvReader row(file);
  Trajectory result;
  std::optional<bool> is_ns;
  while (row.Next()) {
    if (!is_ns) {
      result.format = row.has_commas() ? TrajectoryFormat::kEurocCsv : TrajectoryFormat::kTum;
    }
    const Columns columns = ParseColumns(row, result.format);
    if (!is_ns) {
      const bool tum_in_ns =
          result.format == TrajectoryFormat::kTum && columns.value[0] > kSmallestEpochNs;
      if (tum_in_ns) {
        result.warnings.push_back(file.string() +
                                  ": stamps are nanoseconds where TUM files have seconds; read as "
                                  "nanoseconds, quaternion as qx qy qz qw");
      }
      is_ns = tum_in_ns || result.format == TrajectoryFormat::kEurocCsv;
    }
    const Timestamp t = ParseStamp(row, result.format, *is_ns);
    Append(row, {t, ParsePose(row, columns, result.format)}, result);
  }
  if (result.poses.empty()) throw InputError(file.string() + ": holds no pose");
  if (*is_ns) CheckInterval(file, result.poses);
  if (result.num_duplicates > 0) {
    result.warnings.push_back(file.string() + ": " + std::to_string(result.num_duplicates) +
                              " duplicate stamps, the first pose of each was kept");
  }
  return result;
}

std::string FormatSeconds(Timestamp t) {
  constexpr std::int64_t kNsPerSecond = 1000000000;
  char text[40];
  std::snprintf(text,
                sizeof(text),
                "%s%lld.%09lld",
                t.ns < 0 ? "-" : "",
                std::llabs(t.ns / kNsPerSecond),
                std::llabs(t.ns % kNsPerSecond));
  return text;
}

void SortByTime(std::vector<StampedPose>& poses) {
  std::ranges::stable_sort(poses, {}, &StampedPose::t);
  // std::ranges::unique does not compile with clang 14, which builds the fuzzers.
  const auto is_same = [](const StampedPose& x, const StampedPose& y) { return x.t == y.t; };
  poses.erase(std::unique(poses.begin(), poses.end(), is_same), poses.end());
}

std::string FormatTumLine(const StampedPose& pose) {
  const Vector3d& p = pose.T_WB.p;
  const Quaterniond& q = pose.T_WB.q;
  char text[1200];  // enough for any double
  std::snprintf(text,
                sizeof(text),
                " %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n",
                p.x(),
                p.y(),
                p.z(),
                q.x(),
                q.y(),
                q.z(),
                q.w());
  return FormatSeconds(pose.t) + text;
}

std::string TumHeader() {
  return "# timestamp[s] tx ty tz qx qy qz qw\n";
}

void WriteTum(const std::filesystem::path& file, std::span<const StampedPose> poses) {
  std::ofstream stream(file, std::ios::binary);
  stream << TumHeader();
  for (const StampedPose& pose : poses)
    stream << FormatTumLine(pose);
  stream.flush();
  if (!stream) throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
}

}  // namespace facet
