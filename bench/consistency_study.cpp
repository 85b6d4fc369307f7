// SPDX-License-Identifier: BSD-2-Clause
#include "consistency_study.h"

#include <cmath>
#include <cstdio>

#include <Eigen/Cholesky>

#include "facet/eval/trajectory_error.h"

namespace facet {

namespace {

constexpr std::array<double, 6> kConvergenceTimes_s = {0.0, 0.5, 1.0, 2.0, 5.0, 10.0};
constexpr double kHalfFrame_s = 0.025;

template <int N>
double Ratio(const Vector<N>& error, const Matrix<N, N>& covariance) {
  return error.dot(covariance.ldlt().solve(error)) / N;
}

// Tilt is the horizontal part of the rotation seen in the world.
struct Tilt {
  explicit Tilt(const FrameError& f)
      : error((f.R_WB * f.error.head<3>()).template head<2>()),
        covariance((f.R_WB * f.covariance.topLeftCorner<3, 3>() * f.R_WB.transpose())
                       .template topLeftCorner<2, 2>()) {}
  Vector<2> error;
  Matrix<2, 2> covariance;
};

std::size_t TimeBin(double elapsed_s) {
  std::size_t bin = 0;
  while (bin < kTimeBounds_s.size() && elapsed_s >= kTimeBounds_s[bin])
    ++bin;
  return bin;
}

void AddToTable(const ConsistencyRun& run, NeesTable& table) {
  MeanRatios of_run;
  for (const FrameError& frame : run.frames) {
    const NeesRatios ratios = ComputeNeesRatios(frame);
    const std::size_t kind = frame.is_keyframe ? 0 : 1;
    table.by_time[TimeBin(frame.elapsed_s)][kind].Add(ratios);
    table.all.Add(ratios);
    of_run.Add(ratios);
  }
  table.pose_by_run.push_back(of_run[StatePart::kPose]);
}

void AddConvergence(const ConsistencyRun& run, std::vector<ConvergenceRow>& rows) {
  for (ConvergenceRow& row : rows) {
    for (const FrameError& frame : run.frames) {
      if (std::abs(frame.elapsed_s - row.elapsed_s) >= kHalfFrame_s) continue;
      const Tilt tilt(frame);
      row.tilt_square += tilt.error.squaredNorm();
      row.tilt_variance += tilt.covariance.trace();
      row.gyro_square += frame.error.segment<3>(9).squaredNorm();
      row.gyro_variance += frame.covariance.block<3, 3>(9, 9).trace();
      row.accel_square += frame.error.segment<3>(12).squaredNorm();
      row.accel_variance += frame.covariance.block<3, 3>(12, 12).trace();
      ++row.count;
      break;
    }
  }
}

double Ate(const std::vector<StampedPose>& poses, const std::vector<StampedPose>& truth) {
  return EvaluateTrajectory(poses, truth).ate_m.rmse;
}

void AddAte(const KeyframeTrajectories& keyframes, AteSums& sums) {
  const double causal = Ate(keyframes.causal, keyframes.truth);
  const double final = Ate(keyframes.final, keyframes.truth);
  sums.causal += causal;
  sums.final += final;
  ++sums.count;
  if (keyframes.batch.empty()) return;
  sums.batch += Ate(keyframes.batch, keyframes.truth);
  sums.causal_where_batch += causal;
  sums.final_where_batch += final;
  ++sums.batch_count;
}

}  // namespace

NeesRatios ComputeNeesRatios(const FrameError& f) {
  const Vector<15>& e = f.error;
  const Matrix<15, 15>& P = f.covariance;
  const Tilt tilt(f);
  return {Ratio<6>(e.head<6>(), P.topLeftCorner<6, 6>()),
          Ratio<3>(e.segment<3>(3), P.block<3, 3>(3, 3)),
          Ratio<3>(e.head<3>(), P.topLeftCorner<3, 3>()),
          Ratio<2>(tilt.error, tilt.covariance),
          Ratio<3>(e.segment<3>(6), P.block<3, 3>(6, 6)),
          Ratio<3>(e.segment<3>(9), P.block<3, 3>(9, 9)),
          Ratio<3>(e.segment<3>(12), P.block<3, 3>(12, 12)),
          Ratio<15>(e, P)};
}

void MeanRatios::Add(const NeesRatios& ratios) {
  for (std::size_t k = 0; k < kNumStateParts; ++k)
    sum[k] += ratios[k];
  ++count;
}

double MeanRatios::operator[](StatePart part) const {
  return count ? sum[static_cast<std::size_t>(part)] / count : 0;
}

ConsistencyFigures StudyConsistency(const Scenario& scenario, const ConsistencyOptions& options) {
  ConsistencyFigures figures;
  figures.name = scenario.name;
  for (const double t : kConvergenceTimes_s)
    figures.convergence.push_back({.elapsed_s = t});
  for (int i = 0; i < options.num_seeds; ++i) {
    const auto seed = static_cast<std::uint64_t>(options.first_seed + i);
    const SimulatedRun simulated = Simulate(scenario, options, seed);
    const ConsistencyRun run = RunConsistency(simulated, options, i < options.batch_seeds);
    ++figures.num_runs;
    figures.num_resets += run.num_resets;
    if (run.frames.empty()) continue;
    AddToTable(run, figures.nees);
    AddConvergence(run, figures.convergence);
    AddAte(run.keyframes, figures.ate);
    if (run.batch_last) figures.batch_nees.Add(ComputeNeesRatios(*run.batch_last));
    std::fprintf(stderr,
                 "\r%s: %d of %d seeds, pose NEES/6 %.2f ",
                 scenario.name.c_str(),
                 i + 1,
                 options.num_seeds,
                 figures.pose_nees());
  }
  std::fprintf(stderr, "\n");
  return figures;
}

}  // namespace facet
