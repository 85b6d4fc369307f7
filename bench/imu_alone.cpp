// SPDX-License-Identifier: BSD-2-Clause
// imu_alone: prints how well the IMU alone predicts real EuRoC flights; see imu_alone_study.h.
// Usage: imu_alone [FOLDER ...], a folder holding groundtruth.csv (200 Hz) and imu.csv.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>

#include "imu_alone_study.h"

#include "facet/testing/data_dir.h"

namespace facet {
namespace {

using Intervals = std::vector<PredictedInterval>;

void PrintVector(const char* name, const Vector<9>& x) {
  std::printf("  %-10s", name);
  for (int i = 0; i < 9; ++i)
    std::printf(" %10.2e", x(i));
  std::printf("\n");
}

void PrintErrors(const Intervals& intervals, Duration length) {
  const ErrorStatistics s = Summarise(intervals);
  std::printf("interval %.2f s, %d intervals%54s\n",
              ToSeconds(length),
              s.count,
              "(W: p, v in the world; B: in the body)");
  std::printf("  %-10s %32s %32s %32s\n", "", "theta [rad] x y z", "p [m] x y z", "v [m/s] x y z");
  PrintVector("W mean", s.W.mean);
  PrintVector("W mean/se", s.W.mean.cwiseQuotient(s.W.standard_error));
  PrintVector("W rms", s.W.rms);
  PrintVector("B mean/se", s.B.mean.cwiseQuotient(s.B.standard_error));
  PrintVector("B rms", s.B.rms);
  std::printf("  rms length: %.3g rad, %.3g mm, %.3g m/s;  NEES %.1f (9 with a perfect truth)\n",
              s.norm_rms(0),
              1e3 * s.norm_rms(1),
              s.norm_rms(2),
              s.nees);
  const Vector3d g_W = GravityWithoutMeanError(intervals);
  std::printf(
      "  gravity without mean velocity error: %.4f %.4f %.4f +- %.4f, length %.4f, tilt %.2f "
      "mrad\n",
      g_W.x(),
      g_W.y(),
      g_W.z(),
      s.W.standard_error(8) / ToSeconds(length),
      g_W.norm(),
      1e3 * std::hypot(g_W.x(), g_W.y()) / g_W.norm());
}

void PrintFactors(const char* name, const Intervals& intervals) {
  if (intervals.size() < 10) return;
  const ErrorStatistics s = Summarise(intervals);
  const Vector2d density = OddEvenDensity(intervals);
  std::printf("  %-26s %5d   %6.2f %6.2f %6.2f   %8.1e %8.1e %8.1e   %8.1e %8.1e\n",
              name,
              s.count,
              s.factor(0),
              s.factor(2),
              s.factor(1),
              s.norm_rms(0),
              s.norm_rms(2),
              s.norm_rms(1),
              density(0),
              density(1));
}

template <class Condition>
Intervals Where(const Intervals& all, const Condition& condition) {
  Intervals some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some), condition);
  return some;
}

void PrintSplit(const Intervals& all, Duration length) {
  std::printf(
      "interval %.2f s: factor on the datasheet densities for theta, v, p; rms length; "
      "odd-even densities\n",
      ToSeconds(length));
  std::printf("  %-26s %5s   %6s %6s %6s   %8s %8s %8s   %8s %8s\n",
              "intervals",
              "count",
              "theta",
              "v",
              "p",
              "rad",
              "m/s",
              "m",
              "gyro",
              "accel");
  const auto flying = [](const PredictedInterval& i) { return !i.at_rest; };
  PrintFactors("at rest", Where(all, std::not_fn(flying)));
  const Intervals flight = Where(all, flying);
  PrintFactors("in flight", flight);
  const double speeds[] = {0, 0.3, 0.7, 1.2, 10};
  for (int k = 0; k < 4; ++k) {
    char name[64];
    std::snprintf(name, sizeof name, "  speed %.1f-%.1f m/s", speeds[k], speeds[k + 1]);
    PrintFactors(name, Where(flight, [&](const PredictedInterval& i) {
                   return i.speed >= speeds[k] && i.speed < speeds[k + 1];
                 }));
  }
  const double vibrations[] = {0, 0.25, 0.5, 0.75, 1.0, 10};
  for (int k = 0; k < 5; ++k) {
    char name[64];
    std::snprintf(name, sizeof name, "  vibration %.2f-%.2f", vibrations[k], vibrations[k + 1]);
    PrintFactors(name, Where(flight, [&](const PredictedInterval& i) {
                   return i.vibration >= vibrations[k] && i.vibration < vibrations[k + 1];
                 }));
  }
}

void Study(const std::filesystem::path& folder) {
  const Flight flight = LoadFlight(folder);
  std::printf("==== %s: %zu true states, %zu samples\n",
              folder.filename().c_str(),
              flight.truth.size(),
              flight.imu.size());
  constexpr double kLengths[] = {0.05, 0.1, 0.2, 0.5, 1.0};
  std::vector<Intervals> all;
  for (double s : kLengths)
    all.push_back(PredictFlight(flight, FromSeconds(s)));
  for (std::size_t i = 0; i < all.size(); ++i)
    PrintErrors(all[i], FromSeconds(kLengths[i]));
  for (std::size_t i = 0; i < all.size(); ++i)
    PrintSplit(all[i], FromSeconds(kLengths[i]));
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  try {
    std::vector<std::filesystem::path> folders(argv + 1, argv + argc);
    if (folders.empty()) {
      for (const char* name : {"euroc_flights/V1_02_medium", "euroc_flights/MH_05_difficult"}) {
        const auto folder = facet::testing::DataDir(name);
        if (!folder) {
          std::fprintf(stderr, "imu_alone: %s\n", facet::testing::MissingData(name).c_str());
          return 2;
        }
        folders.push_back(*folder);
      }
    }
    for (const auto& folder : folders)
      facet::Study(folder);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "imu_alone: %s\n", e.what());
    return 1;
  }
  return 0;
}
