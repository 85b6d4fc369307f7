// SPDX-License-Identifier: BSD-2-Clause
// What the traits of the published system that config/paper.yaml emulates do, with the values of
// that file, in contrast with ours. Traits of one component alone are tested beside it.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "load_options.h"
#include <gtest/gtest.h>

#include "facet/estimator/planes/plane_membership.h"
#include "facet/regularities/plane_tracker.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/test_landmark.h"
#include "facet/testing/folders.h"
#include "facet/testing/pipeline/simulated_front.h"
#include "facet/testing/regularities/test_scene.h"

namespace facet {
namespace {

using testing::BelievingEstimator;
using testing::MakeFloor;
using testing::MakeMesh;
using testing::MakeWall;
using testing::Patch;

const VioOptions& Paper() {
  static const VioOptions options =
      LoadOptions(testing::SourceFolder() / "config" / "paper.yaml", {}).options;
  return options;
}

const SimulatedRun& TheRun() {
  static const SimulatedRun run = [] {
    FeatureSimulatorOptions options;
    options.max_tracks = 150;
    options.duration_s = 6;
    return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(8, 2)), EurocRig(), options, 1);
  }();
  return run;
}

// Calls `watch` after each keyframe but the start's.
using Watch = std::function<void(VioEstimator&, const EstimatorResult&)>;
void Estimate(const EstimatorOptions& options, const Watch& watch) {
  const SimulatedRun& run = TheRun();
  testing::SimulatedFront front(run);
  VioEstimator estimator(run.rig, ImuNoise{}, options);
  StageTimes times;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const bool is_running = estimator.is_initialised();
    const TrackedFrame frame = front.Track({}, front.Predict(run.frames[i].t));
    const EstimatorResult result =
        estimator.AddFrame(frame.frontend.observations, frame.imu, times);
    if (is_running && run.frames[i].is_keyframe) watch(estimator, result);
  }
}

// Accepted ones.
std::vector<int> StepsPerKeyframe(const EstimatorOptions& options) {
  std::vector<int> steps;
  Estimate(options, [&](const VioEstimator&, const EstimatorResult& result) {
    steps.push_back(result.solve.iterations);
  });
  return steps;
}

TEST(PaperTraitsTest, OneIterationPerKeyframe) {
  EstimatorOptions ours = Paper().estimator;
  ours.solver.keyframe_iterations = SolverOptions().keyframe_iterations;
  const std::vector<int> one = StepsPerKeyframe(Paper().estimator), more = StepsPerKeyframe(ours);
  ASSERT_GT(one.size(), 20u);
  EXPECT_EQ(std::count(one.begin(), one.end(), 1), std::ssize(one));
  EXPECT_GT(*std::max_element(more.begin(), more.end()), 1);
}

// Landmarks are on a plane in one keyframe and on none in the next.
TEST(PaperTraitsTest, WhatWasOnAPlaneStaysAProjectionFactor) {
  const auto num_left = [](const EstimatorOptions& options) {
    int keyframe = 0;
    std::ptrdiff_t num_projections = 0;
    Estimate(options, [&](VioEstimator& estimator, const EstimatorResult&) {
      PlaneAssignments found;
      for (const LandmarkEstimate& landmark : estimator.Snapshot().landmarks) {
        if (keyframe == 5) found.projected.push_back(landmark.id);
        if (keyframe == 6) found.unprojected.push_back(landmark.id);
      }
      estimator.Assign(found);
      const auto& landmarks = estimator.window().landmarks();
      if (keyframe == 7) {
        num_projections = std::count_if(
            landmarks.begin(), landmarks.end(), [](const auto& l) { return l.is_projection; });
      }
      ++keyframe;
    });
    return num_projections;
  };
  EXPECT_GT(num_left(Paper().estimator), 50);
  EstimatorOptions ours = Paper().estimator;
  ours.projection.convert_back = true;
  EXPECT_EQ(num_left(ours), 0);
}

