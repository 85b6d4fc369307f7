// SPDX-License-Identifier: BSD-2-Clause
#include <cmath>
#include <cstdio>

#include "consistency_study.h"

#include "facet/geometry/angles.h"

namespace facet {

namespace {

void PrintRatios(const char* name, const MeanRatios& ratios) {
  std::printf("  %-22s %7d", name, ratios.count);
  for (std::size_t k = 0; k < kNumStateParts; ++k) {
    std::printf(" %11.2f", ratios[static_cast<StatePart>(k)]);
  }
  std::printf("\n");
}

double StandardError(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0, square = 0;
  for (const double v : values)
    mean += v / n;
  for (const double v : values)
    square += (v - mean) * (v - mean);
  return n > 1 ? std::sqrt(square / (n - 1) / n) : 0;
}

void PrintNees(const NeesTable& table) {
  std::printf("  %-22s %7s", "NEES / dof", "frames");
  for (const char* name : kStatePartNames)
    std::printf(" %11s", name);
  std::printf("\n");
  constexpr const char* kTimes[] = {"first 2 s", "2-5 s", "later"};
  constexpr const char* kKinds[] = {"keyframes", "others"};
  for (std::size_t t = 0; t < table.by_time.size(); ++t) {
    for (std::size_t k = 0; k < table.by_time[t].size(); ++k) {
      PrintRatios((std::string(kTimes[t]) + ", " + kKinds[k]).c_str(), table.by_time[t][k]);
    }
  }
  PrintRatios("all", table.all);
  std::printf("  standard error of the pose ratio over the seeds: %.3f\n",
              StandardError(table.pose_by_run));
}

void PrintConvergence(const std::vector<ConvergenceRow>& rows) {
  std::printf(
      "  rms error (predicted sigma)    tilt [deg]       accel bias [m/s^2]   gyro bias "
      "[mrad/s]\n");
  for (const ConvergenceRow& row : rows) {
    if (row.count == 0) continue;
    const auto rms = [&](double sum) { return std::sqrt(sum / row.count); };
    std::printf("  %4.1f s after the first pose  %.3f (%.3f)      %.4f (%.4f)      %.3f (%.3f)\n",
                row.elapsed_s,
                rms(row.tilt_square) / kDegree,
                rms(row.tilt_variance) / kDegree,
                rms(row.accel_square),
                rms(row.accel_variance),
                1e3 * rms(row.gyro_square),
                1e3 * rms(row.gyro_variance));
  }
}

void PrintAte(const ConsistencyFigures& figures) {
  const AteSums& ate = figures.ate;
  std::printf("  ATE at keyframes, mean over %d runs: causal %.4f, final %.4f m\n",
              ate.count,
              ate.causal / ate.count,
              ate.final / ate.count);
  if (ate.batch_count == 0) return;
  std::printf("  with batch (%d runs): causal %.4f, final %.4f, batch %.4f m; ratio %.2f, %.2f\n",
              ate.batch_count,
              ate.causal_where_batch / ate.batch_count,
              ate.final_where_batch / ate.batch_count,
              ate.batch / ate.batch_count,
              figures.ate_ratio(),
              ate.final_where_batch / ate.batch);
  PrintRatios("batch, last keyframe", figures.batch_nees);
}

}  // namespace

void PrintFigures(const ConsistencyFigures& figures) {
  std::printf(
      "%s: %d runs, %d resets\n", figures.name.c_str(), figures.num_runs, figures.num_resets);
  if (figures.ate.count == 0) return;
  PrintNees(figures.nees);
  PrintConvergence(figures.convergence);
  PrintAte(figures);
  std::fflush(stdout);
}

}  // namespace facet
