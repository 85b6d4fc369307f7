// SPDX-License-Identifier: BSD-2-Clause
// Relative errors (RPE) of many runs: per length of path the median over the starts, and how much
// of it planes save, beside what the paper's Fig. 3 says.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "facet/report/table.h"

namespace facet {

/// Returns for each length in the "rpe" of several evaluation.json the medians over the runs of the
/// median errors, and how many runs have the length. Empty if none has any.
nlohmann::ordered_json MedianRelativeErrors(std::span<const nlohmann::ordered_json> evaluations);

/// For each configuration with the pipelines SPR and SP (and SPR and S): 1 - ratio of the errors,
/// mean and largest over the lengths that both have. `combinations` are those of comparison.json;
/// they are called like their pipeline, or that, a hyphen and the configuration.
nlohmann::ordered_json RelativeErrorGains(const nlohmann::ordered_json& combinations);

/// ATE and RPE in one table, and the gains with the paper's beside; tables without rows are left
/// out.
std::vector<Table> RelativeErrorTables(const nlohmann::ordered_json& comparison);

}  // namespace facet
