// SPDX-License-Identifier: BSD-2-Clause
#include "facet/sim/vibration.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace facet {
namespace {

constexpr std::size_t kNumBands = 5;
struct Band {
  double low_hz, high_hz;
};
constexpr std::array<Band, kNumBands> kBands = {
    {{10, 20}, {20, 40}, {40, 60}, {60, 80}, {80, 100}}};

/// 1-sigma by axis (gyro x y z, accelerometer x y z) and band; printed for a recording by
/// studies/imu_spectra.py.
using Strengths = std::array<std::array<double, kNumBands>, 6>;
constexpr Strengths kRotors = {{{0.0099, 0.0170, 0.0027, 0.0029, 0.0074},
                                {0.0281, 0.0102, 0.0059, 0.0108, 0.0360},
                                {0.0247, 0.0142, 0.0040, 0.0059, 0.0185},
                                {0.290, 0.256, 0.269, 0.366, 0.890},
                                {0.085, 0.302, 0.125, 0.203, 0.319},
                                {0.134, 0.192, 0.204, 0.249, 0.677}}};
constexpr Strengths kHand = {{{0.0132, 0.0026, 0.0005, 0.0002, 0.0002},
                              {0.0048, 0.0032, 0.0005, 0.0008, 0.0002},
                              {0.0192, 0.0045, 0.0006, 0.0003, 0.0002},
                              {0.142, 0.042, 0.010, 0.017, 0.003},
                              {0.118, 0.039, 0.010, 0.015, 0.003},
                              {0.079, 0.019, 0.007, 0.009, 0.002}}};

/// Entry (b, c): variance that unit white noise through filter b has in band c.
template <class Filters>
MatrixXd BandResponse(const Filters& bank, double rate_hz) {
  constexpr double kStepHz = 0.25;
  MatrixXd response = MatrixXd::Zero(static_cast<Eigen::Index>(bank.size()), kNumBands);
  for (std::size_t b = 0; b < bank.size(); ++b) {
    for (std::size_t c = 0; c < kNumBands; ++c) {
      const double high_hz = std::min(kBands[c].high_hz, rate_hz / 2);
      for (double hz = kBands[c].low_hz; hz < high_hz; hz += kStepHz)
        response(b, c) += bank[b].Power((hz + kStepHz / 2) / rate_hz) * 2 * kStepHz / rate_hz;
    }
  }
  return response;
}

/// Squared gains of the filters for which all bands together get their strengths: filters leak into
/// neighbouring bands. Non-negative, by multiplicative steps (Richardson and Lucy).
VectorXd MatchBands(const MatrixXd& response, const std::array<double, kNumBands>& strengths) {
  const VectorXd target =
      Eigen::Map<const VectorXd>(strengths.data(), kNumBands).array().square().matrix();
  VectorXd power = VectorXd::Constant(response.rows(), target.mean() / response.mean());
  for (int i = 0; i < 200; ++i) {
    const VectorXd reached = response.transpose() * power;
    const VectorXd step = response * target.cwiseQuotient(reached.cwiseMax(1e-30));
    power = power.cwiseProduct(step.cwiseQuotient(response.rowwise().sum()));
  }
  return power;
}

}  // namespace

double Vibration::Filter::Next(double x) {
  for (Past& p : past) {
    const double y = x - p.x2 - a1 * p.y1 - a2 * p.y2;
    p.x2 = p.x1;
    p.x1 = x;
    p.y2 = p.y1;
    p.y1 = y;
    x = y;
  }
  return gain * x;
}

double Vibration::Filter::Power(double cycles) const {
  const std::complex<double> z = std::polar(1.0, -2 * std::numbers::pi * cycles);
  return std::pow(std::norm((1.0 - z * z) / (1.0 + a1 * z + a2 * z * z)), 2);
}

Vibration::Vibration(VibrationKind kind, double rate_hz, Rng rng) : rng_(rng) {
  const Strengths& strengths = kind == VibrationKind::kRotors ? kRotors : kHand;
  std::vector<Filter> bank;
  for (const Band& band : kBands) {
    const double center_hz = 0.5 * (band.low_hz + band.high_hz);
    const double width_hz = band.high_hz - band.low_hz;
    if (center_hz > 0.48 * rate_hz) break;
    Filter filter;
    // Each resonance is wider than the band that both together let through.
    const double radius = std::exp(-std::numbers::pi * 0.9 * width_hz / rate_hz);
    filter.a1 = -2 * radius * std::cos(2 * std::numbers::pi * center_hz / rate_hz);
    filter.a2 = radius * radius;
    bank.push_back(filter);
  }
  const MatrixXd response = BandResponse(bank, rate_hz);
  for (int axis = 0; axis < 6; ++axis) {
    const VectorXd power = MatchBands(response, strengths[static_cast<std::size_t>(axis)]);
    for (std::size_t b = 0; b < bank.size(); ++b) {
      filters_.push_back(bank[b]);
      filters_.back().axis = axis;
      filters_.back().gain = std::sqrt(power(static_cast<Eigen::Index>(b)));
    }
  }
  for (int i = 0; i < 200; ++i)  // past the transient
    Next();
}

Vector<6> Vibration::Next() {
  Vector<6> sum = Vector<6>::Zero();
  for (Filter& filter : filters_)
    sum(filter.axis) += filter.Next(rng_.Normal());
  return sum;
}

}  // namespace facet
