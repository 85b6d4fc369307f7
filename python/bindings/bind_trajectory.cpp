// SPDX-License-Identifier: BSD-2-Clause
#include "arrays.h"
#include "bindings.h"
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>

#include "facet/eval/evaluation_json.h"
#include "facet/eval/run_evaluation.h"
#include "facet/io/errors.h"
#include "facet/io/trajectory_file.h"

namespace facet::python {
namespace {

py::tuple ToArrays(const std::vector<StampedPose>& poses) {
  const auto num = static_cast<py::ssize_t>(poses.size());
  py::array_t<std::int64_t> t_ns(num);
  Doubles p({num, py::ssize_t{3}}), q({num, py::ssize_t{4}});
  for (py::ssize_t i = 0; i < num; ++i) {
    const auto& [t, T_WB] = poses[static_cast<std::size_t>(i)];
    t_ns.mutable_at(i) = t.ns;
    std::copy_n(T_WB.p.data(), 3, p.mutable_data(i, 0));
    const double wxyz[] = {T_WB.q.w(), T_WB.q.x(), T_WB.q.y(), T_WB.q.z()};
    std::copy_n(wxyz, 4, q.mutable_data(i, 0));
  }
  return py::make_tuple(t_ns, p, q);
}

/// Throws ValueError for stamps that do not rise and for quaternions that are not of unit length.
std::vector<StampedPose> ToPoses(const py::object& t_ns, const py::object& p, const py::object& q) {
  const auto stamps = Stamps(t_ns, "t_ns");
  const py::ssize_t num = stamps.size();
  const Doubles positions = Rows(p, num, 3, "p"), quaternions = Rows(q, num, 4, "q");
  std::vector<StampedPose> poses;
  poses.reserve(static_cast<std::size_t>(num));
  for (py::ssize_t i = 0; i < num; ++i) {
    const double *x = positions.data() + 3 * i, *w = quaternions.data() + 4 * i;
    const Quaterniond rotation(w[0], w[1], w[2], w[3]);
    const Vector3d position(x[0], x[1], x[2]);
    if (!(std::abs(rotation.norm() - 1) < 0.01) || !position.allFinite())
      throw py::value_error("pose " + std::to_string(i) +
                            ": a finite p and a q (w x y z) of unit length are expected");
    poses.push_back({{stamps.data()[i]}, SE3(rotation, position)});
    if (i > 0 && !(poses[poses.size() - 2].t < poses.back().t))
      throw py::value_error("t_ns: the stamps must rise; that of pose " + std::to_string(i) +
                            " does not");
  }
  return poses;
}

AlignmentKind ToAlignment(const std::string& name) {
  const auto kind = AlignmentKindFromText(name);
  if (!kind) throw ConfigError("alignment '" + name + "': se3, yaw or sim3 is expected");
  return *kind;
}

/// The content of evaluation.json and the warnings.
py::tuple Report(const RunEvaluation& evaluation) {
  return py::make_tuple(ToJson(evaluation).dump(), evaluation.warnings);
}

py::tuple EvaluateResult(const std::string& result,
                         const std::string& truth,
                         const std::string& alignment,
                         const std::vector<double>& rpe_lengths_m,
                         bool align_time,
                         const std::vector<std::string>& parts,
                         bool parts_must_exist,
                         bool write) {
  const auto wants = [&](const char* part) {
    return std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  EvaluationOptions options;
  options.trajectory = {ToAlignment(alignment), rpe_lengths_m};
  options.align_time = align_time;
  options.judge_mesh = wants("mesh");
  options.judge_planes = wants("planes");
  options.judge_consistency = wants("consistency");
  options.parts_must_exist = parts_must_exist;
  RunEvaluation evaluation;
  {
    const py::gil_scoped_release release;
    evaluation = EvaluateRun(result, LoadGroundTruth(truth), options);
    if (write) WriteEvaluation(evaluation);
  }
  return Report(evaluation);
}

py::tuple EvaluatePoses(const py::tuple& estimate,
                        const py::tuple& truth,
                        const std::string& alignment,
                        const std::vector<double>& rpe_lengths_m) {
  const std::vector<StampedPose> estimated = ToPoses(estimate[0], estimate[1], estimate[2]);
  const std::vector<StampedPose> true_poses = ToPoses(truth[0], truth[1], truth[2]);
  RunEvaluation evaluation;
  evaluation.alignment = ToAlignment(alignment);
  const std::string problem = WhatIsWrong(estimated, true_poses);
  if (!problem.empty()) throw InputError(problem);
  evaluation.causal =
      EvaluateTrajectory(estimated, true_poses, {evaluation.alignment, rpe_lengths_m});
  return Report(evaluation);
}

}  // namespace

void BindTrajectory(py::module_& module) {
  module.def(
      "read_trajectory",
      [](const std::string& file) { return ToArrays(ReadTrajectory(file).poses); },
      py::arg("file"));
  module.def(
      "write_tum",
      [](const std::string& file,
         const py::object& t_ns,
         const py::object& p,
         const py::object& q) { WriteTum(file, ToPoses(t_ns, p, q)); },
      py::arg("file"),
      py::arg("t_ns"),
      py::arg("p"),
      py::arg("q"));
  module.def(
      "read_truth",
      [](const std::string& truth) { return ToArrays(LoadGroundTruth(truth).poses); },
      py::arg("truth"));
  module.def("evaluate_result",
             &EvaluateResult,
             py::arg("result"),
             py::arg("truth"),
             py::arg("alignment"),
             py::arg("rpe_lengths_m"),
             py::arg("align_time"),
             py::arg("parts"),
             py::arg("parts_must_exist"),
             py::arg("write"));
  module.def("evaluate_poses",
             &EvaluatePoses,
             py::arg("estimate"),
             py::arg("truth"),
             py::arg("alignment"),
             py::arg("rpe_lengths_m"));
}

}  // namespace facet::python
