// SPDX-License-Identifier: BSD-2-Clause
// Runs this program many times, several runs at once, and remembers what is done already.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace facet {

/// One run of `facet run` and the `facet evaluate` behind it.
struct RunCell {
  std::filesystem::path sequence;
  std::string sequence_name, combination;
  double start_s = 0;
  std::vector<std::string> arguments;  ///< of `facet run`, besides sequence, start and folder
  std::filesystem::path folder;        ///< where the result goes; <folder>.cell.json remembers it

  int exit_code = -1;
  std::string message;      ///< last line of the run on stderr, or what evaluating it complained of
  bool has_result = false;  ///< the folder holds a trajectory and its evaluation
};

/// Runs all cells in order, `jobs` at a time, each pinned to a core of its own. A cell is skipped
/// when its folder holds the result of the same arguments and the same build of this program, so
/// an interrupted study goes on where it stopped. One line per finished cell on stderr unless
/// `is_quiet`. A run that fails is the cell's business, not an error.
void ExecuteCells(std::vector<RunCell>& cells, int jobs, bool is_quiet);

/// The same for one cell alone, on the cores that this process may use; nothing is printed.
void ExecuteCell(RunCell& cell);

/// Whether the cell's folder holds the result of the same arguments and build; then the cell says
/// how the run ended.
bool LoadIfDone(RunCell& cell);

/// Why a cell that was executed has no result, from what its run printed last.
std::string WhyNoResult(const RunCell& cell);

}  // namespace facet
