// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/table.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace facet {
namespace {

std::string Pad(const std::string& text, std::size_t width, bool right) {
  const std::string blanks(text.size() < width ? width - text.size() : 0, ' ');
  return right ? blanks + text : text + blanks;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char c : text)
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string MarkdownField(std::string text) {
  for (std::size_t i = 0; (i = text.find('|', i)) != std::string::npos; i += 2)
    text.replace(i, 1, "\\|");
  return text;
}

}  // namespace

std::string FormatNumber(const std::string& format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format.c_str(), value);
  return text;
}

TableCell NumberCell(const nlohmann::ordered_json& document,
                     const std::string& pointer,
                     const std::string& format,
                     double factor) {
  const nlohmann::ordered_json::json_pointer place(pointer);
  if (!document.contains(place) || !document[place].is_number()) return {"-", "", "", 1};
  const double value = document[place].get<double>();
  return {FormatNumber(format, factor * value), pointer, format, factor};
}

std::string ToText(const Table& table) {
  std::vector<std::size_t> widths;
  for (const std::string& name : table.header)
    widths.push_back(name.size());
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size() && c < widths.size(); ++c)
      widths[c] = std::max(widths[c], row[c].text.size());
  }
  std::string text = table.title + '\n';
  const auto add = [&](std::size_t column, const std::string& cell) {
    text += (column > 0 ? "  " : "") + Pad(cell, widths[column], column > 0);
  };
  for (std::size_t c = 0; c < table.header.size(); ++c)
    add(c, table.header[c]);
  text += '\n';
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size() && c < widths.size(); ++c)
      add(c, row[c].text);
    text += '\n';
  }
  for (const std::string& note : table.notes)
    text += "  " + note + '\n';
  return text;
}

std::string ToMarkdown(const Table& table) {
  std::string text = "### " + table.title + "\n\n|";
  for (const std::string& name : table.header)
    text += ' ' + MarkdownField(name) + " |";
  text += "\n|";
  for (std::size_t c = 0; c < table.header.size(); ++c)
    text += c == 0 ? "---|" : "---:|";
  text += '\n';
  for (const auto& row : table.rows) {
    text += '|';
    for (const TableCell& cell : row)
      text += ' ' + MarkdownField(cell.text) + " |";
    text += '\n';
  }
  text += '\n';
  for (const std::string& note : table.notes)
    text += note + "\n\n";
  return text;
}

std::string ToCsv(const Table& table) {
  std::string text;
  const auto add = [&text](std::size_t column, const std::string& field) {
    text += (column > 0 ? "," : "") + CsvField(field);
  };
  text += "# " + table.title + '\n';
  for (std::size_t c = 0; c < table.header.size(); ++c)
    add(c, table.header[c]);
  text += '\n';
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c)
      add(c, row[c].text);
    text += '\n';
  }
  return text;
}

std::string ToHtml(const Table& table, const std::string& prefix) {
  std::string html = "<h3>" + EscapeHtml(table.title) + "</h3>\n<div class=\"wide\"><table>\n<tr>";
  for (const std::string& name : table.header)
    html += "<th>" + EscapeHtml(name) + "</th>";
  html += "</tr>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const TableCell& cell : row) {
      html += "<td";
      if (!cell.pointer.empty()) {
        html += " data-pointer=\"" + EscapeHtml(prefix + cell.pointer) + "\" data-format=\"" +
                cell.format + "\" data-factor=\"" + FormatNumber("%.17g", cell.factor) + "\"";
      }
      html += ">" + EscapeHtml(cell.text) + "</td>";
    }
    html += "</tr>\n";
  }
  html += "</table></div>\n";
  for (const std::string& note : table.notes)
    html += "<p class=\"note\">" + EscapeHtml(note) + "</p>\n";
  return html;
}

std::string EscapeHtml(const std::string& text) {
  std::string escaped;
  for (char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace facet
