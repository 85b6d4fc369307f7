// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/feature_simulator.h"

#include <set>

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/imu/imu_buffer.h"
#include "facet/imu/preintegration.h"
#include "facet/sim/euroc_csv.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/data_dir.h"

namespace facet {
namespace {

FeatureSimulatorOptions Perfect() {
  FeatureSimulatorOptions options;
  options.add_pixel_noise = false;
  options.imu.add_noise = false;
  return options;
}

SimulatedRun Simulate(const FeatureSimulatorOptions& options,
                      std::uint64_t seed,
                      double duration = 12) {
  return SimulateFeatures(
      SplineTrajectory::Fit(MakeFlight(duration, 4)), EurocRig(), options, seed);
}

/// Deviation of an observation from the projection of the true landmark.
Vector2d PixelError(const SimulatedRun& run,
                    std::size_t i,
                    int camera,
                    const FeatureObservation& f) {
  const SE3 T_WC = run.truth[i].T_WB * run.rig.T_BC[camera];
  const auto px =
      run.rig.cameras[camera].Project(T_WC.Inverse() * run.landmarks.at(f.landmark).p_W);
  return (camera ? *f.px_right : f.px_left) - px.value();
}

TEST(FeatureSimulatorTest, WithoutNoiseObservationsAreExact) {
  const SimulatedRun run = Simulate(Perfect(), 1);
  int right = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    EXPECT_EQ(run.frames[i].is_keyframe, i % 4 == 0);
    for (const FeatureObservation& f : run.frames[i].features) {
      ASSERT_LT(PixelError(run, i, 0, f).norm(), 1e-9);
      if (!f.px_right) continue;
      ASSERT_TRUE(run.frames[i].is_keyframe);
      ASSERT_LT(PixelError(run, i, 1, f).norm(), 1e-9);
      ++right;
    }
  }
  EXPECT_GT(right, 100 * static_cast<int>(run.frames.size()) / 4);
}

TEST(FeatureSimulatorTest, LandmarksLieOnTheirSurfaces) {
  const SimulatedRun run = Simulate(Perfect(), 2);
  std::set<PlaneId> seen;
  for (const auto& [id, landmark] : run.landmarks) {
    const Surface& s = run.surfaces.at(landmark.surface.value);
    EXPECT_EQ(s.id, landmark.surface);
    EXPECT_NEAR(s.n_W.dot(landmark.p_W), s.d_W(), 1e-9);
    EXPECT_LT(std::abs((landmark.p_W - s.center_W).dot(s.u_W)), s.half_u + 1e-9);
    seen.insert(s.id);
  }
  EXPECT_GE(seen.size(), 6u);
  EXPECT_GT(run.surfaces.size(), 10u);
}

TEST(FeatureSimulatorTest, LandmarksStandOutFromRoughSurfaces) {
  FeatureSimulatorOptions options = Perfect();
  options.roughness_m = 0.02;
  const SimulatedRun run = Simulate(options, 2);
  double sum = 0, square = 0;
  for (const auto& [id, landmark] : run.landmarks) {
    const Surface& s = run.surfaces.at(landmark.surface.value);
    const double height = s.n_W.dot(landmark.p_W) - s.d_W();
    EXPECT_GT(height, -1e-9);
    sum += height;
    square += height * height;
  }
  const double mean = sum / static_cast<double>(run.landmarks.size());
  const double variance = square / static_cast<double>(run.landmarks.size()) - mean * mean;
  EXPECT_NEAR(mean, std::sqrt(3) * options.roughness_m, 0.1 * options.roughness_m);
  EXPECT_NEAR(std::sqrt(variance), options.roughness_m, 0.1 * options.roughness_m);
}

// Noise-free samples joined over the whole run end where the trajectory ends, up to the error of
// the midpoint rule.
TEST(FeatureSimulatorTest, ImuWithoutNoiseReproducesTheTruth) {
  FeatureSimulatorOptions options = Perfect();
  options.imu.noise.rate_hz = 1000;
  const SimulatedRun run = Simulate(options, 3);
  ImuBuffer buffer;
  for (const ImuSample& sample : run.imu) {
    EXPECT_EQ(buffer.Add(sample), ImuBuffer::AddResult::kAdded);
  }
  const std::size_t last = 200;  // 10 s
  const ImuInterval interval =
      buffer.Between(run.truth[0].t, run.truth[last].t, Duration{20'000'000}, Duration{0});
  ASSERT_FALSE(interval.samples.empty());
  ImuPreintegration preintegration(run.truth[0].bias, {});
  preintegration.Integrate(interval.samples);
  const NavState end = preintegration.Predict(run.truth[0]);
  EXPECT_NEAR(ToSeconds(end.t - run.truth[0].t), 10.0, 1e-6);
  EXPECT_LT((end.T_WB.p - run.truth[last].T_WB.p).norm(), 1e-3);
  EXPECT_LT(LogSO3(end.T_WB.q.conjugate() * run.truth[last].T_WB.q).norm(), 1e-5);
}

TEST(FeatureSimulatorTest, NoiseHasTheSizeThatTheObservationsSay) {
  FeatureSimulatorOptions options;
  options.pixel_sigma = 0.7;
  const SimulatedRun run = Simulate(options, 4);
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    for (const FeatureObservation& f : run.frames[i].features) {
      EXPECT_EQ(f.sigma_left_px, 0.7);
      squares += PixelError(run, i, 0, f).squaredNorm();
      count += 2;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.7, 0.01);
}

TEST(FeatureSimulatorTest, OutliersHaveTheirShare) {
  FeatureSimulatorOptions options;
  options.outlier_share = 0.1;
  const SimulatedRun run = Simulate(options, 5);
  int outliers = 0, count = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    for (const FeatureObservation& f : run.frames[i].features) {
      outliers += PixelError(run, i, 0, f).norm() > 2.5;
      ++count;
    }
  }
  EXPECT_NEAR(static_cast<double>(outliers) / count, 0.1 * 17.5 / 18.5, 0.015);
}

