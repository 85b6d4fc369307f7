// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/estimator/keyframe_smoother.h"

#include <optional>
#include <set>

#include "facet/estimator/factors/prior_factor.h"
#include "facet/estimator/planes/plane_anchor.h"
#include "facet/estimator/solver/marginalization.h"
#include "facet/estimator/window/frame_observations.h"
#include "facet/estimator/window/landmark_depth.h"
#include "facet/estimator/window/window_policy.h"
#include "facet/geometry/plane_fit.h"

namespace facet::testing {

namespace {

constexpr double kPriorWidth = 10.0;  // of the loss of reprojections that go into the prior
constexpr int kStartKeyframes = 10;
constexpr double kAnchorDistance = 0.3;  // [m]; small, so that anchors move often
constexpr std::size_t kReplaceEvery = 25;

}  // namespace

KeyframeSmoother::KeyframeSmoother(const SimulatedRun& run,
                                   bool first_estimates,
                                   SmootherPlanes planes)
    : run_(run),
      first_estimates_(first_estimates),
      planes_(planes),
      window_(run.rig.T_BC[0]),
      solver_(run.rig, SolverOptions{}),
      noise_(EstimatorOptions{}),
      geometry_(run.rig) {
  for (const ImuSample& sample : run.imu)
    imu_.Add(sample);
}

void KeyframeSmoother::Process(std::size_t i, Rng& rng) {
  AppendFrame(i, rng);
  AppendObservations(PrepareObservations(run_.frames[i], run_.rig, 1.0), window_);
  geometry_.Update(window_.frames);
  InitializeDepths(geometry_, window_);
  if (planes_ != SmootherPlanes::kNone) TieToSurfaces();
  if (planes_ == SmootherPlanes::kMeasured) MeasurePlanes(rng);
  if (planes_ == SmootherPlanes::kRelated) {
    RelatePlanes();
    num_moved_anchors_ += FollowLandmarks(kAnchorDistance, window_);
  }
  FollowEstimate();
  solver_.Solve(window_, noise_, i < kStartKeyframes ? 15 : 4);
  FollowEstimate();
  if (i < kStartKeyframes) return;
  while (true) {
    MarginalizationPlan plan = PlanMarginalization(window_, WindowOptions{});
    if (plan.IsEmpty()) return;
    if (planes_ == SmootherPlanes::kRelated && i % kReplaceEvery == 0) ReplaceAPlane(i, plan);
    num_relations_used_ += static_cast<int>(window_.relations.size());
    Marginalize(plan, run_.rig, NoiseOfWidth(kPriorWidth), window_);
    num_relations_used_ -= static_cast<int>(window_.relations.size());
    ++num_marginalizations_;
  }
}

void KeyframeSmoother::AppendFrame(std::size_t i, Rng& rng) {
  WindowFrame frame;
  frame.id = run_.frames[i].frame;
  frame.is_keyframe = true;
  if (i == 0) {
    frame.x = Retract(run_.truth[0], RandomStep({0.01, 0, 0.05, 0.005, 0.05}, rng));
    frame.x.t = run_.truth[0].t;
    window_.start_prior.emplace(frame.id, frame.x.T_WB, StartOptions{});
  } else {
    const NavState& last = window_.frames.back().x;
    ImuPreintegration measured(last.bias, ImuParameters{});
    measured.Integrate(
        imu_.Between(last.t, run_.truth[i].t, Duration{20'000'000}, Duration{0}).samples);
    frame.x = measured.Predict(last);
    frame.imu_link = ImuLink{measured, ImuSqrtInfo(measured, DefaultBiasWalk())};
  }
  frame.lin = frame.x;
  window_.frames.push_back(std::move(frame));
}

// Every landmark lies on the plane of its true surface; when planes are related, on one of two
// planes of the same surface.
PlaneId KeyframeSmoother::PlaneOf(LandmarkId landmark) {
  const PlaneId surface = run_.landmarks.at(landmark).surface;
  if (planes_ != SmootherPlanes::kRelated) return surface;
  const std::int64_t half = 2 * surface.value + landmark.value % 2;
  return PlaneId{generation_[half] * 1000 + half};
}

PlaneId KeyframeSmoother::SurfaceOf(PlaneId plane) const {
  return planes_ == SmootherPlanes::kRelated ? PlaneId{plane.value % 1000 / 2} : plane;
}

void KeyframeSmoother::TieToSurfaces() {
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
      const std::size_t min_members = planes_ == SmootherPlanes::kRelated ? 8 : 15;
      if (members.size() < min_members || fit.extent_minor_m < 0.3) continue;
      window_.planes.emplace_back(plane, fit.plane, fit.centroid, kPlaneSigma_m);
    }
    for (WindowLandmark* landmark : members)
      landmark->planes.Add(window_.IndexOf(plane));
  }
}

// The newest frame measures the planes whose landmarks it sees.
void KeyframeSmoother::MeasurePlanes(Rng& rng) {
  const int newest = static_cast<int>(window_.frames.size()) - 1;
  std::set<int> seen;
  for (const WindowLandmark& landmark : window_.landmarks()) {
    if (!landmark.IsOnPlanes() || landmark.observations.back().frame != newest) continue;
    const int k = landmark.planes[0];
    if (!seen.insert(k).second) continue;
    window_.measurements.push_back(MakeMeasurement(
        window_.frames.back(), window_.planes[k], window_.PositionOf(landmark), 1, rng));
    ++num_measurements_;
  }
}

// True relations between the planes that exist, as stars around the first plane of their kind.
void KeyframeSmoother::RelatePlanes() {
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

void KeyframeSmoother::Relate(PlaneId first, PlaneId plane, bool is_flat) {
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
void KeyframeSmoother::ReplaceAPlane(std::size_t i, MarginalizationPlan& plan) {
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
void KeyframeSmoother::FollowEstimate() {
  if (first_estimates_ || window_.prior.dim() == 0) return;
  window_.prior.b += window_.prior.H * PriorDelta(window_);
  for (WindowFrame& frame : window_.frames) {
    frame.lin = frame.x;
    frame.delta.setZero();
  }
}

}  // namespace facet::testing
