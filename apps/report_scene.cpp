// SPDX-License-Identifier: BSD-2-Clause
#include "report_scene.h"

#include <cstdio>
#include <filesystem>
#include <utility>
#include <vector>

#include "facet/io/errors.h"
#include "facet/viewer/result_view.h"
#include "facet/viewer/standalone_page.h"

namespace facet {

void AddScene(GroundTruth truth, ReportSection& section) {
  std::vector<std::filesystem::path> results;
  for (const ReportRun& run : section.runs) {
    const std::filesystem::path folder = run.evaluation.result;
    if (std::filesystem::exists(folder / "map.ply")) results.push_back(folder);
  }
  if (results.empty()) return;
  if (results.size() > 2) results = {results.front(), results.back()};
  try {
    std::string page = StandalonePage(ResultView(results, &truth));
    constexpr std::size_t kLargest = 64 << 20;
    if (page.size() <= kLargest) section.scene_page = std::move(page);
  } catch (const InputError& error) {
    // The figures are still worth a report.
    std::fprintf(stderr, "facet: warning: the report has no 3D view: %s\n", error.what());
  }
}

}  // namespace facet
