// SPDX-License-Identifier: BSD-2-Clause
#include "ladder_rungs.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "bench/consistency_study.h"

#include "facet/base/stage_timer.h"
#include "facet/eval/trajectory_error.h"

namespace facet {

namespace {

using MakePolicy = std::function<PlanePolicy(const SimulatedRun&, SearchQuality&)>;

MakePolicy Oracle(double max_age_s) {
  return [max_age_s](const SimulatedRun& run, SearchQuality& /*quality*/) -> PlanePolicy {
    OraclePlaneOptions options;
    options.max_age_s = max_age_s;
    return OraclePlanes(run, options);
  };
}

MakePolicy Search(const SearchOptions& options,
                  Measurements measurements = Measurements::kDetected) {
  return [options, measurements](const SimulatedRun& run, SearchQuality& quality) -> PlanePolicy {
    const auto policy =
        std::make_shared<OwnSearch>(run, options.mesh, options.regularities, measurements, quality);
    return [policy](const FrameObservations& observations, const MapSnapshot& snapshot) {
      return (*policy)(observations, snapshot);
    };
  };
}

MakePolicy Spoiled(const MakePolicy& make) {
  return [make](const SimulatedRun& run, SearchQuality& quality) -> PlanePolicy {
    constexpr double kFrom_s = 15;
    return SpoiledPlanes(make(run, quality), kFrom_s);
  };
}

MakePolicy WronglyReassociated(const MakePolicy& make) {
  return [make](const SimulatedRun& run, SearchQuality& quality) -> PlanePolicy {
    return WrongReassociation(make(run, quality), quality);
  };
}

}  // namespace

std::vector<Rung> MakeRungs(const SearchOptions& search) {
  SearchOptions unrelated = search, short_lived = search, handed_over = search;
  unrelated.regularities.relations.enabled = false;
  short_lived.regularities.tracking.max_age_s = 6;
  handed_over.regularities.tracking.min_detections = 1;  // what is true needs no confirmation
  const MakePolicy placebo = [](const SimulatedRun& run, SearchQuality& /*quality*/) {
    return PlanePolicy(PlaceboPlanes(run));
  };
  return {
      {"S", "S", nullptr, ""},
      {"oracle", "true planes, kept", Oracle(0), ""},
      {"oracle-6s", "true planes, 6 s", Oracle(6), ""},
      {"own-association", "true planes, own members", Search(handed_over, Measurements::kTrue), ""},
      {"SPR", "SPR", Search(search), "oracle"},
      {"no-relations", "SPR, no relations", Search(unrelated), "SPR"},
      {"SPR-6s", "SPR, 6 s", Search(short_lived), "SPR"},
      {"spoiled", "SPR, 20 % wrong for 1 s", Spoiled(Search(search)), "SPR"},
      {"wrong-return", "SPR, a wrong return", WronglyReassociated(Search(search)), "SPR"},
      {"placebo", "placebo, shuffled", placebo, ""}};
}

std::vector<Rung> SelectRungs(std::vector<Rung> rungs, const std::vector<std::string>& keys) {
  std::string known;
  for (const Rung& rung : rungs)
    known += (known.empty() ? "" : ", ") + rung.key;
  for (const std::string& key : keys) {
    if (std::none_of(rungs.begin(), rungs.end(), [&](const Rung& r) { return r.key == key; }))
      throw std::runtime_error("no rung \"" + key + "\"; there are " + known);
  }
  if (keys.empty()) return rungs;
  rungs.erase(std::remove_if(rungs.begin() + 1,
                             rungs.end(),
                             [&](const Rung& rung) {
                               return std::find(keys.begin(), keys.end(), rung.key) == keys.end();
                             }),
              rungs.end());
  return rungs;
}

Outcome RunRung(const SimulatedRun& run, const ConsistencyOptions& options, const Rung& rung) {
  Outcome out;
  const double begin_ms = ThreadCpuMs();
  const PlanePolicy planes = rung.make ? rung.make(run, out.quality) : nullptr;
  const ConsistencyRun result = RunConsistency(run, options, false, planes);
  const KeyframeTrajectories& keyframes = result.keyframes;
  out.ate_m = EvaluateTrajectory(keyframes.causal, keyframes.truth).ate_m.rmse;
  out.num_resets = result.num_resets;
  for (const FrameError& frame : result.frames) {
    out.pose_nees += ComputeNeesRatios(frame)[static_cast<std::size_t>(StatePart::kPose)];
    const Vector3d axis_B = frame.R_WB.transpose() * Vector3d::UnitZ();
    const double yaw = axis_B.dot(frame.error.head<3>());
    out.yaw_nees += yaw * yaw / axis_B.dot(frame.covariance.topLeftCorner<3, 3>() * axis_B);
  }
  out.pose_nees /= static_cast<double>(result.frames.size());
  out.yaw_nees /= static_cast<double>(result.frames.size());
  out.cpu_s = (ThreadCpuMs() - begin_ms) / 1000;
  return out;
}

}  // namespace facet
