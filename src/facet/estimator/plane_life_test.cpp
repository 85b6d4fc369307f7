// SPDX-License-Identifier: BSD-2-Clause
// Planes, relations and the landmarks of pipeline SP in the running estimator.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include "facet/estimator/vio_estimator.h"
#include "facet/geometry/plane_fit.h"
#include "facet/imu/imu_buffer.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

const SimulatedRun& TheRun() {
  static const SimulatedRun run = [] {
    FeatureSimulatorOptions options;
    options.max_tracks = 100;
    options.duration_s = 10;
    return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(12, 2)), EurocRig(), options, 1);
  }();
  return run;
}

using Policy = std::function<PlaneAssignments(const VioEstimator&)>;
using Watch = std::function<void(const VioEstimator&)>;

// Runs the estimator; `policy` speaks and `watch` looks after each keyframe.
std::vector<EstimatorResult> Estimate(const EstimatorOptions& options,
                                      const Policy& policy,
                                      const Watch& watch) {
  const SimulatedRun& run = TheRun();
  ImuBuffer buffer;
  for (const ImuSample& sample : run.imu)
    buffer.Add(sample);
  VioEstimator estimator(run.rig, ImuNoise{}, options);
  StageTimes times;
  std::vector<EstimatorResult> results;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    ImuInterval imu;
    if (i > 0)
      imu = buffer.Between(run.truth[i - 1].t, run.truth[i].t, Duration{20'000'000}, Duration{0});
    results.push_back(estimator.AddFrame(run.frames[i], imu, times));
    if (!results.back().has_state || !run.frames[i].is_keyframe) continue;
    watch(estimator);
    estimator.Assign(policy(estimator));
  }
  return results;
}

// True planes as soon as they have landmarks enough; `per_surface` of them for each surface, among
// which its landmarks are dealt out.
PlaneAssignments TruePlanes(const VioEstimator& estimator, std::int64_t per_surface = 1) {
  PlaneAssignments out;
  std::map<PlaneId, std::vector<Vector3d>> points;
  const MapSnapshot snapshot = estimator.Snapshot();
  for (const LandmarkEstimate& landmark : snapshot.landmarks) {
    const PlaneId surface = TheRun().landmarks.at(landmark.id).surface;
    const PlaneId plane{surface.value * per_surface + landmark.id.value % per_surface};
    points[plane].push_back(landmark.p_W);
    out.attached.push_back({landmark.id, plane});
  }
  for (const auto& [plane, on_plane] : points) {
    const PlaneFit fit = FitPlane(on_plane);
    if (on_plane.size() >= 8 && fit.extent_minor_m > 0.15)
      out.created.push_back({plane, fit.plane, fit.centroid});
  }
  return out;
}

// What the newest keyframe sees of these planes, exactly, although with sigmas.
std::vector<PlaneMeasurement> TrueMeasurements(const VioEstimator& estimator,
                                               const std::vector<NewPlane>& planes) {
  const KeyframePose newest = estimator.Snapshot().keyframes.back();
  const auto& truth = TheRun().truth;
  const auto state =
      std::find_if(truth.begin(), truth.end(), [&](const NavState& x) { return x.t == newest.t; });
  const SE3 T_BW = state->T_WB.Inverse();
  std::vector<PlaneMeasurement> out;
  for (const NewPlane& plane : planes) {
    const Surface& surface = TheRun().surfaces[static_cast<std::size_t>(plane.id.value)];
    PlaneMeasurement measurement{newest.id, plane.id};
    measurement.centre_B = T_BW * surface.center_W;
    measurement.along_B = {T_BW.q * surface.u_W, T_BW.q * surface.v_W};
    measurement.sigma_m = 0.005;
    measurement.sigma_rad = {0.005, 0.005};
    out.push_back(measurement);
  }
  return out;
}

// Angle between the newest estimate of each plane and the true surface, as the body sees both.
double MeanNormalError(const VioEstimator& estimator) {
  const MapSnapshot snapshot = estimator.Snapshot();
  const auto& truth = TheRun().truth;
  const auto state = std::find_if(
      truth.begin(), truth.end(), [&](const NavState& x) { return x.t == snapshot.latest.t; });
  double sum = 0;
  for (const PlaneEstimate& plane : snapshot.planes) {
    const Vector3d n_B = snapshot.latest.T_WB.q.conjugate() * plane.plane_W.n;
    const Surface& surface = TheRun().surfaces[static_cast<std::size_t>(plane.id.value)];
    sum += n_B.cross(state->T_WB.q.conjugate() * surface.n_W).norm();
  }
  return sum / static_cast<double>(snapshot.planes.size());
}

