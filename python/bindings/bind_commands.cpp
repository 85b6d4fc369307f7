// SPDX-License-Identifier: BSD-2-Clause
// Commands of the program `facet` within the interpreter's process.
#include <array>
#include <atomic>
#include <csignal>
#include <exception>

#include "bindings.h"
#include "interrupts.h"
#include "load_options.h"
#include "run.h"
#include <opencv2/core.hpp>
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include "facet/io/errors.h"
#include "facet/io/planes_file.h"

#ifdef FACET_HAS_SIMULATOR
#include "simulate.h"
#endif

namespace py = pybind11;

namespace facet::python {
namespace {

/// What a command changes for the whole process is as before afterwards: it catches Ctrl-C to end
/// in good order, and computes on one thread. There is one of them at a time.
class ProcessState {
 public:
  ProcessState() {
    if (is_in_use.exchange(true))
      throw ConfigError("one command at a time: another thread runs one (use processes)");
    for (std::size_t i = 0; i < kSignals.size(); ++i)
      sigaction(kSignals[i], nullptr, &actions_[i]);
    cv::setNumThreads(1);
  }
  ProcessState(const ProcessState&) = delete;
  ProcessState& operator=(const ProcessState&) = delete;
  ~ProcessState() {
    cv::setNumThreads(num_threads_);
    for (std::size_t i = 0; i < kSignals.size(); ++i)
      sigaction(kSignals[i], &actions_[i], nullptr);
    is_in_use = false;
  }

 private:
  static inline std::atomic<bool> is_in_use = false;
  static constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, 3> actions_{};
  int num_threads_ = cv::getNumThreads();
};

/// Calls the progress function with the interpreter's lock. What it raises stops the command, which
/// rethrows it at its end.
class ProgressCall {
 public:
  explicit ProgressCall(const py::object& function) : function_(function) {}
  bool is_wanted() const { return !function_.is_none(); }
  void operator()(int done, int total) {
    if (problem_) return;
    const py::gil_scoped_acquire acquire;
    try {
      function_(done, total);
    } catch (...) {
      problem_ = std::current_exception();
      Interrupt();  // the command ends as it does for Ctrl-C
    }
  }
  void RethrowProblem() const {
    if (problem_) std::rethrow_exception(problem_);
  }

 private:
  py::object function_;
  std::exception_ptr problem_;
};

/// Notes and warnings are appended to `messages`, also where it throws.
void Run(const std::string& sequence,
         const std::string& out,
         const std::string& config,
         const std::vector<std::string>& overrides,
         const std::string& calibration,
         const std::string& imu_calibration,
         const std::vector<std::string>& topics,
         double start_s,
         double duration_s,
         double imu_history_s,
         int threads,
         int mesh_every,
         const std::string& mesh_format,
         const py::object& progress,
         py::list messages) {
  ProgressCall progress_call(progress);
  std::vector<std::string> texts;
  RunArguments a;
  a.sequence = sequence;
  a.out = out;
  a.config = config;
  a.overrides = overrides;
  a.calibration = calibration;
  a.imu_calibration = imu_calibration;
  a.topics = topics;
  a.range.start_s = start_s;
  a.range.duration_s = duration_s;
  a.range.imu_history_s = imu_history_s;
  a.threads = threads;
  a.mesh_every = mesh_every;
  a.mesh_format = mesh_format;
  a.quiet = true;
  a.on_message = [&](const std::string& text) { texts.push_back(text); };
  if (progress_call.is_wanted()) a.on_frame = std::ref(progress_call);
  std::exception_ptr problem;
  {
    const py::gil_scoped_release release;
    const ProcessState state;
    try {
      RunCommand(a);
    } catch (...) {  // thrown again when Python's lock is held
      problem = std::current_exception();
    }
  }
  for (const std::string& text : texts)
    messages.append(text);
  progress_call.RethrowProblem();
  if (problem) std::rethrow_exception(problem);
}

#ifdef FACET_HAS_SIMULATOR

void Simulate(const std::string& out,
              const std::string& scene,
              const std::string& trajectory,
              const std::string& imu,
              const std::string& calibration,
              const std::string& textures,
              std::uint64_t seed,
              double start_s,
              double duration_s,
              int threads,
              bool clean_images,
              bool clean_imu,
              std::optional<std::uint64_t> draw_calibration,
              std::optional<std::uint64_t> lens_misfit,
              const std::vector<std::string>& overrides,
              const std::string& command_line) {
  SimulateArguments a;
  a.out = out;
  a.request.scene = scene;
  a.request.trajectory = trajectory;
  a.request.imu = imu;
  a.request.calibration = calibration;
  a.request.textures = textures;
  a.request.seed = seed;
  a.request.start_s = start_s;
  a.request.duration_s = duration_s;
  a.request.num_threads = threads;
  a.request.drawn_calibration = draw_calibration;
  a.request.lens_misfit = lens_misfit;
  a.clean_images = clean_images;
  a.clean_imu = clean_imu;
  a.overrides = overrides;
  a.command_line = command_line;
  a.quiet = true;
  const py::gil_scoped_release release;
  const ProcessState state;
  SimulateCommand(a);
}

void BindSimulate(py::module_& module) {
  module.def("simulate",
             &Simulate,
             py::arg("out"),
             py::arg("scene"),
             py::arg("trajectory"),
             py::arg("imu"),
             py::arg("calibration"),
             py::arg("textures"),
             py::arg("seed"),
             py::arg("start_s"),
             py::arg("duration_s"),
             py::arg("threads"),
             py::arg("clean_images"),
             py::arg("clean_imu"),
             py::arg("draw_calibration"),
             py::arg("lens_misfit"),
             py::arg("overrides"),
             py::arg("command_line"));
  module.attr("has_simulator") = true;
}

#else

void BindSimulate(py::module_& module) {
  module.attr("has_simulator") = false;
}

#endif

std::string ConfigText(const std::string& config,
                       const std::vector<std::string>& overrides,
                       bool all) {
  return FormatOptions(LoadOptions(config, overrides).options,
                       all ? Audience::kExperts : Audience::kUsers);
}

}  // namespace

void BindCommands(py::module_& module) {
  module.def("run",
             &Run,
             py::arg("sequence"),
             py::arg("out"),
             py::arg("config"),
             py::arg("overrides"),
             py::arg("calibration"),
             py::arg("imu_calibration"),
             py::arg("topics"),
             py::arg("start_s"),
             py::arg("duration_s"),
             py::arg("imu_history_s"),
             py::arg("threads"),
             py::arg("mesh_every"),
             py::arg("mesh_format"),
             py::arg("progress"),
             py::arg("messages"));
  module.def("config_text", &ConfigText, py::arg("config"), py::arg("overrides"), py::arg("all"));
  BindSimulate(module);
}

}  // namespace facet::python
