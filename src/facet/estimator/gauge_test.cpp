// SPDX-License-Identifier: BSD-2-Clause
// Stereo and IMU say nothing about the position of everything and its heading. The prior must not
// gain information there, however often something is marginalised (docs/math.md, section 5.3).
#include <algorithm>
#include <iostream>
#include <map>
#include <optional>
#include <set>

#include <gtest/gtest.h>

#include "facet/estimator/factors/prior_factor.h"
#include "facet/estimator/planes/plane_anchor.h"
#include "facet/estimator/solver/marginalization.h"
#include "facet/estimator/solver/window_solver.h"
#include "facet/estimator/window/landmark_depth.h"
#include "facet/estimator/window/window_policy.h"
#include "facet/geometry/plane_fit.h"
#include "facet/imu/imu_buffer.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/test_gauge.h"
#include "facet/testing/estimator/test_window.h"

namespace facet {
namespace {

using testing::GaugeDirections;
using testing::WindowDirections;

constexpr double kWidth = 10.0;
constexpr int kStartKeyframes = 10;
constexpr double kAnchorDistance = 0.3;  // [m]; small, so that anchors move often
constexpr std::size_t kReplaceEvery = 25;

enum class Planes {
  kNone,
  kKept,     ///< one for each true surface, for the whole run
  kSighted,  ///< the same, and every keyframe that sees one sights it
  kRelated,  ///< related to each other and to gravity, re-anchored, one of them replaced at times
};

/// Fixed-lag smoothing of keyframes alone: what VioEstimator does, without its start and its
/// exceptions.
class KeyframeSmoother {
 public:
  /// With `first_estimates` false the prior follows the estimate, and with it all Jacobians.
  KeyframeSmoother(const SimulatedRun& run, bool first_estimates, Planes planes)
      : run_(run),
        first_estimates_(first_estimates),
        planes_(planes),
        solver_(run.rig, SolverOptions{}),
        geometry_(run.rig) {
    window_.T_BC0 = run.rig.T_BC[0];
    for (const ImuSample& sample : run.imu)
      imu_.Add(sample);
  }

  void Process(std::size_t i, Rng& rng) {
    AppendFrame(i, rng);
    AppendObservations(run_.frames[i]);
    geometry_.Update(window_.frames);
    InitializeDepths(geometry_, window_);
    if (planes_ != Planes::kNone) TieToSurfaces();
    if (planes_ == Planes::kSighted) SightPlanes(rng);
    if (planes_ == Planes::kRelated) {
      RelatePlanes();
      num_moved_anchors_ += FollowSupport(kAnchorDistance, window_);
    }
    FollowEstimate();
    solver_.Solve(window_, FactorNoise(EstimatorOptions{}), i < kStartKeyframes ? 15 : 4);
    FollowEstimate();
    if (i < kStartKeyframes) return;
    while (true) {
      MarginalizationPlan plan = PlanMarginalization(window_, WindowOptions{});
      if (plan.IsEmpty()) return;
      if (planes_ == Planes::kRelated && i % kReplaceEvery == 0) ReplaceAPlane(i, plan);
      num_relations_used_ += static_cast<int>(window_.relations.size());
      Marginalize(plan, run_.rig, testing::NoiseOfWidth(kWidth), window_);
      num_relations_used_ -= static_cast<int>(window_.relations.size());
      ++num_marginalizations_;
    }
  }

  const SlidingWindow& window() const { return window_; }
  int num_marginalizations() const { return num_marginalizations_; }
  int num_moved_anchors() const { return num_moved_anchors_; }
  int num_relations_used() const { return num_relations_used_; }
  int num_sightings() const { return num_sightings_; }

 private:
  void AppendFrame(std::size_t i, Rng& rng) {
    WindowFrame frame;
    frame.id = run_.frames[i].frame;
    frame.is_keyframe = true;
    if (i == 0) {
      frame.x =
          testing::Retract(run_.truth[0], testing::RandomStep({0.01, 0, 0.05, 0.005, 0.05}, rng));
      frame.x.t = run_.truth[0].t;
      window_.start_prior.emplace(frame.id, frame.x.T_WB, StartOptions{});
    } else {
      const NavState& last = window_.frames.back().x;
      ImuPreintegration measured(last.bias, PreintegrationNoise{});
      measured.Integrate(
          imu_.Between(last.t, run_.truth[i].t, Duration{20'000'000}, Duration{0}).samples);
      frame.x = measured.Predict(last);
      frame.imu_link = ImuLink{measured, ImuSqrtInfo(measured, testing::DefaultBiasWalk())};
    }
    frame.lin = frame.x;
    window_.frames.push_back(std::move(frame));
  }

