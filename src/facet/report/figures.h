// SPDX-License-Identifier: BSD-2-Clause
// The figures of a report: those of the paper (3, 4 and 5) and the ones that explain them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "facet/report/report_run.h"

namespace facet {

struct ReportFigure {
  std::string name;  ///< stem of a file: "trajectory"
  std::string title;
  std::string caption;
  std::string svg;
};

/// All figures that the runs have data for, over the same recording and truth.
std::vector<ReportFigure> MakeFigures(std::span<const ReportRun> runs);

/// The ATE of every run of comparison.json; an empty svg when no run has one.
ReportFigure MakeComparisonFigure(const nlohmann::ordered_json& comparison);

}  // namespace facet
