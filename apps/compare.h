// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

namespace facet {

/// What `facet compare` is told on the command line.
struct CompareArguments {
  std::vector<std::string> sequences, configs, overrides;
  std::vector<std::string> pipelines = {"S", "SP", "SPR"};
  std::vector<std::string> run_options;
  std::string out, report;
  int starts = 9, jobs = 1;
  double duration_s = 0;
  bool is_quiet = false;
  bool uses_slurm = false;                 ///< its cluster does the runs (slurm_runs.h)
  std::vector<std::string> slurm_options;  ///< of sbatch
  int cell = -1;  ///< this run alone, without tables: what a job of Slurm does; -1: all
};

/// `facet compare`. Throws InputError, ConfigError, OutputError or RunEndedError.
void CompareCommand(const CompareArguments& arguments);

}  // namespace facet