bool SameBits(const std::vector<EstimatorResult>& a, const std::vector<EstimatorResult>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].state.T_WB.p != b[i].state.T_WB.p ||
        a[i].state.T_WB.q.coeffs() != b[i].state.T_WB.q.coeffs() ||
        a[i].covariance != b[i].covariance) {
      return false;
    }
  }
  return a.size() == b.size();
}

PlaneAssignments Nothing(const VioEstimator&) {
  return {};
}
void DoNotWatch(const VioEstimator&) {}

TEST(PlaneLifeTest, TheMoreLandmarksAPlaneHasTheLessEachSays) {
  EstimatorOptions options;
  options.solver.plane_sigma_m = 0.013;
  options.solver.plane_common_sigma_m = 0.004;
  int seen = 0;
  const auto watch = [&](const VioEstimator& estimator) {
    for (const PlaneEstimate& plane : estimator.Snapshot().planes) {
      // Some have left since the plane's rows were weighed, and some spots were heard before.
      const double now_m = std::hypot(0.013, 0.004 * std::sqrt(plane.num_landmarks));
      EXPECT_GE(plane.row_sigma_m, 0.8 * now_m);
      EXPECT_LT(plane.row_sigma_m, 1.5 * now_m);
      ++seen;
    }
  };
  Estimate(
      options, [](const VioEstimator& estimator) { return TruePlanes(estimator); }, watch);
  EXPECT_GT(seen, 20);
}

TEST(PlaneLifeTest, PlanesThatNoLandmarkLiesOnLeaveNoTrace) {
  const auto s = Estimate({}, Nothing, DoNotWatch);
  const auto detached = Estimate(
      {},
      [](const VioEstimator& estimator) {
        PlaneAssignments out = TruePlanes(estimator);
        for (const PlaneAttachment& join : out.attached)
          out.detached.emplace_back(join.landmark, join.plane);
        out.attached.clear();
        const std::vector<PlaneMeasurement> measured = TrueMeasurements(estimator, out.created);
        out.measurements.insert(out.measurements.end(), measured.begin(), measured.end());
        for (const NewPlane& plane : out.created) {
          out.relations.push_back({PlaneRelationKind::kVertical, plane.id});
          out.relations.push_back({PlaneRelationKind::kParallel, out.created.front().id, plane.id});
        }
        return out;
      },
      DoNotWatch);
  EXPECT_TRUE(SameBits(s, detached));
  const auto attached = Estimate(
      {}, [](const VioEstimator& e) { return TruePlanes(e); }, DoNotWatch);
  EXPECT_FALSE(SameBits(s, attached));
}

// Seven landmarks join each plane, which then is too few for it to stay: all of them are detached
// again before the window is solved. (What joins and is told to leave later has been solved with in
// between: WindowSolverTest.LandmarksThatLeaveTheirPlanesTakeTheirPullWithThem.)
TEST(PlaneLifeTest, LandmarksThatAreDetachedBeforeTheSolveLeaveNoTrace) {
  constexpr int kMembers = 7;
  std::size_t most_planes = 0;
  const auto estimate = [&](int needed) {
    EstimatorOptions options;
    options.planes.min_landmarks = needed;
    return Estimate(
        options,
        [](const VioEstimator& estimator) {
          PlaneAssignments out = TruePlanes(estimator);
          std::map<PlaneId, int> members;
          std::erase_if(out.attached,
                        [&](const auto& join) { return ++members[join.plane] > kMembers; });
          return out;
        },
        [&](const VioEstimator& estimator) {
          most_planes = std::max(most_planes, estimator.window().planes.size());
        });
  };
  const auto s = Estimate({}, Nothing, DoNotWatch);
  EXPECT_TRUE(SameBits(s, estimate(kMembers + 1)));
  EXPECT_EQ(most_planes, 0u);
  EXPECT_FALSE(SameBits(s, estimate(kMembers)));
  EXPECT_GT(most_planes, 0u) << "they did join";
}

TEST(PlaneLifeTest, MeasurementsDetermineThePlanes) {
  const auto run = [](bool is_measured) {
    double error = 0;
    std::size_t num_planes = 0;
    Estimate(
        {},
        [&](const VioEstimator& estimator) {
          PlaneAssignments out = TruePlanes(estimator);
          if (is_measured) out.measurements = TrueMeasurements(estimator, out.created);
          return out;
        },
        [&](const VioEstimator& estimator) {
          error = MeanNormalError(estimator);
          num_planes = estimator.Snapshot().planes.size();
        });
    EXPECT_GE(num_planes, 5u);
    return error;
  };
  const double without = run(false), with = run(true);
  EXPECT_LT(with, 0.5 * without);
  EXPECT_LT(with, 0.003);
}

