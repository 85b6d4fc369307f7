// SPDX-License-Identifier: BSD-2-Clause
#include "live_state_study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <numeric>
#include <optional>

#include "facet/live/state_predictor.h"

namespace facet {

namespace {

constexpr Duration kMaxImuGap{20'000'000};
using Clock = std::chrono::steady_clock;

template <class Call>
auto Timed(CallTimes& times, const Call& call) {
  const auto begin = Clock::now();
  struct Stop {
    CallTimes& times;
    Clock::time_point begin;
    ~Stop() {
      times.us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    }
  } const stop{times, begin};
  return call();
}

ImuBias Mixed(const ImuBias& a, const ImuBias& b, double share) {
  return {(1 - share) * a.b_g + share * b.b_g, (1 - share) * a.b_a + share * b.b_a};
}

// One flight: the estimator frame by frame, and beside it the predictors sample by sample.
class Runner {
 public:
  Runner(const Scenario& scenario,
         const SimulatedRun& run,
         const LiveStateOptions& options,
         LiveStateFigures& figures)
      : scenario_(scenario),
        run_(run),
        latency_(FromSeconds(options.latency_s)),
        ask_after_(FromSeconds(options.ask_after_s)),
        figures_(figures),
        estimator_(run.rig, options.consistency.simulator.imu.noise, options.consistency.estimator),
        at_once_(options.consistency.simulator.imu.noise,
                 options.consistency.estimator.imu,
                 PredictionOptions{}),
        smoothed_(options.consistency.simulator.imu.noise,
                  options.consistency.estimator.imu,
                  PredictionOptions{options.smoothing_s, 1, {}}) {
    for (const ImuSample& sample : run.imu)
      imu_.Add(sample);
  }

  void Run() {
    std::size_t next_frame = 0;
    for (const ImuSample& sample : run_.imu) {
      if (sample.t + ask_after_ > run_.truth.back().t) break;
      Timed(figures_.add_imu, [&] { at_once_.AddImu(sample); });
      smoothed_.AddImu(sample);
      while (next_frame < run_.truth.size() && run_.truth[next_frame].t + latency_ <= sample.t) {
        ProcessFrame(next_frame++);
      }
      Ask(sample.t + ask_after_);
    }
  }

 private:
  void ProcessFrame(std::size_t i) {
    const bool was_initialised = estimator_.is_initialised();
    ImuInterval imu;
    if (i > 0) imu = imu_.Between(run_.truth[i - 1].t, run_.truth[i].t, kMaxImuGap, Duration{0});
    StageTimes times;
    const EstimatorResult result =
        estimator_.AddFrame(AsFrontEnd(run_.frames[i], was_initialised), imu, times);
    if (result.has_state && !was_initialised) {
      const StartPrior& origin = estimator_.window().start_prior.value();
      T_WG_ = GaugeTransform(origin.T_WB, run_.truth[origin.frame.value].T_WB);
    }
    Timed(figures_.add_frame, [&] {
      at_once_.AddFrame(result.causal, result.has_state, result.status, result.segment);
    });
    smoothed_.AddFrame(result.causal, result.has_state, result.status, result.segment);
    if (result.has_state)
      figures_.frames.Add(CompareWithTruth(result.state, result.covariance, run_.truth[i], *T_WG_));
  }

  void Ask(Timestamp t) {
    const auto state = Timed(figures_.predict, [&] { return at_once_.PredictAt(t); });
    if (!state) return;
    figures_.predictions.Add(Judge(*state));
    AddStep(*state, last_, figures_.largest_jump_m);
    const auto smooth = smoothed_.PredictAt(t);
    figures_.smoothed.Add(Judge(*smooth));
    AddStep(*smooth, last_smooth_, figures_.largest_step_m);
    figures_.largest_held_back_m =
        std::max(figures_.largest_held_back_m, smooth->held_back.segment<3>(3).norm());
  }

  FrameError Judge(const PredictedState& state) const {
    const NavState estimate{state.t, state.T_WF, state.v_WF, state.bias};
    return CompareWithTruth(estimate, state.covariance, TruthAt(state.t), *T_WG_);
  }