// Tied to a plane that it is 10 cm off: how strongly the plane pulls at it [1/m]. The plane has a
// hundred other landmarks.
double Pull(const FactorNoise& noise) {
  Rng rng(3);
  testing::Problem problem = testing::MakeProblem({false, true, 0.0}, rng);
  const testing::WorldPoint point = problem.FromHost(problem.host(), Vector3d::Zero());
  const Vector3d l_W = point.y / point.rho, n_W = rng.UnitVector();
  SlidingWindow window;
  window.planes.emplace_back(PlaneId{0}, Plane{n_W, n_W.dot(l_W) - 0.1}, l_W, noise.plane_sigma_m);
  for (int i = 0; i < 100; ++i) {
    WindowLandmark& landmark = window.AddLandmark(LandmarkId{i}, 0);
    landmark = problem.landmark;
    landmark.id = LandmarkId{i};
    landmark.planes.Add(0);
  }
  WeighPlanes(noise, window);
  EXPECT_EQ(window.CountPlaneLandmarks(), std::vector<int>{100});
  problem.landmark.planes.Add(0);
  LandmarkBlock block;
  LinearizeLandmark(GeometryOf(problem), window.planes, problem.landmark, noise, block);
  return std::abs(block.plane_views[0].residual * block.plane_views[0].J_plane.z());
}

// The derivative of Huber's loss beyond 0.04 sigmas of 0.03 m each; within it, 10 cm would pull by
// 0.1 / 0.03^2 = 111.
TEST(PaperTraitsTest, APlanePullsALandmarkNoHarderThanThePapersLossAllows) {
  EXPECT_NEAR(Pull(FactorNoise(Paper().estimator)), 0.04 / 0.03, 1e-6);
  FactorNoise squared(Paper().estimator);
  squared.plane_huber_sigma = 1e3;
  EXPECT_NEAR(Pull(squared), 0.1 / (0.03 * 0.03), 1e-4);
}

// Keyframes through a tracker and an estimator that believes it.
class Tracking {
 public:
  explicit Tracking(const RegularityOptions& options) : tracker(options) {}

  PlaneAssignments Step(const std::vector<Patch>& patches) {
    view.time_s += 0.2;
    ++view.seed;
    SearchMesh mesh = MakeMesh(patches, view);
    if (all_are_support_points) {
      mesh.first_match = mesh.vertex_ids.front();
      mesh.end_match = LandmarkId{mesh.vertex_ids.back().value + 1};
    }
    MapSnapshot map = estimator.Snapshot(mesh);
    map.keyframes.push_back({FrameId{0}, mesh.t, map.latest.T_WB});
    const PlaneAssignments found = tracker.Process(mesh, map).assignments;
    estimator.Apply(found);
    num_created += static_cast<int>(found.created.size());
    num_ended += static_cast<int>(found.retired.size());
    num_measured += static_cast<int>(found.measurements.size());
    num_related += static_cast<int>(found.relations.size());
    return found;
  }
  void Run(const std::vector<Patch>& patches, int num_keyframes) {
    for (int k = 0; k < num_keyframes; ++k)
      Step(patches);
  }

  testing::TestView view{{0, 0, 1.4}, 0.01, 1, 0, 1};
  bool all_are_support_points = false;
  BelievingEstimator estimator;
  PlaneTracker tracker;
  int num_created = 0, num_ended = 0, num_measured = 0, num_related = 0;
};

RegularityOptions WithRevision() {
  RegularityOptions options = Paper().regularities;
  options.tracking.revise = true;
  return options;
}

TEST(PaperTraitsTest, PlanesThatMeetInOneWallAreNotMerged) {
  const auto num_ended = [](const RegularityOptions& options) {
    Tracking tracking(options);
    tracking.Run({MakeWall({3, -3, 1.4}, 0, 1.5, 2), MakeWall({3, 3, 1.4}, 0, 1.5, 2)}, 4);
    EXPECT_EQ(tracking.num_created, 2);
    for (double y = -3; y <= 3; y += 0.25)  // the wall between them; in less than 6 s
      tracking.Step({MakeWall({3, y, 1.4}, 0, 1.5, 2)});
    return tracking.num_ended;
  };
  EXPECT_EQ(num_ended(Paper().regularities), 0);
  EXPECT_EQ(num_ended(WithRevision()), 1);
}

TEST(PaperTraitsTest, APlaneThatDoesNotFitItsLandmarksIsNotTakenApart) {
  const auto num_ended = [](const RegularityOptions& options) {
    Tracking tracking(options);
    tracking.Run({MakeWall({3.1, 0, 1.4}, 0, 4, 2)}, 4);
    EXPECT_EQ(tracking.num_created, 1);
    for (int k = 0; k < 2; ++k) {  // a wrong belief: landmarks of walls 20 cm apart are on it
      for (int i = 0; i < 81; ++i)
        tracking.estimator.memberships[LandmarkId{10000 * k + i}] = {PlaneId{0}};
    }
    tracking.Run({MakeWall({3, 1.05, 1.4}, 0, 2, 2), MakeWall({3.2, -1.05, 1.4}, 0, 2, 2)}, 10);
    return tracking.num_ended;
  };
  EXPECT_EQ(num_ended(Paper().regularities), 0);
  EXPECT_EQ(num_ended(WithRevision()), 1);
}

