// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/asl_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr double kSmallestEpochNs = 1e14;
constexpr int kAlwaysTolerated = 10;  // bad lines, however short the file
constexpr int kToleratedShare = 10;   // one in so many

/// Collects what is wrong with a table and decides in the end whether it is still usable.
class RowProblems {
 public:
  explicit RowProblems(const CsvReader& row) : row_(row) {}

  void AddRow() { ++num_rows_; }
  void AddProblem(const std::string& kind, const std::string& advice) {
    auto it =
        std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& k) { return k.name == kind; });
    if (it == kinds_.end()) it = kinds_.insert(it, {kind, advice, row_.Where(), 0});
    ++it->count;
    ++num_bad_;
  }

  /// Throws InputError if too much is bad; otherwise appends one warning for each kind of problem.
  void Finish(std::vector<std::string>& warnings) const {
    if (num_rows_ == 0) {
      throw InputError(row_.file().string() +
                       ": holds no data; the file is empty or only a header");
    }
    const bool is_usable = num_bad_ <= std::max(kAlwaysTolerated, num_rows_ / kToleratedShare) &&
                           2 * num_bad_ < num_rows_;
    for (const Kind& k : kinds_) {
      const std::string counted = k.first_where + ": " + std::to_string(k.count) + " of " +
                                  std::to_string(num_rows_) + " lines have " + k.name;
      if (is_usable) warnings.push_back(counted + " (this is the first); they were skipped");
    }
    if (is_usable) return;
    const Kind& worst =
        *std::max_element(kinds_.begin(), kinds_.end(), [](const Kind& a, const Kind& b) {
          return a.count < b.count;
        });
    throw InputError(worst.first_where + ": " + std::to_string(worst.count) + " of " +
                     std::to_string(num_rows_) + " lines have " + worst.name + "; " + worst.advice);
  }

 private:
  struct Kind {
    std::string name, advice, first_where;
    int count;
  };
  const CsvReader& row_;
  std::vector<Kind> kinds_;
  int num_rows_ = 0;
  int num_bad_ = 0;
};

std::optional<Timestamp> ParseStamp(std::string_view text, RowProblems& problems) {
  if (const auto ns = ParseInteger(text)) return Timestamp{*ns};
  const auto number = ParseDouble(text);
  if (number && std::isfinite(*number) && std::abs(*number) < kSmallestEpochNs) {
    problems.AddProblem("stamps that look like seconds",
                        "stamps must be integer nanoseconds: multiply them by 1e9");
    return std::nullopt;
  }
  const auto ns = ParseScaledDecimal(text, 0);
  if (!ns) {
    problems.AddProblem("a first column that is no stamp", "it must be integer nanoseconds");
    return std::nullopt;
  }
  return Timestamp{*ns};
}

/// Whether t is later than the last accepted row.
template <class Row>
bool IsNext(Timestamp t,
            const std::vector<Row>& rows,
            RowProblems& problems,
            StampCounts& left_out) {
  if (rows.empty() || t > rows.back().t) return true;
  if (t == rows.back().t) {
    ++left_out.num_repeated;
    problems.AddProblem("a duplicate stamp", "each stamp may appear once");
  } else {
    ++left_out.num_backward;
    problems.AddProblem("a stamp that runs backwards", "sort the lines by their stamp");
  }
  return false;
}

/// Integer stamps of another unit show by their spacing: no camera or IMU runs at 50 kHz.
template <class Row>
void CheckUnit(const std::string& where, const std::vector<Row>& rows) {
  if (rows.size() < 2) return;
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < rows.size(); ++i)
    intervals.push_back(rows[i].t.ns - rows[i - 1].t.ns);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  constexpr std::int64_t kSmallestNs = 20000;
  if (*middle >= kSmallestNs) return;
  const char* unit = *middle >= 100 ? "microseconds" : *middle > 1 ? "milliseconds" : "seconds";
  throw InputError(where + ": stamps are " + std::to_string(*middle) +
                   " apart; they must be nanoseconds and look like " + unit);
}