  void AppendObservations(const FrameObservations& observations) {
    const int newest = static_cast<int>(window_.frames.size()) - 1;
    for (const FeatureObservation& feature : observations.features) {
      WindowObservation o;
      o.frame = newest;
      o.has_right = feature.px_right.has_value();
      for (int c = 0; c < (o.has_right ? 2 : 1); ++c) {
        const Vector2d px = c == 0 ? feature.px_left : *feature.px_right;
        const UndistortedPoint point = run_.rig.cameras[c].Undistort(px).value();
        o.xy[c] = point.xy;
        o.sigma_px[c] = feature.sigma_left_px;
        o.sqrt_info[c] = point.J_xy_px.inverse() / feature.sigma_left_px;
      }
      WindowLandmark* landmark = window_.Find(feature.landmark);
      if (landmark == nullptr) landmark = &window_.AddLandmark(feature.landmark, newest);
      landmark->observations.push_back(o);
    }
  }

  // Every landmark lies on the plane of its true surface; when planes are related, on one of two
  // planes of the same surface.
  PlaneId PlaneOf(LandmarkId landmark) {
    const PlaneId surface = run_.landmarks.at(landmark).surface;
    if (planes_ != Planes::kRelated) return surface;
    const std::int64_t half = 2 * surface.value + landmark.value % 2;
    return PlaneId{generation_[half] * 1000 + half};
  }
  PlaneId SurfaceOf(PlaneId plane) const {
    return planes_ == Planes::kRelated ? PlaneId{plane.value % 1000 / 2} : plane;
  }

  void TieToSurfaces() {
    std::map<PlaneId, std::vector<WindowLandmark*>> by_plane;
    for (WindowLandmark& landmark : window_.landmarks()) {
      if (landmark.has_depth && landmark.observations.size() > 2)
        by_plane[PlaneOf(landmark.id)].push_back(&landmark);
    }
    for (auto& [plane, members] : by_plane) {
      if (window_.IndexOf(plane) < 0) {
        std::vector<Vector3d> points_W;
        for (const WindowLandmark* landmark : members)
          points_W.push_back(window_.PositionOf(*landmark));
        const PlaneFit fit = FitPlane(points_W);
        const std::size_t min_members = planes_ == Planes::kRelated ? 8 : 15;
        if (members.size() < min_members || fit.extent_minor_m < 0.3) continue;
        window_.planes.emplace_back(plane, fit.plane, fit.centroid, testing::kPlaneSigma_m);
      }
      for (WindowLandmark* landmark : members)
        landmark->planes.Add(window_.IndexOf(plane));
    }
  }

  // The newest frame measures the planes whose landmarks it sees.
  void SightPlanes(Rng& rng) {
    const int newest = static_cast<int>(window_.frames.size()) - 1;
    std::set<int> seen;
    for (const WindowLandmark& landmark : window_.landmarks()) {
      if (!landmark.IsOnPlanes() || landmark.observations.back().frame != newest) continue;
      const int k = landmark.planes[0];
      if (!seen.insert(k).second) continue;
      window_.sightings.push_back(testing::MakeSighting(
          window_.frames.back(), window_.planes[k], window_.PositionOf(landmark), 1, rng));
      ++num_sightings_;
    }
  }

  // True relations between the planes that exist, as stars around the first plane of their kind.
  void RelatePlanes() {
    using enum PlaneRelationKind;
    std::optional<PlaneId> first_flat, first_wall;
    for (const WindowPlane& plane : window_.planes) {
      const Vector3d& n = run_.surfaces[static_cast<std::size_t>(SurfaceOf(plane.id).value)].n_W;
      const bool is_flat = std::abs(n.z()) > 0.99, is_wall = std::abs(n.z()) < 0.01;
      for (const WindowPlane& other : window_.planes) {
        if (other.id < plane.id && SurfaceOf(other.id) == SurfaceOf(plane.id))
          window_.AddRelation({kCoplanar, plane.id, other.id});
      }
      std::optional<PlaneId>& first = is_flat ? first_flat : first_wall;
      if (is_flat) window_.AddRelation({kHorizontal, plane.id});
      if (is_wall) window_.AddRelation({kVertical, plane.id});
      if (first && (is_flat || is_wall)) Relate(*first, plane.id, is_flat);
      if (!first && (is_flat || is_wall)) first = plane.id;
      if (is_wall && first_flat) window_.AddRelation({kOrthogonal, plane.id, *first_flat});
    }
  }

