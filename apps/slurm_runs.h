// SPDX-License-Identifier: BSD-2-Clause
// The runs of a study on the machines of a Slurm cluster: more recordings than one machine can do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare_runs.h"

namespace facet {

struct SlurmStudy {
  std::filesystem::path out;         ///< folder of the study, which all machines must see
  int jobs = 1;                      ///< at the same time
  std::vector<std::string> options;  ///< more arguments, as of `sbatch --partition=short`
  bool is_quiet = false;
};

/// Does what ExecuteCells does by job arrays: each task is this program with this process's own
/// arguments and the number of a cell. Only cells without a result are submitted, so a study that
/// was interrupted goes on; returns when the last one has ended. The script and what the tasks
/// print are in <out>/slurm. Throws RunEndedError where sbatch is missing or refuses the job.
void ExecuteOnSlurm(std::vector<RunCell>& cells, const SlurmStudy& study);

}  // namespace facet
