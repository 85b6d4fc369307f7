// SPDX-License-Identifier: BSD-2-Clause
#include "slurm_runs.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "run.h"
#include <sys/wait.h>

#include "facet/io/errors.h"
#include "facet/io/text_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

// Slurm's usual limit (MaxArraySize) is 1001 tasks per array, whose numbers begin with 0.
constexpr std::size_t kTasksPerArray = 1000;

// For a shell.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text)
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

// This process's own command, without what asks for Slurm.
std::string OwnCommand() {
  std::ifstream stream("/proc/self/cmdline", std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(stream), {}};
  std::string command = Quoted(fs::read_symlink("/proc/self/exe").string());
  bool is_value = false;  // of the option before
  for (std::size_t begin = all.find('\0') + 1; begin < all.size();) {
    const std::size_t end = all.find('\0', begin);
    const std::string word = all.substr(begin, end - begin);
    begin = end + 1;
    const bool is_left_out = is_value || word == "--slurm" || word.starts_with("--slurm-option");
    is_value = word == "--slurm-option";
    if (!is_left_out) command += " " + Quoted(word);
  }
  return command;
}

// The tasks of an array are numbered from 0; the list says which cells they are.
std::string Script(const std::vector<std::size_t>& cells) {
  std::string script = "#!/bin/sh\n# A task of a job array: one run of the study.\nset -- ";
  for (const std::size_t cell : cells)
    script += std::to_string(cell) + " ";
  return script + "\nshift \"$SLURM_ARRAY_TASK_ID\"\nexec " + OwnCommand() + " --cell \"$1\"\n";
}

int Shell(const std::string& command) {
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe)
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Waits for the end of all tasks. A task that fails is its cell's business.
void Submit(const std::vector<std::size_t>& cells, const SlurmStudy& study) {
  const fs::path folder = fs::absolute(study.out) / "slurm";
  const fs::path script = folder / "run_cell.sh", log = folder / "sbatch.log";
  ReplaceTextFile(script, Script(cells));
  std::string command = "sbatch --parsable --wait --job-name=facet-compare --ntasks=1 --array=0-" +
                        std::to_string(cells.size() - 1) + "%" + std::to_string(study.jobs) +
                        " --output=" + Quoted((folder / "task_%a.log").string());
  for (const std::string& option : study.options)
    command += " " + Quoted(option);
  const int code =
      Shell(command + " " + Quoted(script.string()) + " >" + Quoted(log.string()) + " 2>&1");
  std::string said;
  std::ifstream stream(log);
  std::getline(stream, said);
  // It begins with the number of the job once that was accepted.
  if (!said.empty() && std::isdigit(static_cast<unsigned char>(said.front())) != 0) return;
  constexpr int kNotFound = 127, kFailed = 1;
  throw RunEndedError(kFailed,
                      code == kNotFound ? "--slurm: there is no sbatch: is this a machine of a "
                                          "Slurm cluster? --jobs N runs here"
                                        : "--slurm: sbatch refused the job: " + said);
}

}  // namespace

void ExecuteOnSlurm(std::vector<RunCell>& cells, const SlurmStudy& study) {
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!LoadIfDone(cells[i])) missing.push_back(i);
  }
  fs::create_directories(study.out / "slurm");
  for (std::size_t first = 0; first < missing.size(); first += kTasksPerArray) {
    const std::size_t last = std::min(first + kTasksPerArray, missing.size());
    const std::vector<std::size_t> part(missing.begin() + static_cast<std::ptrdiff_t>(first),
                                        missing.begin() + static_cast<std::ptrdiff_t>(last));
    if (!study.is_quiet) {
      std::fprintf(stderr,
                   "%zu of %zu runs go to Slurm, %zu were there\n",
                   part.size(),
                   cells.size(),
                   cells.size() - missing.size());
    }
    Submit(part, study);
  }
  for (const std::size_t i : missing) {
    if (LoadIfDone(cells[i])) continue;
    cells[i].message = WhyNoResult(cells[i]);
    if (cells[i].message.empty()) {
      cells[i].message = "the job of Slurm left no result; see " + (study.out / "slurm").string();
    }
  }
}

}  // namespace facet
