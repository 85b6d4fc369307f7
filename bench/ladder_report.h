// SPDX-License-Identifier: BSD-2-Clause
// The ladder's figures for people and for scripts.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "ladder_rungs.h"

namespace facet {

/// One realisation of a flight through all rungs.
struct Realisation {
  std::uint64_t seed = 0;
  double simulation_s = 0;        ///< CPU
  std::vector<Outcome> outcomes;  ///< by rung
};

/// Ratios of the error with their 95 % intervals, normalised errors, what the search did, and the
/// CPU time of a run, rung by rung. At least one realisation.
void PrintLadder(const std::vector<Rung>& rungs, const std::vector<Realisation>& realisations);

/// One line per realisation and rung, in SI units.
void WriteCsvHeader(std::FILE* file);
void WriteCsv(std::FILE* file,
              const std::string& flight,
              const std::vector<Rung>& rungs,
              const Realisation& realisation);

}  // namespace facet