  static void AddStep(const PredictedState& now,
                      std::optional<PredictedState>& last,
                      double& largest_m) {
    if (last) {
      const double dt = ToSeconds(now.t - last->t);
      const Vector3d moved = now.T_WF.p - last->T_WF.p;
      largest_m = std::max(largest_m, (moved - 0.5 * dt * (now.v_WF + last->v_WF)).norm());
    }
    last = now;
  }

  // The pose is the trajectory's; the biases walk between the frames as good as straight.
  NavState TruthAt(Timestamp t) const {
    NavState truth = scenario_.trajectory.At(t).state;
    const auto after = std::lower_bound(
        run_.truth.begin(), run_.truth.end(), t, [](const NavState& x, Timestamp s) {
          return x.t < s;
        });
    truth.bias = after->bias;
    if (after == run_.truth.begin()) return truth;
    const NavState& before = *std::prev(after);
    truth.bias =
        Mixed(before.bias, after->bias, ToSeconds(t - before.t) / ToSeconds(after->t - before.t));
    return truth;
  }

  const Scenario& scenario_;
  const SimulatedRun& run_;
  const Duration latency_, ask_after_;
  LiveStateFigures& figures_;
  VioEstimator estimator_;
  ImuBuffer imu_;
  StatePredictor at_once_, smoothed_;
  std::optional<SE3> T_WG_;
  std::optional<PredictedState> last_, last_smooth_;
};

void PrintErrors(const char* name, const StateErrors& errors) {
  std::printf("  %-22s %7d %9.2f", name, errors.nees.count, 1e3 * errors.PositionRmse());
  for (std::size_t k = 0; k < kNumStateParts; ++k)
    std::printf(" %11.3f", errors.nees[static_cast<StatePart>(k)]);
  std::printf("\n");
}

void PrintTimes(const char* name, const CallTimes& times) {
  std::printf("  %-22s mean %5.2f us, p99 %5.2f us, %zu calls\n",
              name,
              times.Mean(),
              times.Percentile(0.99),
              times.us.size());
}

}  // namespace

void StateErrors::Add(const FrameError& error) {
  square_m2 += error.error.segment<3>(3).squaredNorm();
  nees.Add(ComputeNeesRatios(error));
}

double StateErrors::PositionRmse() const {
  return std::sqrt(square_m2 / nees.count);
}

double CallTimes::Mean() const {
  return std::accumulate(us.begin(), us.end(), 0.0) / static_cast<double>(us.size());
}

double CallTimes::Percentile(double share) const {
  std::vector<double> sorted = us;
  std::ranges::sort(sorted);
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double LiveStateFigures::NeesDeviation(StatePart part) const {
  return std::abs(predictions.nees[part] / frames.nees[part] - 1);
}

LiveStateFigures StudyLiveState(const Scenario& scenario, const LiveStateOptions& options) {
  LiveStateFigures figures;
  figures.name = scenario.name;
  for (int k = 0; k < options.consistency.num_seeds; ++k) {
    const auto seed = static_cast<std::uint64_t>(options.consistency.first_seed + k);
    const SimulatedRun run = Simulate(scenario, options.consistency, seed);
    Runner(scenario, run, options, figures).Run();
    ++figures.num_runs;
  }
  return figures;
}

void PrintFigures(const LiveStateFigures& figures) {
  std::printf("%s, %d runs\n", figures.name.c_str(), figures.num_runs);
  std::printf("  %-22s %7s %9s", "NEES / dof", "states", "rmse [mm]");
  for (const char* name : kStatePartNames)
    std::printf(" %11s", name);
  std::printf("\n");
  PrintErrors("frames", figures.frames);
  PrintErrors("PredictAt", figures.predictions);
  PrintErrors("PredictAt, smoothed", figures.smoothed);
  std::printf(
      "  position error %.3f x the frames', NEES off by %.1f %% (position), %.1f %% (all 15)\n",
      figures.RmseRatio(),
      100 * figures.NeesDeviation(StatePart::kPosition),
      100 * figures.NeesDeviation(StatePart::kAll));
  std::printf("  largest jump %.2f mm, smoothed %.2f mm with up to %.2f mm held back\n",
              1e3 * figures.largest_jump_m,
              1e3 * figures.largest_step_m,
              1e3 * figures.largest_held_back_m);
  PrintTimes("PredictAt", figures.predict);
  PrintTimes("AddImu", figures.add_imu);
  PrintTimes("AddFrame", figures.add_frame);
}

}  // namespace facet
