// SPDX-License-Identifier: BSD-2-Clause
#include "compare_runs.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <sstream>
#include <string_view>
#include <thread>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <pthread.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "facet/io/json_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Tells one build of the program from another.
struct Program {
  std::string path, stamp;
};

Program ThisProgram() {
  Program program;
  program.path = fs::read_symlink("/proc/self/exe").string();
  const auto changed = fs::last_write_time(program.path).time_since_epoch().count();
  program.stamp = std::to_string(fs::file_size(program.path)) + "-" + std::to_string(changed);
  return program;
}

std::vector<int> AllowedCores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  pthread_getaffinity_np(pthread_self(), sizeof(set), &set);
  std::vector<int> cores;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(core, &set)) cores.push_back(core);
  }
  return cores;
}

// Children inherit the core of the thread that starts them.
void PinThisThread(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(core, &set);
  pthread_setaffinity_np(pthread_self(), sizeof(set), &set);
}

// The last line without what every error of this program begins with.
std::string Reason(const fs::path& file) {
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line)) {
    if (!line.empty()) last = line;
  }
  constexpr std::string_view kPrefix = "facet: error: ";
  if (last.starts_with(kPrefix)) last.erase(0, kPrefix.size());
  return last;
}

// Exit code of the program; its output goes to `log`. -1: it could not be started.
int Call(const Program& program, std::vector<std::string> arguments, const fs::path& log) {
  arguments.insert(arguments.begin(), program.path);
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments)
    argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  constexpr int kOut = 1, kErr = 2;
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, kOut, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, kErr, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  pid_t pid = 0;
  const int failed =
      posix_spawn(&pid, program.path.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return -1;
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string StartText(double start_s) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", start_s);
  return text;
}

fs::path Beside(const fs::path& folder, const char* suffix) {
  return folder.string() + suffix;
}

ordered_json KeyOf(const RunCell& cell, const Program& program) {
  ordered_json key = {{"program", program.stamp},
                      {"sequence", fs::absolute(cell.sequence).lexically_normal().string()},
                      {"start_s", cell.start_s},
                      {"arguments", cell.arguments}};
  // A configuration file counts by its content.
  for (std::size_t i = 0; i + 1 < cell.arguments.size(); ++i) {
    if (cell.arguments[i] != "--config") continue;
    std::ifstream stream(cell.arguments[i + 1]);
    std::ostringstream content;
    content << stream.rdbuf();
    key["config"] = content.str();
  }
  return key;
}

bool IsDone(RunCell& cell, const ordered_json& key) {
  const ordered_json old = ReadJsonFile(Beside(cell.folder, ".cell.json"));
  if (!old.is_object() || !old.contains("key") || old["key"] != key) return false;
  if (!fs::exists(cell.folder / "evaluation.json")) return false;
  cell.exit_code = old.value("exit_code", -1);
  cell.message = old.value("message", "");
  cell.has_result = true;
  return true;
}

// A mesh that cannot be judged (an empty one, for example) does not take the trajectory with it.
void Evaluate(RunCell& cell, const Program& program, const fs::path& log) {
  std::vector<std::string> arguments = {
      "evaluate", cell.folder.string(), "--truth", cell.sequence.string()};
  cell.has_result = Call(program, arguments, log) == 0;
  if (cell.has_result) return;
  cell.message = Reason(log);
  arguments.insert(arguments.end(), {"--parts", "trajectory"});
  cell.has_result = Call(program, arguments, log) == 0;
}

void Execute(RunCell& cell, const Program& program, const ordered_json& key) {
  std::error_code ignored;
  // Only a result is ever deleted; anything else makes `facet run` refuse the folder.
  if (fs::exists(cell.folder / "summary.json")) fs::remove_all(cell.folder, ignored);
  fs::remove(Beside(cell.folder, ".cell.json"), ignored);
  fs::create_directories(cell.folder.parent_path(), ignored);
  const fs::path log = Beside(cell.folder, ".log");
  std::vector<std::string> arguments = {"run",
                                        cell.sequence.string(),
                                        "--out",
                                        cell.folder.string(),
                                        "--start",
                                        StartText(cell.start_s),
                                        "--quiet"};
  arguments.insert(arguments.end(), cell.arguments.begin(), cell.arguments.end());
  cell.exit_code = Call(program, arguments, log);
  if (cell.exit_code != 0) cell.message = Reason(log);
  constexpr int kUsage = 2;
  if (cell.exit_code == kUsage || !fs::exists(cell.folder / "trajectory.tum")) return;
  Evaluate(cell, program, log);
  if (!cell.has_result) return;
  std::ofstream(Beside(cell.folder, ".cell.json"))
      << JsonText({{"key", key}, {"exit_code", cell.exit_code}, {"message", cell.message}}, 1)
      << '\n';
}

// One line per finished cell.
class Progress {
 public:
  Progress(std::size_t total, bool is_quiet) : total_(total), is_quiet_(is_quiet) {}

  void Report(const RunCell& cell, bool was_there) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++done_;
    if (!was_there) ++executed_;
    if (is_quiet_) return;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
    std::fprintf(stderr,
                 "[%zu/%zu] %s %s start %g: %s",
                 done_,
                 total_,
                 cell.sequence_name.c_str(),
                 cell.combination.c_str(),
                 cell.start_s,
                 was_there ? "was there" : (cell.has_result ? "done" : cell.message.c_str()));
    if (!was_there && executed_ > 0 && done_ < total_) {
      const double left =
          elapsed.count() / static_cast<double>(executed_) * static_cast<double>(total_ - done_);
      std::fprintf(stderr, " (at most %.0f s left)", left);
    }
    std::fputc('\n', stderr);
  }

 private:
  std::mutex mutex_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::size_t total_, done_ = 0, executed_ = 0;
  bool is_quiet_;
};

}  // namespace

void ExecuteCells(std::vector<RunCell>& cells, int jobs, bool is_quiet) {
  const Program program = ThisProgram();
  const std::vector<int> cores = AllowedCores();
  Progress progress(cells.size(), is_quiet);
  std::atomic<std::size_t> next{0};
  const auto work = [&](int core) {
    PinThisThread(core);
    for (std::size_t i = next++; i < cells.size(); i = next++) {
      const ordered_json key = KeyOf(cells[i], program);
      const bool was_there = IsDone(cells[i], key);
      if (!was_there) Execute(cells[i], program, key);
      progress.Report(cells[i], was_there);
    }
  };
  std::vector<std::thread> workers;
  workers.reserve(static_cast<std::size_t>(jobs));
  for (int j = 0; j < jobs; ++j)
    workers.emplace_back(work, cores[static_cast<std::size_t>(j) % cores.size()]);
  for (std::thread& worker : workers)
    worker.join();
}

void ExecuteCell(RunCell& cell) {
  if (LoadIfDone(cell)) return;
  const Program program = ThisProgram();
  Execute(cell, program, KeyOf(cell, program));
}

bool LoadIfDone(RunCell& cell) {
  return IsDone(cell, KeyOf(cell, ThisProgram()));
}

std::string WhyNoResult(const RunCell& cell) {
  return Reason(Beside(cell.folder, ".log"));
}

}  // namespace facet
