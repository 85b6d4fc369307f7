// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/csv_reader.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>
#include <utility>

#include "facet/io/errors.h"

namespace facet {
namespace {

bool IsBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}
bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

template <class T>
std::optional<T> ParseNumber(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

CsvReader::CsvReader(std::filesystem::path file) : file_(std::move(file)) {
  std::error_code error;
  if (!std::filesystem::exists(file_, error)) throw InputError(file_.string() + ": no such file");
  if (std::filesystem::is_directory(file_, error)) {
    throw InputError(file_.string() + ": is a folder, a text file is expected");
  }
  // Somebody else may never write to a pipe.
  if (!std::filesystem::is_regular_file(file_, error))
    throw InputError(file_.string() + ": is a pipe or a device, a text file is expected");
  stream_.open(file_, std::ios::binary);
  if (!stream_) throw InputError(file_.string() + ": cannot be read (permissions?)");
}

bool CsvReader::Next() {
  while (std::getline(stream_, text_)) {
    ++line_;
    std::string_view row = text_;
    if (line_ == 1 && row.starts_with("\xEF\xBB\xBF")) row.remove_prefix(3);
    row = Trim(row);
    if (row.empty() || row.front() == '#' || row.front() == '%') continue;
    Split(row);
    const bool may_be_header = std::exchange(is_first_row_, false);
    if (may_be_header && !ParseDouble(fields_.front())) continue;
    return true;
  }
  if (stream_.bad()) throw InputError(Where() + ": reading failed");
  return false;
}

std::string CsvReader::Where() const {
  return file_.string() + ":" + std::to_string(line_);
}

void CsvReader::Split(std::string_view row) {
  fields_.clear();
  has_commas_ = row.find(',') != std::string_view::npos;
  std::size_t begin = 0;
  while (begin <= row.size()) {
    const std::size_t end =
        std::min(row.find_first_of(has_commas_ ? "," : " \t", begin), row.size());
    const std::string_view field = Trim(row.substr(begin, end - begin));
    if (has_commas_ || !field.empty()) fields_.push_back(field);
    begin = end + 1;
  }
}

std::string_view Trim(std::string_view text) {
  while (!text.empty() && IsBlank(text.front()))
    text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back()))
    text.remove_suffix(1);
  return text;
}

std::optional<std::int64_t> ParseInteger(std::string_view text) {
  return ParseNumber<std::int64_t>(text);
}

std::optional<double> ParseDouble(std::string_view text) {
  return ParseNumber<double>(text);
}

std::optional<std::int64_t> ParseScaledDecimal(std::string_view text, int power) {
  bool negative = false;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  const std::size_t e = text.find_first_of("eE");
  if (e != std::string_view::npos) {
    const auto exponent = ParseInteger(text.substr(e + 1));
    if (!exponent || *exponent < -400 || *exponent > 400) return std::nullopt;
    power += static_cast<int>(*exponent);
    text = text.substr(0, e);
  }
  std::string digits;
  const std::size_t point = std::min(text.find('.'), text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i == point) continue;
    if (!IsDigit(text[i])) return std::nullopt;
    digits.push_back(text[i]);
  }
  if (digits.empty()) return std::nullopt;

  // The integer is made of the digits in front of the shifted point; the one behind it rounds.
  const int num_kept = static_cast<int>(point) + power;
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  std::int64_t value = 0;
  for (int i = 0; i < num_kept; ++i) {
    const int digit = i < static_cast<int>(digits.size()) ? digits[i] - '0' : 0;
    if (value > (kMax - digit) / 10) return std::nullopt;
    value = 10 * value + digit;
  }
  if (num_kept >= 0 && num_kept < static_cast<int>(digits.size()) && digits[num_kept] >= '5') {
    if (value == kMax) return std::nullopt;
    ++value;
  }
  return negative ? -value : value;
}

}  // namespace facet
