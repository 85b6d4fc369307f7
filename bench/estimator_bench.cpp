// SPDX-License-Identifier: BSD-2-Clause
// Kernels of the back end on a window of the usual size: 10 poses, 5 full states, 200 landmarks.
#include <benchmark/benchmark.h>

#include "facet/estimator/solver/marginalization.h"
#include "facet/estimator/solver/window_solver.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

constexpr int kPoses = 10, kFullStates = 5, kLandmarks = 200;
constexpr int kPlanes = 20, kPlaneRows = 500;

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
    ImuPreintegration imu(ImuBias{}, ImuParameters{1.7e-4, 2e-3, 1e-8});
    imu.Integrate(samples);
    benchmark::DoNotOptimize(imu);
  }
}
BENCHMARK(BM_Preintegrate)->Unit(benchmark::kMicrosecond);

void BM_Linearize(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  const FactorNoise noise{EstimatorOptions{}};
  FrameGeometry geometry(test.rig);
  LinearizedWindow linear;
  for (auto _ : state) {
    geometry.Update(test.window.frames);
    Linearize(test.window, geometry, noise, CalibrationStep::kFree, linear);
  }
}
BENCHMARK(BM_Linearize)->Unit(benchmark::kMicrosecond);

// Elimination of landmarks and motions, Cholesky factorisation, back-substitution.
void BM_Solve(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  LinearizedWindow linear;
  testing::Linearize(test, FactorNoise(EstimatorOptions{}), linear);
  ReducedSystem reduced;
  for (auto _ : state) {
    if (!reduced.Solve(1e-9, linear)) state.SkipWithError("not positive definite");
  }
}
BENCHMARK(BM_Solve)->Unit(benchmark::kMicrosecond);

// What a keyframe does: at most two iterations, from where the light update left it.
void BM_OptimizeKeyframe(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  const SolverOptions options;
  const FactorNoise noise{EstimatorOptions{}};
  WindowSolver solver(test.rig, options);
  for (auto _ : state) {
    state.PauseTiming();
    SlidingWindow window = test.window;
    state.ResumeTiming();
    benchmark::DoNotOptimize(solver.Solve(window, noise, options.keyframe_iterations));
  }
}
BENCHMARK(BM_OptimizeKeyframe)->Unit(benchmark::kMicrosecond);

// 20 planes with 500 landmarks on them, and 28 relations between them. As in simulated flights, a
// landmark is seen from some three keyframes, nearly always by both cameras. The landmarks are
// anywhere, so the surfaces are called rough.
testing::TestWindow MakeWindowWithPlanes() {
  testing::TestWindowOptions options;
  options.num_frames = kPoses + kFullStates;
  options.num_pose_frames = kPoses;
  options.num_landmarks = 740;
  options.miss_share = 0.8;
  options.right_share = 0.9;
  Rng rng(12);
  testing::TestWindow test = testing::MakeTestWindow(options, rng);
  testing::Disturb(test.window, testing::StepSigmas{}, rng);
  SlidingWindow& window = test.window;
  for (int k = 0; k < kPlanes; ++k) {
    const Vector3d n = rng.UnitVector();
    const Vector3d& p_W = test.points[static_cast<std::size_t>(k)];
    window.planes.emplace_back(PlaneId{k}, Plane{n, n.dot(p_W)}, p_W, 1.0);
  }
  for (std::size_t row = 0; row < kPlaneRows; ++row)
    window.landmarks()[row].planes.Add(static_cast<int>(row % kPlanes));
  for (int k = 1; k < kPlanes; ++k) {
    window.AddRelation({PlaneRelationKind::kParallel, PlaneId{0}, PlaneId{k}});
    if (k % 2 == 0) window.AddRelation({PlaneRelationKind::kVertical, PlaneId{k}});
  }
  return test;
}

FactorNoise RoughSurfaces() {
  FactorNoise noise{EstimatorOptions{}};
  noise.relations.sigma_rad = noise.relations.gravity_sigma_rad = 1.0;
  return noise;
}

// The same window with its planes and without.
void BM_OptimizeKeyframePlanes(benchmark::State& state) {
  testing::TestWindow test = MakeWindowWithPlanes();
  int num_rows = 0;
  for (WindowLandmark& landmark : test.window.landmarks()) {
    if (state.range(0) == 0) landmark.planes = PlaneLinks();
    num_rows += landmark.planes.count();
  }
  while (state.range(0) == 0 && !test.window.planes.empty())
    test.window.RemovePlane(0);
  const SolverOptions options;
  const FactorNoise noise = RoughSurfaces();
  WindowSolver solver(test.rig, options);
  int iterations = 0;
  for (auto _ : state) {
    state.PauseTiming();
    SlidingWindow window = test.window;
    state.ResumeTiming();
    iterations = solver.Solve(window, noise, options.keyframe_iterations).iterations;
  }
  std::size_t num_observations = 0;
  for (const WindowLandmark& landmark : test.window.landmarks())
    num_observations += landmark.observations.size();
  state.counters["observations"] = static_cast<double>(num_observations);
  state.counters["landmarks"] = static_cast<double>(test.window.landmarks().size());
  state.counters["planes"] = static_cast<double>(test.window.planes.size());
  state.counters["plane_rows"] = num_rows;
  state.counters["relations"] = static_cast<double>(test.window.relations.size());
  state.counters["iterations"] = iterations;
}
BENCHMARK(BM_OptimizeKeyframePlanes)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

// The usual step: one pose, one motion and every tenth landmark leave.
void BM_Marginalize(benchmark::State& state) {
  const testing::TestWindow test = MakeWindow();
  MarginalizationPlan plan(test.window);
  plan.drop_frame[0] = 1;
  plan.drop_motion[kPoses] = 1;
  for (std::size_t l = 0; l < plan.drop_landmark.size(); l += 10)
    plan.drop_landmark[l] = 1;
  const FactorNoise noise{EstimatorOptions{}};
  for (auto _ : state) {
    state.PauseTiming();
    SlidingWindow window = test.window;
    state.ResumeTiming();
    Marginalize(plan, test.rig, noise, window);
  }
}
BENCHMARK(BM_Marginalize)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace facet

BENCHMARK_MAIN();
