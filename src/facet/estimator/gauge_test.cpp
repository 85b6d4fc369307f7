// SPDX-License-Identifier: BSD-2-Clause
// Stereo and IMU say nothing about the position of everything and its heading. The prior must not
// gain information there, however often something is marginalised (docs/math.md, section 5.3).
#include <algorithm>
#include <iostream>

#include <gtest/gtest.h>

#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"
#include "facet/testing/estimator/keyframe_smoother.h"
#include "facet/testing/estimator/test_gauge.h"

namespace facet {
namespace {

using testing::GaugeDirections;
using testing::SmootherPlanes;
using testing::WindowDirections;

constexpr double kWidth = 10.0;

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
  int num_measurements = 0;
};

GaugeHistory RunSmoother(const SimulatedRun& run,
                         bool first_estimates,
                         int num_marginalizations,
                         SmootherPlanes planes = SmootherPlanes::kNone) {
  testing::KeyframeSmoother smoother(run, first_estimates, planes);
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
  history.num_measurements = smoother.num_measurements();
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
  const GaugeHistory history = RunSmoother(run, true, 500, SmootherPlanes::kKept);
  Print("with planes", history);
  EXPECT_GE(history.num_planes, 5);
  ExpectNothingGained(history, 0.9);
}

TEST(GaugeTest, NorDoTheirMeasurements) {
  const SimulatedRun run = Simulate();
  const GaugeHistory history = RunSmoother(run, true, 500, SmootherPlanes::kMeasured);
  Print("with measurements", history);
  EXPECT_GE(history.num_planes, 5);
  EXPECT_GE(history.num_measurements, 500);
  ExpectNothingGained(history, 0.95);
}

TEST(GaugeTest, NeitherDoRelatedPlanesWhoseAnchorsMove) {
  const SimulatedRun run = Simulate();
  const GaugeHistory history = RunSmoother(run, true, 500, SmootherPlanes::kRelated);
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
