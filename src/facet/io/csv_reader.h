// SPDX-License-Identifier: BSD-2-Clause
// Tables in text: ASL/EuRoC csv files and TUM trajectories, line by line in constant memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// Reads one row at a time. Fields are separated by commas, or by blanks in a line without a comma.
///
/// Skips empty lines, comments (`#`, `%`) and a header without a comment sign (a first line that
/// does not begin with a number). Copes with CRLF and a byte-order mark. Not thread-safe.
class CsvReader {
 public:
  /// Throws InputError when the file cannot be opened.
  explicit CsvReader(std::filesystem::path file);

  /// Moves to the next row; false at the end of the file.
  bool Next();

  /// Fields of the row without surrounding blanks; valid until the next call of Next.
  const std::vector<std::string_view>& fields() const { return fields_; }
  bool has_commas() const { return has_commas_; }

  int line() const { return line_; }  ///< of the row, from 1
  const std::filesystem::path& file() const { return file_; }
  std::string Where() const;  ///< "file:line"

 private:
  void Split(std::string_view row);

  std::filesystem::path file_;
  std::ifstream stream_;
  std::string text_;
  std::vector<std::string_view> fields_;
  bool has_commas_ = false;
  bool is_first_row_ = true;
  int line_ = 0;
};

/// Without blanks at both ends.
std::string_view Trim(std::string_view text);

/// The whole text must be the number; a leading plus sign is allowed.
std::optional<std::int64_t> ParseInteger(std::string_view text);

/// The whole text must be the number; accepts nan and inf.
std::optional<double> ParseDouble(std::string_view text);

/// Exact value of a decimal number times 10^power, rounded to the nearest integer: "1403.5e-1" with
/// power 3 gives 140350. For stamps, which have more digits than a double. Empty when it is not a
/// finite number or does not fit.
std::optional<std::int64_t> ParseScaledDecimal(std::string_view text, int power);

}  // namespace facet
