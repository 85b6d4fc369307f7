// SPDX-License-Identifier: BSD-2-Clause
// Detection and tracking of planes per keyframe: 20 planes, about 1500 faces and 900 vertices in a
// hall, 400 of the vertices landmarks of the estimator.
#include <numbers>

#include <benchmark/benchmark.h>

#include "facet/regularities/plane_tracker.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::MakeFloor;
using testing::MakeWall;
using testing::Patch;

// Floor, ceiling, walls with niches, tables and a few ramps.
std::vector<Patch> MakeHall() {
  std::vector<Patch> patches = {MakeFloor({3, 0, 0}, 4, 4), MakeFloor({3, 0, 3}, 4, 4)};
  for (int k = 0; k < 10; ++k) {
    const double azimuth = (k - 4.5) * 9 * std::numbers::pi / 180;
    const Vector3d middle(4.5 * std::cos(azimuth), 4.5 * std::sin(azimuth), 1.5);
    patches.push_back(MakeWall(middle, azimuth, 1.2, 2));
  }
  for (int k = 0; k < 5; ++k)
    patches.push_back(MakeFloor({2 + 0.3 * k, k - 2.0, 0.5 + 0.15 * k}, 0.9, 0.7));
  for (int k = 0; k < 3; ++k) {
    patches.push_back(testing::Turned(MakeFloor({2.5, -1.5 + 1.5 * k, 2.2}, 1, 1),
                                      Vector3d::UnitY(),
                                      (30 + 10 * k) * std::numbers::pi / 180));
  }
  for (Patch& patch : patches)
    patch.step_m = 0.27;
  return patches;
}

struct Scene {
  std::vector<SearchMesh> meshes;
  std::vector<MapSnapshot> maps;
};

// Every other vertex is a landmark; the estimator knows the planes when the tracker has seen all.
Scene MakeScene(PlaneTracker& tracker, bool with_known_planes) {
  Scene scene;
  testing::BelievingEstimator estimator;
  testing::TestView view;
  view.camera_W = {0, 0, 1.5};
  view.sigma_depth_m = 0.015;
  const std::vector<Patch> hall = MakeHall();
  for (int k = 0; k < 20; ++k) {
    view.seed = 1 + static_cast<std::uint64_t>(k);
    view.time_s += 0.2;
    scene.meshes.push_back(MakeMesh(hall, view));
    if (with_known_planes)
      estimator.Apply(tracker.Process(scene.meshes.back(), estimator.Snapshot(scene.meshes.back()))
                          .assignments);
  }
  for (const SearchMesh& mesh : scene.meshes) {
    MapSnapshot map = estimator.Snapshot(mesh);
    std::erase_if(map.landmarks, [](const auto& landmark) { return landmark.id.value % 2 == 1; });
    scene.maps.push_back(map);
  }
  return scene;
}

void Report(benchmark::State& state, const Scene& scene) {
  state.counters["faces"] = static_cast<double>(scene.meshes[0].faces.size());
  state.counters["vertices"] = static_cast<double>(scene.meshes[0].vertices.size());
  state.counters["landmarks"] = static_cast<double>(scene.maps[0].landmarks.size());
  state.counters["planes"] = static_cast<double>(scene.maps[0].planes.size());
}

// The usual keyframe: the planes are known.
void BM_TrackPlanes(benchmark::State& state) {
  PlaneTracker tracker{RegularityOptions()};
  const Scene scene = MakeScene(tracker, true);
  std::size_t k = 0;
  for (auto _ : state) {
    // Time stands still, so that no plane falls asleep.
    benchmark::DoNotOptimize(tracker.Process(scene.meshes.back(), scene.maps[k]));
    k = (k + 1) % scene.maps.size();
  }
  Report(state, scene);
}
BENCHMARK(BM_TrackPlanes)->Unit(benchmark::kMicrosecond);

// The worst keyframe: nothing is known and all faces are searched.
void BM_DetectPlanes(benchmark::State& state) {
  PlaneTracker unused{RegularityOptions()};
  const Scene scene = MakeScene(unused, false);
  PlaneDetector detector{DetectionOptions()};
  SurfaceFaces faces;
  std::size_t k = 0, found = 0;
  for (auto _ : state) {
    FillSurfaceFaces(scene.meshes[k], faces);
    found = detector.Detect(faces, std::vector<char>(faces.faces.size(), 0)).size();
    k = (k + 1) % scene.meshes.size();
  }
  Report(state, scene);
  state.counters["planes"] = static_cast<double>(found);
}
BENCHMARK(BM_DetectPlanes)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace facet

BENCHMARK_MAIN();
