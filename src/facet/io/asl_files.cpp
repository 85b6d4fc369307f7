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
#include "facet/io/stray_stamps.h"

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
    AddProblem(kind, advice, row_.line());
  }
  void AddProblem(const std::string& kind, const std::string& advice, int line) {
    const std::string where = row_.file().string() + ":" + std::to_string(line);
    auto it =
        std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& k) { return k.name == kind; });
    if (it == kinds_.end()) it = kinds_.insert(it, {kind, advice, where, 0});
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

/// The rows of a table whose stamps rise strictly. Others are problems.
template <class Row>
class RisingRows {
 public:
  RisingRows(std::size_t num_to_confirm,
             const CsvReader& csv,
             RowProblems& problems,
             StampCounts& left_out)
      : strays_(num_to_confirm), csv_(csv), problems_(problems), left_out_(left_out) {}

  void Add(Row row) {
    const Timestamp t = row.t;
    strays_.Add({t, csv_.line(), std::move(row)}, Taker(), Leaver());
  }

  std::vector<Row> Finish() {
    strays_.End(Taker(), Leaver());
    rows_.shrink_to_fit();
    return std::move(rows_);
  }

 private:
  struct Line {
    Timestamp t;
    int number = 0;
    Row row;
  };

  auto Taker() {
    return [this](Line line) { Take(std::move(line)); };
  }
  auto Leaver() {
    return [this](const Line& line) {
      problems_.AddProblem("a stamp far away from those of the lines around it",
                           "is a clock set while recording, or a line damaged?",
                           line.number);
    };
  }

  void Take(Line line) {
    if (rows_.empty() || line.t > rows_.back().t) {
      rows_.push_back(std::move(line.row));
    } else if (line.t == rows_.back().t) {
      ++left_out_.num_repeated;
      problems_.AddProblem("a duplicate stamp", "each stamp may appear once", line.number);
    } else {
      ++left_out_.num_backward;
      problems_.AddProblem(
          "a stamp that runs backwards", "sort the lines by their stamp", line.number);
    }
  }

  StrayStamps<Line> strays_;
  const CsvReader& csv_;
  RowProblems& problems_;
  StampCounts& left_out_;
  std::vector<Row> rows_;
};

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

/// Names that are numbers but no stamps of this recording.
std::vector<ImageListEntry> WithoutStrays(std::vector<ImageListEntry> images, int& num_others) {
  std::vector<ImageListEntry> taken;
  StrayStamps<ImageListEntry> strays(kImagesToConfirm);
  const auto take = [&](ImageListEntry image) { taken.push_back(std::move(image)); };
  const auto leave_out = [&](const ImageListEntry&) { ++num_others; };
  for (ImageListEntry& image : images)
    strays.Add(std::move(image), take, leave_out);
  strays.End(take, leave_out);
  return taken;
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
  RisingRows<ImageListEntry> rising(kImagesToConfirm, row, problems, left_out);
  while (row.Next()) {
    problems.AddRow();
    const auto t = ParseStamp(row.fields().front(), problems);
    if (!t) continue;
    const std::string_view name = row.fields().size() > 1 ? row.fields()[1] : std::string_view();
    if (!IsFileName(name, problems)) continue;
    rising.Add({*t, name.empty() ? std::to_string(t->ns) + ".png" : std::string(name)});
  }
  std::vector<ImageListEntry> images = rising.Finish();
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
  images = WithoutStrays(std::move(images), num_others);
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
  RisingRows<ImuSample> rising(kSamplesToConfirm, row, problems, left_out);
  while (row.Next()) {
    problems.AddRow();
    const auto t = ParseStamp(row.fields().front(), problems);
    if (!t) continue;
    if (const auto sample = ParseImu(row, *t, problems)) rising.Add(*sample);
  }
  std::vector<ImuSample> samples = rising.Finish();
  problems.Finish(warnings);
  CheckUnit(csv.string() + ":2", samples);
  return samples;
}

}  // namespace facet
