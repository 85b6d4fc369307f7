// SPDX-License-Identifier: BSD-2-Clause
// Kernels of the front end on a synthetic textured image of EuRoC's size.
#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include "facet/base/random.h"
#include "facet/frontend/feature_detector.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/patch_tracker.h"
#include "facet/frontend/stereo_matcher.h"
#include "facet/frontend/temporal_tracker.h"

namespace facet {
namespace {

constexpr int kWidth = 752, kHeight = 480, kLevels = 4, kParameters = 4, kPoints = 150;

// Smooth noise; the second image is shifted by a quarter pixel.
cv::Mat MakeImage(double shift) {
  cv::Mat image(kHeight, kWidth, CV_8UC1);
  Rng rng(3);
  constexpr int kWaves = 12;
  double fx[kWaves], fy[kWaves], phase[kWaves];
  for (int k = 0; k < kWaves; ++k) {
    fx[k] = rng.Uniform(-0.8, 0.8), fy[k] = rng.Uniform(-0.8, 0.8), phase[k] = rng.Uniform(0, 6);
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double value = 128;
      for (int k = 0; k < kWaves; ++k) {
        value += 12 * std::sin(fx[k] * (x - shift) + fy[k] * y + phase[k]);
      }
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(value);
    }
  }
  return image;
}

std::vector<Vector2d> MakePoints() {
  Rng rng(5);
  std::vector<Vector2d> points;
  for (int i = 0; i < kPoints; ++i)
    points.emplace_back(rng.Uniform(60, 690), rng.Uniform(60, 420));
  return points;
}

const char* Variant(benchmark::State& state) {
  constexpr const char* kNames[] = {"scalar", "sse2", "avx2"};
  const char* name = kNames[state.range(0)];
  state.SetLabel(name);
  if (FindPatchKernels(name) == nullptr) state.SkipWithError("not available here");
  return name;
}

PatchTracker MakeTracker(benchmark::State& state) {
  KltOptions options;
  options.simd = Variant(state);
  if (FindPatchKernels(options.simd) == nullptr) options.simd = "auto";
  return PatchTracker(options, kParameters);
}

void BM_Pyramid(benchmark::State& state) {
  const cv::Mat image = MakeImage(0);
  ImagePyramid pyramid;
  for (auto _ : state)
    pyramid.Build(image, kLevels);
}
BENCHMARK(BM_Pyramid)->Unit(benchmark::kMicrosecond);

void BM_Detect(benchmark::State& state) {
  const cv::Mat image = MakeImage(0);
  ImagePyramid pyramid;
  pyramid.Build(image, kLevels);
  FeatureDetector detector(DetectorOptions{}, KltOptions{});
  for (auto _ : state) {
    benchmark::DoNotOptimize(detector.Detect(image, pyramid.level(0), {}, 160));
  }
}
BENCHMARK(BM_Detect)->Unit(benchmark::kMicrosecond);

// All levels of 150 patches.
void BM_Extract(benchmark::State& state) {
  const PatchTracker tracker = MakeTracker(state);
  ImagePyramid pyramid;
  pyramid.Build(MakeImage(0), kLevels);
  const std::vector<Vector2d> points = MakePoints();
  std::vector<PatchPyramid> patches(points.size());
  for (auto _ : state) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      tracker.Extract(pyramid,
                      static_cast<float>(points[i].x()),
                      static_cast<float>(points[i].y()),
                      {kLevels - 1, 0},
                      patches[i]);
    }
  }
}
BENCHMARK(BM_Extract)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

// 150 patches from the coarsest to the finest level.
void BM_Track(benchmark::State& state) {
  const PatchTracker tracker = MakeTracker(state);
  ImagePyramid first, second;
  first.Build(MakeImage(0), kLevels);
  second.Build(MakeImage(1.3), kLevels);
  const std::vector<Vector2d> points = MakePoints();
  std::vector<PatchPyramid> patches(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    tracker.Extract(first,
                    static_cast<float>(points[i].x()),
                    static_cast<float>(points[i].y()),
                    {kLevels - 1, 0},
                    patches[i]);
  }
  int found = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      PatchWarp warp;
      warp.x = static_cast<float>(points[i].x());
      warp.y = static_cast<float>(points[i].y());
      found += tracker.Align(patches[i], second, {kLevels - 1, 0}, warp).ok ? 1 : 0;
    }
  }
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}
BENCHMARK(BM_Track)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

// Search and refinement of new points; the right image is the left one shifted by 1.3 pixels.
void BM_Match(benchmark::State& state) {
  CameraIntrinsics k;
  k.width = kWidth, k.height = kHeight;
  k.fx = k.fy = 458, k.cx = 370, k.cy = 240;
  StereoRig rig;
  rig.cameras = {CameraModel(k), CameraModel(k)};
  rig.T_BC[1].p.x() = 0.11;
  FrontendOptions options;
  options.klt.simd = Variant(state);
  if (FindPatchKernels(options.klt.simd) == nullptr) options.klt.simd = "auto";
  const cv::Mat left_image = MakeImage(0), right_image = MakeImage(-1.3);
  ImagePyramid left, right;
  left.Build(left_image, kLevels);
  right.Build(right_image, kLevels);
  StereoMatcher matcher(rig, options);
  const TemporalTracker tracker(rig.cameras[0], options);
  std::vector<Track> tracks(kPoints);
  const std::vector<Vector2d> points = MakePoints();
  for (std::size_t i = 0; i < points.size(); ++i)
    tracker.Begin(left, points[i], tracks[i]);
  int found = 0;
  for (auto _ : state) {
    for (const Track& track : tracks)
      found += matcher.Match(track, left, right) ? 1 : 0;
  }
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}
BENCHMARK(BM_Match)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // otherwise OpenCV hides cost in other threads
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