  void Relate(PlaneId first, PlaneId plane, bool is_flat) {
    using enum PlaneRelationKind;
    const auto normal = [&](PlaneId id) {
      return run_.surfaces[static_cast<std::size_t>(SurfaceOf(id).value)].n_W;
    };
    const double cosine = std::abs(normal(first).dot(normal(plane)));
    if (cosine > 0.999) {
      window_.AddRelation({kParallel, first, plane});
      if (!is_flat) window_.AddRelation({kHeadingParallel, first, plane});
    } else if (cosine < 0.001) {
      window_.AddRelation({kHeadingOrthogonal, first, plane});
    }
  }

  // One plane that the prior knows leaves with its relations; another takes its place.
  void ReplaceAPlane(std::size_t i, MarginalizationPlan& plan) {
    const auto n = static_cast<std::size_t>(window_.planes.size());
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t plane = (i + k) % n;
      if (!window_.planes[plane].frozen) continue;
      plan.drop_plane[plane] = 1;
      ++generation_[window_.planes[plane].id.value % 1000];
      return;
    }
  }

  // Moves the linearisation point of the prior to the estimate: the same quadratic, other
  // Jacobians.
  void FollowEstimate() {
    if (first_estimates_ || window_.prior.dim() == 0) return;
    window_.prior.b += window_.prior.H * PriorDelta(window_);
    for (WindowFrame& frame : window_.frames) {
      frame.lin = frame.x;
      frame.delta.setZero();
    }
  }

  const SimulatedRun& run_;
  bool first_estimates_;
  Planes planes_;
  ImuBuffer imu_;
  SlidingWindow window_;
  WindowSolver solver_;
  FrameGeometry geometry_;
  std::map<std::int64_t, std::int64_t> generation_;
  int num_marginalizations_ = 0, num_moved_anchors_ = 0, num_relations_used_ = 0;
  int num_sightings_ = 0;
};

MatrixXd PriorDirections(const SlidingWindow& window, const Vector3d& pivot_W) {
  MatrixXd N(window.prior.dim(), 4);
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    const Variable variable = window.VariableOf(block);
    if (variable.kind == Variable::Kind::kPlane) {
      N.middleRows<3>(block.offset) = GaugeDirections(window.planes[variable.index], pivot_W);
      continue;
    }
    const Matrix<15, 4> N_frame = GaugeDirections(window.frames[variable.index].lin, pivot_W);
    if (variable.kind == Variable::Kind::kMotion) {
      N.middleRows<9>(block.offset) = N_frame.bottomRows<9>();
    } else {
      N.middleRows<6>(block.offset) = N_frame.topRows<6>();
    }
  }
  return N;
}

Vector4d Energy(const MatrixXd& H, const MatrixXd& N) {
  return (N.transpose() * H * N).diagonal();
}

struct GaugeHistory {
  Vector4d first, last, largest;
  Vector4d gained =
      Vector4d::Zero();              ///< sum of all increases from one marginalisation to the next
  double largest_window_energy = 0;  ///< of the factors other than the prior
  double position_error = 0;         ///< at the end [m]
  int num_marginalizations = 0;
  int num_planes = 0;
  int num_relations = 0, num_relations_used = 0, num_moved_anchors = 0;
  int num_sightings = 0;
};

GaugeHistory RunSmoother(const SimulatedRun& run,
                         bool first_estimates,
                         int num_marginalizations,
                         Planes planes = Planes::kNone) {
  KeyframeSmoother smoother(run, first_estimates, planes);
  const Vector3d pivot_W = run.truth[0].T_WB.p;
  GaugeHistory history;
  Rng rng(5);
  bool has_prior = false;
  std::size_t i = 0;
  for (; i < run.frames.size() && smoother.num_marginalizations() < num_marginalizations; ++i) {
    smoother.Process(i, rng);
    const SlidingWindow& window = smoother.window();
    if (window.prior.dim() == 0) continue;
    const Vector4d energy = Energy(window.prior.H, PriorDirections(window, pivot_W));
    if (!has_prior) history.first = history.last = history.largest = energy;
    has_prior = true;
    history.gained += (energy - history.last).cwiseMax(0);
    history.last = energy;
    history.largest = history.largest.cwiseMax(energy);
    if (i % 20 == 0) {
      SlidingWindow without_prior = window;
      without_prior.prior = MarginalPrior();
      const MatrixXd H = testing::Assemble(without_prior, run.rig, kWidth).H;
      history.largest_window_energy = std::max(
          history.largest_window_energy, Energy(H, WindowDirections(window, pivot_W)).maxCoeff());
    }
  }
  history.num_marginalizations = smoother.num_marginalizations();
  history.num_planes = static_cast<int>(smoother.window().planes.size());
  history.num_relations = static_cast<int>(smoother.window().relations.size());
  history.num_relations_used = smoother.num_relations_used();
  history.num_sightings = smoother.num_sightings();
  history.num_moved_anchors = smoother.num_moved_anchors();
  history.position_error =
      (smoother.window().frames.back().x.T_WB.p - run.truth[i - 1].T_WB.p).norm();
  return history;
}

