// SPDX-License-Identifier: BSD-2-Clause
// The ladder's figures for people and for scripts.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
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

/// Single outcomes in a file, one line per realisation and rung, in SI units, so that an
/// interrupted study goes on where it stopped. Not thread-safe.
class OutcomeFile {
 public:
  /// Reads what is there. `settings` is one line with all that outcomes depend on besides flight,
  /// seed and rung. Throws std::runtime_error if the file is of other settings or cannot be
  /// written.
  OutcomeFile(const std::string& path, const std::string& settings);

  /// What is known of a run; null if nothing is.
  const Outcome* Find(const std::string& flight, std::uint64_t seed, const std::string& rung) const;

  void Add(const std::string& flight,
           std::uint64_t seed,
           const std::string& rung,
           const Outcome& outcome);

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Closer> file_;
  std::map<std::string, Outcome> outcomes_;  // by the first columns of the line
};

}  // namespace facet
