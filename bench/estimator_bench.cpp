// SPDX-License-Identifier: BSD-2-Clause
// Kernels of the back end on a window of the usual size: 10 poses, 5 full states, 200 landmarks.
#include <benchmark/benchmark.h>

#include "facet/estimator/marginalization.h"
#include "facet/estimator/test_window.h"
#include "facet/estimator/window_solver.h"

namespace facet {
namespace {

constexpr int kPoses = 10, kFullStates = 5, kLandmarks = 200;

testing::TestWindow MakeWindow() {
  testing::TestWindowOptions options;
  options.num_frames = kPoses + kFullStates;
  options.num_pose_frames = kPoses;
  options.num_landmarks = kLandmarks;
  Rng rng(11);
  testing::TestWindow test = testing::MakeTestWindow(options, rng);
  testing::Disturb(test.window, testing::StepSigmas{}, rng);
  return test;
}

// The IMU samples of one keyframe interval: 0.2 s at 200 Hz.
void BM_Preintegrate(benchmark::State& state) {
  Rng rng(11);
  const testing::TestMotion motion = testing::TestMotion::Random(rng);
  std::vector<ImuSample> samples;
  constexpr int kSamples = 41;
  for (int i = 0; i < kSamples; ++i)
    samples.push_back(motion.ImuAt(0.005 * i, ImuBias{}));
  for (auto _ : state) {
    ImuPreintegration imu(ImuBias{}, PreintegrationNoise{1.7e-4, 2e-3, 1e-8});
    imu.Integrate(samples);
    benchmark::DoNotOptimize(imu);
  }
}
BENCHMARK(BM_Preintegrate)->Unit(benchmark::kMicrosecond);

void BM_Linearize(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  WindowSystem system(test.rig);
  for (auto _ : state)
    system.Linearize(test.window, RobustOptions{});
}
BENCHMARK(BM_Linearize)->Unit(benchmark::kMicrosecond);

// Elimination of landmarks and motions, Cholesky factorisation, back-substitution.
void BM_Solve(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  WindowSystem system(test.rig);
  system.Linearize(test.window, RobustOptions{});
  for (auto _ : state) {
    if (!system.Solve(test.window, 1e-9)) state.SkipWithError("not positive definite");
  }
}
BENCHMARK(BM_Solve)->Unit(benchmark::kMicrosecond);

// What a keyframe does: at most two iterations, from where the light update left it.
void BM_OptimizeKeyframe(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  const SolverOptions options;
  WindowSolver solver(test.rig, options);
  for (auto _ : state) {
    state.PauseTiming();
    SlidingWindow window = test.window;
    state.ResumeTiming();
    benchmark::DoNotOptimize(solver.Solve(window, options.keyframe_iterations));
  }
}
BENCHMARK(BM_OptimizeKeyframe)->Unit(benchmark::kMicrosecond);

// The usual step: one pose, one motion and every tenth landmark leave.
void BM_Marginalize(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  MarginalizationPlan plan(test.window);
  plan.drop_frame[0] = 1;
  plan.drop_motion[kPoses] = 1;
  for (std::size_t l = 0; l < plan.drop_landmark.size(); l += 10)
    plan.drop_landmark[l] = 1;
  for (auto _ : state) {
    state.PauseTiming();
    SlidingWindow window = test.window;
    state.ResumeTiming();
    Marginalize(plan, test.rig, RobustOptions{}, window);
  }
}
BENCHMARK(BM_Marginalize)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace facet

BENCHMARK_MAIN();