/// The system would end the name at a NUL byte and open another file. Where a name leads to does
/// not matter: `../cam0/data/1.png` and links are somebody's way to save space, and images are only
/// read.
bool IsFileName(std::string_view name, RowProblems& problems) {
  const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; };
  if (std::ranges::none_of(name, is_control)) return true;
  problems.AddProblem("a file name with NUL bytes or other control characters",
                      "a stamp, a comma and the name of the image are expected: is the file "
                      "damaged, or no UTF-8?");
  return false;
}

std::optional<ImuSample> ParseImu(const CsvReader& row, Timestamp t, RowProblems& problems) {
  std::array<double, 6> value{};
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto number =
        i + 1 < row.fields().size() ? ParseDouble(row.fields()[i + 1]) : std::nullopt;
    if (!number) {
      problems.AddProblem("missing or unreadable numbers",
                          "7 columns are expected: stamp, wx, wy, wz [rad/s], ax, ay, az [m/s^2]");
      return std::nullopt;
    }
    if (!std::isfinite(*number)) {
      problems.AddProblem("values that are not finite", "remove or repair them");
      return std::nullopt;
    }
    value[i] = *number;
  }
  return ImuSample{t, {value[0], value[1], value[2]}, {value[3], value[4], value[5]}};
}

}  // namespace

std::vector<ImageListEntry> ReadImageList(const std::filesystem::path& csv,
                                          std::vector<std::string>& warnings,
                                          StampCounts& left_out) {
  CsvReader row(csv);
  RowProblems problems(row);
  std::vector<ImageListEntry> images;
  while (row.Next()) {
    problems.AddRow();
    const auto t = ParseStamp(row.fields().front(), problems);
    if (!t) continue;
    if (!IsNext(*t, images, problems, left_out)) continue;
    const std::string_view name = row.fields().size() > 1 ? row.fields()[1] : std::string_view();
    if (!IsFileName(name, problems)) continue;
    images.push_back({*t, name.empty() ? std::to_string(t->ns) + ".png" : std::string(name)});
  }
  problems.Finish(warnings);
  CheckUnit(csv.string() + ":2", images);
  return images;
}

std::vector<ImageListEntry> ListImageFolder(const std::filesystem::path& folder,
                                            std::vector<std::string>& warnings) {
  constexpr std::array kExtensions = {".png", ".jpg", ".jpeg", ".webp", ".pgm"};
  std::vector<ImageListEntry> images;
  int num_others = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::filesystem::path file = entry.path().filename();
    const bool is_image =
        std::ranges::find(kExtensions, file.extension().string()) != kExtensions.end();
    const auto ns = ParseInteger(file.stem().string());
    if (is_image && ns) {
      images.push_back({Timestamp{*ns}, file.string()});
    } else {
      ++num_others;
    }
  }
  const auto order = [](const ImageListEntry& image) { return std::pair(image.t, image.file); };
  std::ranges::sort(images, {}, order);
  const auto is_same = [](const ImageListEntry& a, const ImageListEntry& b) { return a.t == b.t; };
  const auto same = std::unique(images.begin(), images.end(), is_same);
  num_others += static_cast<int>(images.end() - same);
  images.erase(same, images.end());
  if (images.empty()) {
    throw InputError(folder.string() +
                     ": no image that is named by its stamp in nanoseconds, such as "
                     "1403636579763555584.png; name them so, or write a times.csv");
  }
  if (num_others > 0) {
    warnings.push_back(folder.string() + ": " + std::to_string(num_others) +
                       " files are no images named by stamps of their own and are not used");
  }
  CheckUnit(folder.string(), images);
  return images;
}

std::vector<ImuSample> ReadImuFile(const std::filesystem::path& csv,
                                   std::vector<std::string>& warnings,
                                   StampCounts& left_out) {
  CsvReader row(csv);
  RowProblems problems(row);
  std::vector<ImuSample> samples;
  while (row.Next()) {
    problems.AddRow();
    const auto t = ParseStamp(row.fields().front(), problems);
    if (!t) continue;
    if (!IsNext(*t, samples, problems, left_out)) continue;
    if (const auto sample = ParseImu(row, *t, problems)) samples.push_back(*sample);
  }
  problems.Finish(warnings);
  CheckUnit(csv.string() + ":2", samples);
  return samples;
}

}  // namespace facet
