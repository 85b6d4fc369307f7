// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/report_page.h"

#include <algorithm>
#include <map>
#include <set>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "facet/io/errors.h"
#include "facet/io/json_file.h"
#include "facet/io/text_file.h"
#include "facet/report/comparison.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kStyle = R"(
body{font:15px/1.5 system-ui,"DejaVu Sans",Helvetica,Arial,sans-serif;color:#222;background:#fff;
 max-width:1180px;margin:24px auto;padding:0 20px}
h1{font-size:26px;margin:0 0 4px}h2{font-size:21px;border-bottom:2px solid #1f6fb4;padding-bottom:3px;margin-top:38px}
h3{font-size:16px;margin:26px 0 6px}.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}
th,td{padding:3px 10px;border-bottom:1px solid #e3e3e3;text-align:right;white-space:nowrap}
th{background:#f2f5f8;position:sticky;top:0;white-space:normal;vertical-align:bottom}
th:first-child{white-space:nowrap}td:first-child,th:first-child,td.text{text-align:left}
figure{margin:22px 0}figure svg{max-width:100%;height:auto;border:1px solid #e3e3e3}
figcaption,.note{color:#555;font-size:13px;max-width:760px;margin:4px 0}
.scene{width:100%;height:min(80vh,760px);border:1px solid #cfd6de;border-radius:8px}
@media print{.scene{display:none}}
.figures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(540px,100%),1fr));gap:0 24px}
nav a{margin-right:14px}details{margin:10px 0}summary{cursor:pointer}
)";

// ------------------------------------------------------------------------------- table of figures

// A readable name and scale for the figures that everybody looks for; the others are listed by
// their place in the document.
struct KnownFigure {
  const char* pointer;
  const char* name;
  const char* format;
  double factor;
};

constexpr KnownFigure kMainFigures[] = {
    {"/evaluation/coverage", "coverage [%]", "%.1f", 100},
    {"/evaluation/path_length_m", "path [m]", "%.2f", 1},
    {"/evaluation/ate/rmse_m", "ATE RMSE [cm]", "%.2f", 100},
    {"/evaluation/ate/median_m", "ATE median [cm]", "%.2f", 100},
    {"/evaluation/ate/max_m", "ATE max [cm]", "%.2f", 100},
    {"/evaluation/ate_keyframes/rmse_m", "ATE RMSE, smoothed keyframes [cm]", "%.2f", 100},
    {"/evaluation/drift_percent", "drift [%]", "%.2f", 1},
    {"/evaluation/scale_error_percent", "scale error [%]", "%+.2f", 1},
    {"/evaluation/time_offset_s", "time offset removed [ms]", "%+.2f", 1000},
    {"/evaluation/mesh/accuracy_mean_m", "mesh accuracy, mean [cm]", "%.2f", 100},
    {"/evaluation/mesh/accuracy_median_m", "mesh accuracy, median [cm]", "%.2f", 100},
    {"/evaluation/mesh/accuracy_p90_m", "mesh accuracy, p90 [cm]", "%.2f", 100},
    {"/evaluation/mesh/precision_5cm", "mesh area within 5 cm [%]", "%.1f", 100},
    {"/evaluation/mesh/within_3m/accuracy_median_m", "mesh within 3 m, median [cm]", "%.2f", 100},
    {"/evaluation/mesh/within_3m/fscore_5cm", "mesh within 3 m, F-score at 5 cm [%]", "%.1f", 100},
    {"/evaluation/mesh/completeness_10cm", "mesh completeness at 10 cm [%]", "%.1f", 100},
    {"/evaluation/mesh/fscore_10cm", "mesh F-score at 10 cm [%]", "%.1f", 100},
    {"/evaluation/mesh/icp/accuracy_mean_m", "mesh accuracy after ICP, mean [cm]", "%.2f", 100},
    {"/evaluation/mesh/plane_areas/rmse_m", "mesh on planes, RMSE [cm]", "%.2f", 100},
    {"/evaluation/map/accuracy_mean_m", "map accuracy, mean [cm]", "%.2f", 100},
    {"/evaluation/map/completeness_10cm", "map completeness at 10 cm [%]", "%.1f", 100},
    {"/evaluation/map/fscore_10cm", "map F-score at 10 cm [%]", "%.1f", 100},
    {"/evaluation/map/doubled_area", "map doubled area [%]", "%.2f", 100},
    {"/evaluation/planes/recall", "planes recall by seen area [%]", "%.1f", 100},
    {"/evaluation/planes/precision", "planes precision [%]", "%.1f", 100},
    {"/evaluation/planes/duplicates", "planes duplicates", "%.0f", 1},
    {"/evaluation/planes/normal_error_deg_median", "planes normal error, median [deg]", "%.2f", 1},
    {"/evaluation/planes/offset_error_m_median", "planes offset error, median [cm]", "%.2f", 100},
    {"/evaluation/consistency/position/nees", "NEES position (1 is right)", "%.2f", 1},
    {"/evaluation/consistency/orientation/nees", "NEES orientation (1 is right)", "%.2f", 1},
    {"/evaluation/consistency/velocity/nees", "NEES velocity (1 is right)", "%.2f", 1},
    {"/evaluation/consistency/gyro_bias/nees", "NEES gyro bias (1 is right)", "%.2f", 1},
    {"/evaluation/consistency/accelerometer_bias/nees",
     "NEES accelerometer bias (1 is right)",
     "%.2f",
     1},
    {"/summary/init_s", "first pose [s]", "%.2f", 1},
    {"/summary/stages/total_without_decode/mean_ms", "CPU per frame, mean [ms]", "%.2f", 1},
    {"/summary/stages/total_without_decode/keyframe_median_ms",
     "CPU per keyframe, median [ms]",
     "%.2f",
     1},
    {"/summary/peak_rss_mb", "memory [MB]", "%.0f", 1},
};

std::string Place(std::size_t section, std::size_t run) {
  return "/sections/" + std::to_string(section) + "/runs/" + std::to_string(run);
}

std::vector<std::string> HeaderOf(const ReportSection& section) {
  std::vector<std::string> header = {"figure"};
  for (const ReportRun& run : section.runs)
    header.push_back(run.name);
  return header;
}

Table MainFigures(const ordered_json& document, const ReportSection& section, std::size_t s) {
  Table table;
  table.title = "The main figures";
  table.header = HeaderOf(section);
  for (const KnownFigure& figure : kMainFigures) {
    std::vector<TableCell> row = {{figure.name, "", "", 1}};
    bool any = false;
    for (std::size_t r = 0; r < section.runs.size(); ++r) {
      row.push_back(
          NumberCell(document, Place(s, r) + figure.pointer, figure.format, figure.factor));
      any = any || !row.back().pointer.empty();
    }
    if (any) table.rows.push_back(std::move(row));
  }
  return table;
}

// Places of all numbers below `node`, in order.
void CollectNumbers(const ordered_json& node,
                    const std::string& place,
                    std::vector<std::string>& places) {
  if (node.is_number()) places.push_back(place);
  if (!node.is_structured()) return;
  for (const auto& [key, value] : node.items()) {
    std::string escaped;
    for (char c : key)
      escaped += c == '~' ? "~0" : (c == '/' ? "~1" : std::string(1, c));
    CollectNumbers(value, place + "/" + escaped, places);
  }
}

Table AllFigures(const ordered_json& document, const ReportSection& section, std::size_t s) {
  Table table;
  table.title = "Every figure";
  table.header = HeaderOf(section);
  std::vector<std::string> order;
  std::set<std::string> known;
  for (std::size_t r = 0; r < section.runs.size(); ++r) {
    std::vector<std::string> places;
    CollectNumbers(document[ordered_json::json_pointer(Place(s, r))], "", places);
    for (const std::string& place : places) {
      if (known.insert(place).second) order.push_back(place);
    }
  }
  for (const std::string& place : order) {
    std::vector<TableCell> row = {{place.substr(1), "", "", 1}};
    for (std::size_t r = 0; r < section.runs.size(); ++r)
      row.push_back(NumberCell(document, Place(s, r) + place, "%.6g"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

// Parameters that are not the same in all runs that say theirs.
Table DifferingParameters(const ReportSection& section) {
  Table table;
  table.title = "Parameters that differ";
  table.header = HeaderOf(section);
  table.header.front() = "parameter";
  std::vector<std::string> order;
  std::map<std::string, std::vector<std::string>> values;
  for (std::size_t r = 0; r < section.runs.size(); ++r) {
    for (const ConfigEntry& entry : section.runs[r].config) {
      auto& row = values[entry.key];
      if (row.empty()) order.push_back(entry.key);
      row.resize(section.runs.size(), "-");
      row[r] = entry.text;
    }
  }
  for (const std::string& key : order) {
    const auto& row = values[key];
    if (std::ranges::adjacent_find(row, std::not_equal_to<>()) == row.end()) continue;
    auto& cells = table.rows.emplace_back();
    cells.push_back({key, "", "", 1});
    for (const std::string& text : row)
      cells.push_back({text, "", "", 1});
  }
  return table;
}

// ------------------------------------------------------------------------------------- the page

std::string FiguresHtml(const std::vector<ReportFigure>& figures) {
  std::string html = "<div class=\"figures\">\n";
  for (const ReportFigure& figure : figures) {
    html += "<figure><h3>" + EscapeHtml(figure.title) + "</h3>\n" + figure.svg + "<figcaption>" +
            EscapeHtml(figure.caption) + "</figcaption></figure>\n";
  }
  return html + "</div>\n";
}

std::string SectionHtml(const ordered_json& document, const Report& report, std::size_t s) {
  const ReportSection& section = report.sections[s];
  std::string html = "<h2 id=\"section" + std::to_string(s) + "\">" + EscapeHtml(section.name) +
                     "</h2>\n<p class=\"note\">Ground truth: " + EscapeHtml(section.truth) + "." +
                     EscapeHtml(section.remark) + "</p>\n";
  html += ToHtml(MainFigures(document, section, s));
  for (const ReportRun& run : section.runs) {
    for (const std::string& warning : run.evaluation.warnings)
      html += "<p class=\"note\">Warning: " + EscapeHtml(warning) + "</p>\n";
  }
  if (!section.scene_page.empty()) {
    html +=
        "<h3>Mesh, planes and trajectory in 3D</h3>\n<iframe class=\"scene\" loading=\"lazy\" "
        "title=\"Mesh, planes and trajectory in 3D\" srcdoc=\"" +
        EscapeHtml(section.scene_page) + "\"></iframe>\n";
  }
  if (!section.images.empty()) {
    html +=
        "<h3>What the left camera saw, with the mesh over it</h3>\n" + FiguresHtml(section.images);
  }
  html += FiguresHtml(MakeFigures(section.runs));
  const Table parameters = DifferingParameters(section);
  if (!parameters.rows.empty()) html += ToHtml(parameters);
  html += "<details><summary>Every figure of evaluation.json and summary.json</summary>\n" +
          ToHtml(AllFigures(document, section, s)) + "</details>\n";
  return html;
}

// "</script>" in a text must not end the element that holds the document.
std::string ForScript(std::string json) {
  for (std::size_t i = 0; (i = json.find("</", i)) != std::string::npos; i += 3)
    json.replace(i, 2, "<\\/");
  return json;
}

// Draws a PNG beside an SVG if rsvg-convert (Debian: librsvg2-bin) is there.
void Rasterize(const fs::path& svg) {
  std::string program = "rsvg-convert", zoom = "--zoom=1.5", out = "--output";
  std::string target = fs::path(svg).replace_extension(".png").string(), source = svg.string();
  char* argv[] = {program.data(), zoom.data(), out.data(), target.data(), source.data(), nullptr};
  pid_t pid = 0;
  if (posix_spawnp(&pid, program.c_str(), nullptr, nullptr, argv, environ) != 0) return;
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
}

void WriteFigure(const fs::path& svg, const ReportFigure& figure) {
  ReplaceTextFile(svg, figure.svg);
  Rasterize(svg);
}

}  // namespace

nlohmann::ordered_json ReportDocument(const Report& report) {
  ordered_json document;
  if (!report.comparison.is_null()) document["comparison"] = report.comparison;
  document["sections"] = ordered_json::array();
  for (const ReportSection& section : report.sections) {
    ordered_json entry = {{"name", section.name}, {"runs", ordered_json::array()}};
    for (const ReportRun& run : section.runs) {
      entry["runs"].push_back(
          {{"name", run.name}, {"evaluation", run.evaluation_json}, {"summary", run.summary}});
    }
    document["sections"].push_back(std::move(entry));
  }
  return document;
}

std::string ReportHtml(const Report& report) {
  const ordered_json document = ReportDocument(report);
  std::string html = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<title>" +
                     EscapeHtml(report.title) +
                     "</title>\n<meta name=\"viewport\" content=\"width=device-width\">\n<style>" +
                     kStyle + "</style></head>\n<body>\n<h1>" + EscapeHtml(report.title) +
                     "</h1>\n";
  if (report.sections.size() > 1) {
    html += "<nav>";
    for (std::size_t s = 0; s < report.sections.size(); ++s) {
      html += "<a href=\"#section" + std::to_string(s) + "\">" +
              EscapeHtml(report.sections[s].name) + "</a>";
    }
    html += "</nav>\n";
  }
  if (!report.comparison.is_null()) {
    for (const Table& table : ComparisonTables(report.comparison))
      html += ToHtml(table, "/comparison");
    const ReportFigure figure = MakeComparisonFigure(report.comparison);
    if (!figure.svg.empty()) html += FiguresHtml({figure});
  }
  for (std::size_t s = 0; s < report.sections.size(); ++s)
    html += SectionHtml(document, report, s);
  html += "<script type=\"application/json\" id=\"report-data\">" + ForScript(JsonText(document)) +
          "</script>\n</body></html>\n";
  return html;
}

void WriteReport(const std::filesystem::path& folder, const Report& report) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw ConfigError("--report " + folder.string() + ": cannot be created: " + error.message());
  }
  ReplaceTextFile(folder / "report.json", JsonText(ReportDocument(report), 1) + "\n");
  if (!report.comparison.is_null()) {
    const ReportFigure figure = MakeComparisonFigure(report.comparison);
    if (!figure.svg.empty()) WriteFigure(folder / (figure.name + ".svg"), figure);
  }
  for (const ReportSection& section : report.sections) {
    const std::string prefix = report.sections.size() > 1 ? section.name + "_" : "";
    for (const ReportFigure& figure : MakeFigures(section.runs)) {
      WriteFigure(folder / (prefix + figure.name + ".svg"), figure);
    }
  }
  ReplaceTextFile(folder / "report.html", ReportHtml(report));
}

}  // namespace facet
