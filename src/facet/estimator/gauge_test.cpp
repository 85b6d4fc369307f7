// SPDX-License-Identifier: BSD-2-Clause
// Stereo and IMU say nothing about the position of everything and its heading. The prior must not
// gain information there, however often something is marginalised (docs/math.md, section 5.3).
#include <algorithm>
#include <iostream>
#include <map>

#include <gtest/gtest.h>

#include "facet/estimator/landmark_depth.h"
#include "facet/estimator/test_window.h"
#include "facet/estimator/window_policy.h"
#include "facet/estimator/window_solver.h"
#include "facet/geometry/plane_fit.h"
#include "facet/imu/imu_buffer.h"
#include "facet/sim/euroc_rig.h"
#include "facet/sim/feature_simulator.h"

namespace facet {
namespace {

constexpr double kHuber = 2.0;
constexpr int kStartKeyframes = 10;

/// Fixed-lag smoothing of keyframes alone: what VioEstimator does, without its start and its
/// exceptions.
class KeyframeSmoother {
 public:
  /// With `first_estimates` false the prior follows the estimate, and with it all Jacobians.
  KeyframeSmoother(const SimulatedRun& run, bool first_estimates, bool with_planes)
      : run_(run),
        first_estimates_(first_estimates),
        with_planes_(with_planes),
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
    for (WindowLandmark& landmark : window_.landmarks()) {
      if (!landmark.has_depth) InitializeDepth(geometry_, landmark);
    }
    if (with_planes_) TieToSurfaces();
    FollowEstimate();
    solver_.Solve(window_, i < kStartKeyframes ? 15 : 4);
    FollowEstimate();
    if (i < kStartKeyframes) return;
    while (true) {
      const MarginalizationPlan plan = PlanMarginalization(window_, WindowOptions{});
      if (plan.IsEmpty()) return;
      Marginalize(plan, run_.rig, RobustOptions{kHuber}, window_);
      ++num_marginalizations_;
    }
  }

  const SlidingWindow& window() const { return window_; }
  int num_marginalizations() const { return num_marginalizations_; }

 private:
  void AppendFrame(std::size_t i, Rng& rng) {
    WindowFrame frame;
    frame.id = run_.frames[i].frame;
    frame.is_keyframe = true;
    if (i == 0) {
      frame.x =
          testing::Retract(run_.truth[0], testing::RandomStep({0.01, 0, 0.05, 0.005, 0.05}, rng));
      frame.x.t = run_.truth[0].t;
      window_.start_prior = {true, frame.id, frame.x.T_WB};
    } else {
      const NavState& last = window_.frames.back().x;
      PreintegrationNoise noise;
      frame.imu = ImuPreintegration(last.bias, noise);
      frame.imu.Integrate(
          imu_.Between(last.t, run_.truth[i].t, Duration{20'000'000}, Duration{0}).samples);
      frame.imu_sqrt_info = ImuSqrtInfo(frame.imu, BiasWalk{});
      frame.has_imu_link = true;
      frame.x = frame.imu.Predict(last);
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
        o.sqrt_info[c] = point.J_xy_px.inverse() / feature.sigma_left_px;
      }
      WindowLandmark* landmark = window_.Find(feature.landmark);
      if (landmark == nullptr) landmark = &window_.AddLandmark(feature.landmark, newest);
      landmark->observations.push_back(o);
    }
  }

