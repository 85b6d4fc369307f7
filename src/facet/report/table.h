// SPDX-License-Identifier: BSD-2-Clause
// Tables of numbers out of a JSON document, written as text, Markdown, CSV or HTML. Each number
// remembers where in the document it stands, so that a page can be checked against it.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace facet {

/// A text, or a number of the document: factor * value, printed with a printf format.
struct TableCell {
  std::string text;
  std::string pointer;  ///< JSON pointer; empty: not a number of the document
  std::string format;
  double factor = 1;
};

struct Table {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<TableCell>> rows;  ///< the first column holds names
  std::vector<std::string> notes;            ///< what a reader must know, one sentence each
};

/// The number at `pointer`, or "-" where the document has none.
TableCell NumberCell(const nlohmann::ordered_json& document,
                     const std::string& pointer,
                     const std::string& format,
                     double factor = 1);

std::string FormatNumber(const std::string& format, double value);

std::string ToText(const Table& table);  ///< aligned columns, for a terminal
std::string ToMarkdown(const Table& table);
std::string ToCsv(const Table& table);
/// `prefix` goes before every pointer, for a table of a part of the page's document.
std::string ToHtml(const Table& table, const std::string& prefix = "");

/// Returns the text with &, <, > and quotes replaced.
std::string EscapeHtml(const std::string& text);

}  // namespace facet