TEST(PlaneLifeTest, NoMoreThanTheBudgetStay) {
  EstimatorOptions options;
  options.planes.max_planes = 3;
  options.planes.anchor_distance_m = 0.2;
  std::size_t most_planes = 0, num_frozen = 0;
  const auto results = Estimate(
      options,
      [](const VioEstimator& estimator) {
        PlaneAssignments out = TruePlanes(estimator, 3);
        for (const WindowPlane& plane : estimator.window().planes) {
          for (const WindowPlane& other : estimator.window().planes) {
            if (plane.id.value / 3 == other.id.value / 3)
              out.relations.push_back({PlaneRelationKind::kCoplanar, plane.id, other.id});
          }
        }
        return out;
      },
      [&](const VioEstimator& estimator) {
        const SlidingWindow& window = estimator.window();
        most_planes = std::max(most_planes, window.planes.size());
        for (const WindowPlane& plane : window.planes)
          num_frozen += plane.frozen;
        for (const WindowRelation& relation : window.relations) {
          EXPECT_GE(window.IndexOf(relation.relation.a), 0);
          EXPECT_GE(window.IndexOf(relation.frame), 0);
        }
      });
  EXPECT_EQ(most_planes, 3u);
  EXPECT_GT(num_frozen, 0u);
  EXPECT_EQ(results.back().status, TrackingStatus::kOk);
  // Over the last two seconds.
  const std::size_t last = results.size() - 1, from = last - 40;
  const SE3 moved = results[from].state.T_WB.Inverse() * results[last].state.T_WB;
  const SE3 truly = TheRun().truth[from].T_WB.Inverse() * TheRun().truth[last].T_WB;
  EXPECT_LT((moved.p - truly.p).norm(), 0.03);
}

TEST(PlaneLifeTest, ARelationThatDoesNotHoldIsDropped) {
  int most_true = 0, most_false = 0;
  Estimate(
      {},
      [](const VioEstimator& estimator) {
        PlaneAssignments out = TruePlanes(estimator);
        for (const NewPlane& plane : out.created) {
          const Vector3d& n = TheRun().surfaces[static_cast<std::size_t>(plane.id.value)].n_W;
          const bool is_flat = std::abs(n.z()) > 0.5;
          out.relations.push_back({PlaneRelationKind::kHorizontal, plane.id});
          if (!is_flat) out.relations.push_back({PlaneRelationKind::kVertical, plane.id});
        }
        return out;
      },
      [&](const VioEstimator& estimator) {
        int num_true = 0, num_false = 0;
        for (const WindowRelation& relation : estimator.window().relations) {
          const auto surface = static_cast<std::size_t>(relation.relation.a.value);
          const bool is_flat = std::abs(TheRun().surfaces[surface].n_W.z()) > 0.5;
          const bool says_flat = relation.relation.kind == PlaneRelationKind::kHorizontal;
          ++(is_flat == says_flat ? num_true : num_false);
        }
        most_true = std::max(most_true, num_true);
        most_false = std::max(most_false, num_false);
      });
  EXPECT_GE(most_true, 3);
  EXPECT_EQ(most_false, 0);
}

TEST(PlaneLifeTest, LandmarksOfPipelineSP) {
  EstimatorOptions options;
  options.calibration = CalibrationOptions::Held();
  int most = 0;
  const auto project = [](const VioEstimator& estimator) {
    PlaneAssignments out;
    for (const PlaneAttachment& join : TruePlanes(estimator).attached) {
      if (join.plane.value < 3) out.projected.push_back(join.landmark);
    }
    return out;
  };
  const auto count = [&](const VioEstimator& estimator) {
    int n = 0;
    for (const WindowLandmark& landmark : estimator.window().landmarks())
      n += landmark.is_projection;
    EXPECT_TRUE(estimator.window().planes.empty());
    most = std::max(most, n);
  };
  const auto sp = Estimate(options, project, count);
  EXPECT_GT(most, 20);
  EXPECT_EQ(sp.back().status, TrackingStatus::kOk);
  const auto s = Estimate(options, Nothing, DoNotWatch);
  EXPECT_FALSE(SameBits(s, sp));
  // The noise counts: weighing these landmarks like the others, without limit, is almost S.
  options.projection.sigma_px = 0.5;
  options.projection.tukey_sigma = 1e3;
  const auto as_s = Estimate(options, project, count);
  const auto distance = [&](const std::vector<EstimatorResult>& a) {
    return (a.back().state.T_WB.p - s.back().state.T_WB.p).norm();
  };
  EXPECT_LT(distance(as_s), 0.5 * distance(sp));
}

}  // namespace
}  // namespace facet