TEST(PaperTraitsTest, PlanesAreNotRelated) {
  const auto num_related = [](const RegularityOptions& options) {
    Patch floor = MakeFloor({2, 0, 0}, 2, 3);
    floor.first_id = 50000;
    Tracking tracking(options);
    tracking.Run({MakeWall({3, 0, 1.4}, 0, 3, 2), floor}, 12);
    EXPECT_EQ(tracking.num_created, 2);
    return tracking.num_related;
  };
  EXPECT_EQ(num_related(Paper().regularities), 0);
  RegularityOptions ours = Paper().regularities;
  ours.relations.enabled = true;
  EXPECT_EQ(num_related(ours), 2) << "the wall is upright, the floor level";
}

TEST(PaperTraitsTest, SupportPointsSayNothingOfPlanes) {
  const auto num_measured = [](const RegularityOptions& options) {
    Tracking tracking(options);
    tracking.Run({MakeWall({3, 0, 1.4}, 0, 3, 2)}, 5);
    EXPECT_EQ(tracking.num_created, 1);
    tracking.all_are_support_points = true;
    tracking.Run({MakeWall({3, 0, 1.4}, 0, 3, 2)}, 3);
    return tracking.num_measured;
  };
  EXPECT_EQ(num_measured(Paper().regularities), 0);
  RegularityOptions ours = Paper().regularities;
  ours.measurements.enabled = true;
  EXPECT_EQ(num_measured(ours), 3);
}

// How many of the faces that a run shows are as asked for, and how many are not.
struct FaceCount {
  int yes = 0, no = 0;
};
FaceCount CountFaces(const VioOptions& options,
                     const std::function<bool(const MeshSnapshot&, std::size_t)>& is_so) {
  FaceCount out;
  testing::RunOnFeatures(TheRun(), options, [&](const VioOutput& output) {
    if (!output.mesh) return;
    for (std::size_t f = 0; f < output.mesh->mesh.faces.size(); ++f)
      ++(is_so(*output.mesh, f) ? out.yes : out.no);
  });
  return out;
}

bool Votes(const MeshSnapshot& mesh, std::size_t face) {
  return mesh.may_vote[face] != 0;
}

// Longest side, and its ratio to the shortest.
bool IsWithinTheAuthorsLimits(const MeshSnapshot& mesh, std::size_t face) {
  const auto& [a, b, c] = mesh.mesh.faces[face];
  const auto& at = mesh.mesh.vertices;
  const std::initializer_list<double> sides_m = {
      (at[a] - at[b]).norm(), (at[b] - at[c]).norm(), (at[c] - at[a]).norm()};
  const auto [shortest_m, longest_m] = std::minmax(sides_m);
  return longest_m <= 0.5 && shortest_m >= 0.5 * longest_m;
}

TEST(PaperTraitsTest, EveryFaceThatIsShownVotes) {
  const FaceCount paper = CountFaces(Paper(), Votes);
  EXPECT_GT(paper.yes, 100);
  EXPECT_EQ(paper.no, 0);
  EXPECT_GT(CountFaces(VioOptions(), Votes).no, 0);
}

// Planes only decide what is shown: both runs estimate the same.
TEST(PaperTraitsTest, KnownPlanesHideNoFace) {
  const auto any = [](const MeshSnapshot&, std::size_t) { return true; };
  VioOptions ours = Paper();
  ours.regularities.faces.enabled = true;
  EXPECT_GT(CountFaces(Paper(), any).yes, CountFaces(ours, any).yes);
}

TEST(PaperTraitsTest, FacesAreWithinTheAuthorsLimits) {
  const FaceCount paper = CountFaces(Paper(), IsWithinTheAuthorsLimits);
  EXPECT_GT(paper.yes, 100);
  EXPECT_EQ(paper.no, 0);
  EXPECT_GT(CountFaces(VioOptions(), IsWithinTheAuthorsLimits).no, 0);
}

}  // namespace
}  // namespace facet