TEST(FeatureSimulatorTest, TracksImitateAFrontEnd) {
  const FeatureSimulatorOptions options;
  const SimulatedRun run = Simulate(options, 6);
  std::unordered_map<LandmarkId, std::vector<std::int64_t>> frames_of;
  double sum = 0;
  for (const FrameObservations& frame : run.frames) {
    EXPECT_LE(static_cast<int>(frame.features.size()), options.max_tracks);
    if (frame.is_keyframe) sum += static_cast<double>(frame.features.size());
    std::set<LandmarkId> ids;
    for (const FeatureObservation& f : frame.features) {
      EXPECT_TRUE(ids.insert(f.landmark).second) << "seen twice in one frame";
      frames_of[f.landmark].push_back(frame.frame.value);
    }
  }
  EXPECT_GT(sum / (static_cast<double>(run.frames.size()) / 4), 120) << "mean tracks on keyframes";
  double life = 0;
  for (const auto& [id, frames] : frames_of) {
    EXPECT_EQ(frames.back() - frames.front() + 1, static_cast<std::int64_t>(frames.size()))
        << "a lost track came back under its old id";
    life += static_cast<double>(frames.size()) / options.frame_rate_hz;
  }
  life /= static_cast<double>(frames_of.size());
  EXPECT_GT(life, 0.4);
  EXPECT_LT(life, 1.05);
}

TEST(FeatureSimulatorTest, SeedsRepeatAndDiffer) {
  const FeatureSimulatorOptions options;
  const SimulatedRun a = Simulate(options, 7, 4), b = Simulate(options, 7, 4),
                     c = Simulate(options, 8, 4);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  EXPECT_EQ(a.frames.size(), c.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    ASSERT_EQ(a.frames[i].features.size(), b.frames[i].features.size());
    for (std::size_t k = 0; k < a.frames[i].features.size(); ++k) {
      ASSERT_EQ(a.frames[i].features[k].landmark, b.frames[i].features[k].landmark);
      ASSERT_EQ(a.frames[i].features[k].px_left, b.frames[i].features[k].px_left);
    }
  }
  EXPECT_EQ(a.imu.back().accel, b.imu.back().accel);
  EXPECT_NE(a.imu.back().accel, c.imu.back().accel);
  EXPECT_NE(a.truth[0].bias.b_g, c.truth[0].bias.b_g);
  EXPECT_NE(a.surfaces[0].half_u, c.surfaces[0].half_u);
  EXPECT_NE(a.frames[0].features[0].px_left, c.frames[0].features[0].px_left);
  EXPECT_EQ(a.truth[5].T_WB.p, c.truth[5].T_WB.p) << "the trajectory is given";
}

TEST(FeatureSimulatorTest, StampsFollowTheClocks) {
  StereoRig rig = EurocRig();
  rig.time_offset = Duration{3'000'000};
  FeatureSimulatorOptions options;
  options.duration_s = 2;
  options.start_s = 1;
  const SplineTrajectory trajectory = SplineTrajectory::Fit(MakeFlight(6, 1));
  const SimulatedRun run = SimulateFeatures(trajectory, rig, options, 1);
  ASSERT_EQ(run.frames.size(), 41u);
  EXPECT_EQ(run.truth.size(), run.frames.size());
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    EXPECT_EQ(run.truth[i].t, run.frames[i].t + rig.time_offset);
  }
  EXPECT_LT(run.imu.front().t, run.truth.front().t);
  EXPECT_GT(run.imu.back().t, run.truth.back().t);
}

TEST(FeatureSimulatorTest, NothingIsSeenThroughBoxesAndBoards) {
  const SimulatedRun run = Simulate(Perfect(), 9);
  for (std::size_t i = 0; i < run.frames.size(); i += 20) {
    const Vector3d from_W = (run.truth[i].T_WB * run.rig.T_BC[0]).p;
    for (const FeatureObservation& f : run.frames[i].features) {
      const Vector3d p_W = run.landmarks.at(f.landmark).p_W;
      for (const Surface& s : run.surfaces) {
        const double a = s.n_W.dot(from_W) - s.d_W(), b = s.n_W.dot(p_W) - s.d_W();
        if (a * b > 0 || std::abs(b) < 1e-6) continue;
        const Vector3d crossing = from_W + a / (a - b) * (p_W - from_W) - s.center_W;
        EXPECT_TRUE(std::abs(crossing.dot(s.u_W)) > s.half_u - 1e-6 ||
                    std::abs(crossing.dot(s.v_W)) > s.half_v - 1e-6);
      }
    }
  }
}

TEST(FeatureSimulatorTest, WorksAlongARealFlight) {
  const auto folder = testing::DataDir("euroc_flights/V1_01_easy");
  if (!folder) GTEST_SKIP() << testing::MissingData("euroc_flights/V1_01_easy");
  const auto trajectory = SplineTrajectory::Fit(LoadGroundTruthCsv(*folder / "groundtruth.csv"));
  FeatureSimulatorOptions options;
  options.start_s = 20;
  options.duration_s = 20;
  const SimulatedRun run = SimulateFeatures(trajectory, EurocRig(), options, 1);
  ASSERT_EQ(run.frames.size(), 401u);
  for (const FrameObservations& frame : run.frames)
    EXPECT_GT(frame.features.size(), 60u);
}

}  // namespace
}  // namespace facet