void Print(const char* name, const GaugeHistory& h) {
  std::cout << name << ": " << h.num_marginalizations << " marginalisations, position error "
            << h.position_error << " m\n  information (x y z yaw): first " << h.first.transpose()
            << ", largest " << h.largest.transpose() << ", last " << h.last.transpose()
            << "\n  gained in all " << h.gained.transpose() << ", window without prior "
            << h.largest_window_energy << '\n';
}

SimulatedRun Simulate() {
  FeatureSimulatorOptions options;
  options.frame_rate_hz = 5;
  options.keyframe_every = 1;
  options.max_tracks = 60;
  options.mean_track_life_s = 1.5;
  return SimulateFeatures(SplineTrajectory::Fit(MakeFlight(110, 3)), EurocRig(), options, 1);
}

// What drift leaves of the information on the origin: little without planes, which is the point of
// planes.
void ExpectNothingGained(const GaugeHistory& fixed, double left) {
  ASSERT_GE(fixed.num_marginalizations, 500);
  EXPECT_LT(fixed.position_error, 0.2);
  const StartOptions start;
  const double position = 1 / (start.sigma_position * start.sigma_position);
  const double yaw = 1 / (start.sigma_yaw * start.sigma_yaw);
  const Vector4d given(position, position, position, yaw);
  for (int k = 0; k < 4; ++k) {
    // Drift uses the information up, and nothing but rounding comes in against that.
    EXPECT_LT(fixed.largest(k), given(k) * (1 + 1e-6)) << k;
    EXPECT_LT(fixed.last(k), left * given(k)) << k;
    EXPECT_LT(fixed.gained(k), 1e-8 * given(k)) << k;
  }
  // Neither do the factors that are still in the window know anything.
  EXPECT_LT(fixed.largest_window_energy, 1e-3);
}

TEST(GaugeTest, ThePriorGainsNothingOver500Marginalizations) {
  const SimulatedRun run = Simulate();
  const GaugeHistory fixed = RunSmoother(run, true, 500);
  Print("first estimates", fixed);
  ExpectNothingGained(fixed, 0.2);

  // The counter-test: without first estimates the heading gains.
  const GaugeHistory following = RunSmoother(run, false, 500);
  Print("Jacobians at the estimate", following);
  EXPECT_GT(following.gained(3), 1.0);
}

TEST(GaugeTest, PlanesThatStayGainNothingEither) {
  const SimulatedRun run = Simulate();
  const GaugeHistory history = RunSmoother(run, true, 500, Planes::kKept);
  Print("with planes", history);
  EXPECT_GE(history.num_planes, 5);
  ExpectNothingGained(history, 0.9);
}

TEST(GaugeTest, NorDoTheirSightings) {
  const SimulatedRun run = Simulate();
  const GaugeHistory history = RunSmoother(run, true, 500, Planes::kSighted);
  Print("with sightings", history);
  EXPECT_GE(history.num_planes, 5);
  EXPECT_GE(history.num_sightings, 500);
  ExpectNothingGained(history, 0.95);
}

TEST(GaugeTest, NeitherDoRelatedPlanesWhoseAnchorsMove) {
  const SimulatedRun run = Simulate();
  const GaugeHistory history = RunSmoother(run, true, 500, Planes::kRelated);
  Print("with relations", history);
  std::cout << history.num_planes << " planes, " << history.num_relations << " relations and "
            << history.num_relations_used << " used up, " << history.num_moved_anchors
            << " moves of anchors\n";
  EXPECT_GE(history.num_planes, 8);
  EXPECT_GE(history.num_relations, 10);
  EXPECT_GE(history.num_relations_used, 20);
  EXPECT_GE(history.num_moved_anchors, 20);
  ExpectNothingGained(history, 0.98);
}

}  // namespace
}  // namespace facet
