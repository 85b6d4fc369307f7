// SPDX-License-Identifier: BSD-2-Clause
#include "imu_alone_study.h"

#include <algorithm>

#include "facet/base/check.h"
#include "facet/geometry/so3.h"
#include "facet/imu/imu_buffer.h"
#include "facet/sim/euroc_csv.h"

namespace facet {

namespace {

constexpr double kRestSpeed = 0.03;      // m/s
constexpr double kRestVibration = 0.06;  // m/s^2: twice the datasheet noise of a sample

double Vibration(const std::vector<ImuSample>& samples) {
  constexpr int kHalf = 5;  // 50 ms at 200 Hz
  const int n = static_cast<int>(samples.size());
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const int begin = std::max(0, i - kHalf), end = std::min(n, i + kHalf + 1);
    Vector3d mean = Vector3d::Zero();
    for (int k = begin; k < end; ++k)
      mean += samples[k].accel / (end - begin);
    sum += (samples[i].accel - mean).squaredNorm() / 3.0;
  }
  return std::sqrt(sum / n);
}

/// Alternating sum with the weights 1/2 1 ... 1 1/2 times -1, 1, -1: zero for a straight line.
Vector<6> OddMinusEven(const std::vector<ImuSample>& samples) {
  Vector<6> sum = Vector<6>::Zero();
  const std::size_t last = (samples.size() - 1) / 2 * 2;
  for (std::size_t i = 0; i <= last; ++i) {
    const double weight = (i % 2 ? 1.0 : -1.0) * (i == 0 || i == last ? 0.5 : 1.0);
    sum.head<3>() += weight * samples[i].gyro;
    sum.tail<3>() += weight * samples[i].accel;
  }
  return sum;
}

PredictedInterval Predict(const NavState& start,
                          const NavState& end,
                          const std::vector<ImuSample>& samples,
                          const Vector3d& g_W) {
  ImuPreintegration preintegration(start.bias, ImuParameters{});
  preintegration.Integrate(samples);
  NavState predicted = preintegration.Predict(start);
  const Vector3d dg_W = g_W - GravityInWorld();
  const double dt = preintegration.dt();
  predicted.v_WB += dg_W * dt;
  predicted.T_WB.p += 0.5 * dt * dt * dg_W;

  PredictedInterval result;
  result.t0 = start.t;
  result.length = end.t - start.t;
  result.error << LogSO3(end.T_WB.q.conjugate() * predicted.T_WB.q), predicted.T_WB.p - end.T_WB.p,
      predicted.v_WB - end.v_WB;
  const Quaterniond q_BW = start.T_WB.q.conjugate();
  result.error_B << result.error.head<3>(), q_BW * result.error.segment<3>(3),
      q_BW * result.error.tail<3>();
  result.covariance = preintegration.Covariance();
  result.speed = start.v_WB.norm();
  result.vibration = Vibration(samples);
  result.odd_minus_even = OddMinusEven(samples);
  result.at_rest = result.speed < kRestSpeed && result.vibration < kRestVibration;
  return result;
}

double NormalisedSquaredError(const MatrixXd& covariance, const VectorXd& error) {
  return error.dot(covariance.llt().solve(error));
}

}  // namespace

Flight LoadFlight(const std::filesystem::path& folder) {
  return {LoadGroundTruthCsv(folder / "groundtruth.csv"), LoadImuCsv(folder / "imu.csv")};
}

std::vector<PredictedInterval> PredictFlight(const Flight& flight,
                                             Duration length,
                                             const Vector3d& g_W) {
  ImuBuffer buffer;
  for (const ImuSample& sample : flight.imu)
    buffer.Add(sample);
  std::vector<PredictedInterval> intervals;
  // Stamps jitter by some 100 ns: take the first true state near the nominal end.
  constexpr Duration kJitter{1'000'000};
  auto start = flight.truth.begin();
  for (;;) {
    const auto end = std::lower_bound(
        start, flight.truth.end(), start->t + length - kJitter, [](const NavState& s, Timestamp t) {
          return s.t < t;
        });
    if (end == flight.truth.end()) return intervals;
    if (end->t - start->t < length + kJitter) {
      const ImuInterval interval =
          buffer.Between(start->t, end->t, Duration{8'000'000}, Duration{0});
      if (!interval.samples.empty() && interval.gaps == 0) {
        intervals.push_back(Predict(*start, *end, interval.samples, g_W));
      }
    }
    start = end;
  }
}

