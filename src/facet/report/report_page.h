// SPDX-License-Identifier: BSD-2-Clause
// A report as a folder: report.html, which needs nothing else, and beside it the numbers as
// report.json and each figure as SVG (and PNG where rsvg-convert is installed).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "facet/report/figures.h"
#include "facet/report/report_run.h"
#include "facet/report/table.h"

namespace facet {

/// Runs over one recording.
struct ReportSection {
  std::string name;
  std::string truth;
  std::string remark;  ///< a sentence about the runs; may be empty
  std::vector<ReportRun> runs;
  std::string scene_page;            ///< HTML of a page that shows the runs in 3D; may be empty
  std::vector<ReportFigure> images;  ///< of the camera at some moments; may be empty
};

struct Report {
  std::string title;
  std::vector<ReportSection> sections;
  /// The comparison.json of `facet compare`; null for a report about single runs.
  nlohmann::ordered_json comparison;
};

/// Every number that the page shows in a table: {"comparison": ..., "sections": [{"name", "runs":
/// [{"name", "evaluation", "summary"}]}]}.
nlohmann::ordered_json ReportDocument(const Report& report);

/// The page. Each number of the document carries its place as data-pointer.
std::string ReportHtml(const Report& report);

/// Writes into a folder that is created if need be; files of an earlier report are replaced, others
/// are left alone. Throws ConfigError when the folder cannot be created, OutputError when a file
/// cannot be written.
void WriteReport(const std::filesystem::path& folder, const Report& report);

}  // namespace facet