  // Every landmark lies on the plane of its true surface; the planes stay for the whole run.
  void TieToSurfaces() {
    std::map<PlaneId, std::vector<WindowLandmark*>> by_surface;
    for (WindowLandmark& landmark : window_.landmarks()) {
      if (landmark.has_depth && landmark.observations.size() > 2)
        by_surface[run_.landmarks.at(landmark.id).surface].push_back(&landmark);
    }
    for (auto& [surface, members] : by_surface) {
      if (window_.IndexOf(surface) < 0) {
        std::vector<Vector3d> points_W;
        for (const WindowLandmark* landmark : members)
          points_W.push_back(window_.PositionOf(*landmark));
        const PlaneFit fit = FitPlane(points_W);
        if (members.size() < 15 || fit.extent_minor_m < 0.3) continue;
        window_.planes.emplace_back(surface, fit.plane, fit.centroid);
      }
      for (WindowLandmark* landmark : members)
        landmark->planes.Add(window_.IndexOf(surface));
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
  bool first_estimates_, with_planes_;
  ImuBuffer imu_;
  SlidingWindow window_;
  WindowSolver solver_;
  FrameGeometry geometry_;
  int num_marginalizations_ = 0;
};

// Columns: translation x y z, turn about the vertical through `pivot_W`; (5.3) and (5.4) of
// docs/math.md.
Matrix<15, 4> GaugeDirections(const NavState& x, const Vector3d& pivot_W) {
  Matrix<15, 4> N = Matrix<15, 4>::Zero();
  const Vector3d e_z = Vector3d::UnitZ();
  N.block<3, 3>(3, 0) = Matrix3d::Identity();
  N.block<3, 1>(0, 3) = x.T_WB.q.conjugate() * e_z;
  N.block<3, 1>(3, 3) = e_z.cross(x.T_WB.p - pivot_W);
  N.block<3, 1>(6, 3) = e_z.cross(x.v_WB);
  return N;
}

// Of a plane: two tangent directions of the normal, offset.
Matrix<3, 4> GaugeDirections(const WindowPlane& plane, const Vector3d& pivot_W) {
  Matrix<3, 4> N = Matrix<3, 4>::Zero();
  const Vector3d turn = Vector3d::UnitZ().cross(plane.n_lin);
  N.block<1, 3>(2, 0) = plane.n_lin.transpose();
  N.block<2, 1>(0, 3) = TangentBasis(plane.n_lin).transpose() * turn;
  N(2, 3) = turn.dot(pivot_W - plane.anchor_W);
  return N;
}

MatrixXd PriorDirections(const SlidingWindow& window, const Vector3d& pivot_W) {
  MatrixXd N(window.prior.dim(), 4);
  for (const MarginalPrior::Block& block : window.prior.blocks) {
    if (block.IsPlane()) {
      N.middleRows<3>(block.offset) =
          GaugeDirections(window.planes[window.IndexOf(block.plane)], pivot_W);
      continue;
    }
    const Matrix<15, 4> N_frame =
        GaugeDirections(window.frames[window.IndexOf(block.frame)].lin, pivot_W);
    if (block.is_motion) {
      N.middleRows<9>(block.offset) = N_frame.bottomRows<9>();
    } else {
      N.middleRows<6>(block.offset) = N_frame.topRows<6>();
    }
  }
  return N;
}

MatrixXd WindowDirections(const SlidingWindow& window, const Vector3d& pivot_W) {
  const StateLayout layout = MakeLayout(window);
  MatrixXd N(layout.dim, 4);
  for (std::size_t k = 0; k < window.planes.size(); ++k)
    N.middleRows<3>(layout.plane_column[k]) = GaugeDirections(window.planes[k], pivot_W);
  for (std::size_t i = 0; i < window.frames.size(); ++i) {
    const Matrix<15, 4> N_frame = GaugeDirections(window.frames[i].lin, pivot_W);
    N.middleRows<6>(layout.pose_column[i]) = N_frame.topRows<6>();
    if (window.frames[i].has_motion)
      N.middleRows<9>(layout.motion_column[i]) = N_frame.bottomRows<9>();
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
};

GaugeHistory RunSmoother(const SimulatedRun& run,
                         bool first_estimates,
                         int num_marginalizations,
                         bool with_planes = false) {
  KeyframeSmoother smoother(run, first_estimates, with_planes);
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
      const MatrixXd H = testing::Assemble(without_prior, run.rig, kHuber).H;
      history.largest_window_energy = std::max(
          history.largest_window_energy, Energy(H, WindowDirections(window, pivot_W)).maxCoeff());
    }
  }
  history.num_marginalizations = smoother.num_marginalizations();
  history.num_planes = static_cast<int>(smoother.window().planes.size());
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
  const StartPrior start;
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
  const GaugeHistory history = RunSmoother(run, true, 500, true);
  Print("with planes", history);
  EXPECT_GE(history.num_planes, 5);
  ExpectNothingGained(history, 0.9);
}

}  // namespace
}  // namespace facet