Vector3d GravityWithoutMeanError(const std::vector<PredictedInterval>& intervals,
                                 const Vector3d& g_W) {
  FACET_CHECK(!intervals.empty()) << "no intervals";
  Vector3d sum = Vector3d::Zero();
  double time = 0;
  for (const PredictedInterval& i : intervals) {
    sum += i.error.tail<3>();
    time += ToSeconds(i.length);
  }
  return g_W - sum / time;
}

namespace {

using ErrorField = Vector<9> PredictedInterval::*;

/// Standard error of the mean of correlated errors, from the scatter of means over 2 s.
Vector<9> StandardErrorOfMean(const std::vector<PredictedInterval>& intervals,
                              ErrorField field,
                              const Vector<9>& mean) {
  const auto batch = static_cast<std::size_t>(
      std::max(1.0, std::round(2.0 / ToSeconds(intervals.front().length))));
  const std::size_t num_batches = std::max<std::size_t>(1, intervals.size() / batch);
  Vector<9> squares = Vector<9>::Zero();
  for (std::size_t b = 0; b < num_batches; ++b) {
    Vector<9> sum = Vector<9>::Zero();
    const std::size_t end = std::min(intervals.size(), (b + 1) * batch);
    for (std::size_t i = b * batch; i < end; ++i)
      sum += intervals[i].*field - mean;
    squares += (sum / static_cast<double>(end - b * batch)).cwiseAbs2();
  }
  return squares.cwiseSqrt() / static_cast<double>(num_batches);
}

NineErrors SummariseErrors(const std::vector<PredictedInterval>& intervals, ErrorField field) {
  const auto n = static_cast<double>(intervals.size());
  NineErrors s;
  for (const PredictedInterval& i : intervals) {
    s.mean += i.*field / n;
    s.rms += (i.*field).cwiseAbs2() / n;
  }
  s.rms = s.rms.cwiseSqrt().eval();
  s.standard_error = StandardErrorOfMean(intervals, field, s.mean);
  return s;
}

}  // namespace

ErrorStatistics Summarise(const std::vector<PredictedInterval>& intervals) {
  FACET_CHECK(!intervals.empty()) << "no intervals";
  ErrorStatistics s;
  s.count = static_cast<int>(intervals.size());
  s.W = SummariseErrors(intervals, &PredictedInterval::error);
  s.B = SummariseErrors(intervals, &PredictedInterval::error_B);
  Vector3d normalised = Vector3d::Zero();
  for (const PredictedInterval& i : intervals) {
    for (int k = 0; k < 3; ++k) {
      normalised(k) += NormalisedSquaredError(i.covariance.block<3, 3>(3 * k, 3 * k),
                                              i.error_B.segment<3>(3 * k)) /
                       (3 * s.count);
    }
    s.nees += NormalisedSquaredError(i.covariance, i.error_B) / s.count;
  }
  for (int k = 0; k < 3; ++k)
    s.norm_rms(k) = s.W.rms.segment<3>(3 * k).norm();
  s.factor = normalised.cwiseSqrt();
  return s;
}

Vector2d OddEvenDensity(const std::vector<PredictedInterval>& intervals) {
  // For white samples of variance density^2 / dt the alternating sum over n samples has variance
  // n density^2 / dt = length density^2 / dt^2.
  constexpr double kDt = 0.005;
  Vector2d sum = Vector2d::Zero();
  double time = 0;
  for (const PredictedInterval& i : intervals) {
    sum += Vector2d(i.odd_minus_even.head<3>().squaredNorm(),
                    i.odd_minus_even.tail<3>().squaredNorm()) /
           3.0;
    time += ToSeconds(i.length);
  }
  return (sum / std::max(time, kDt)).cwiseSqrt() * kDt;
}

}  // namespace facet
