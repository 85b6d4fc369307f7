// SPDX-License-Identifier: BSD-2-Clause
#include "facet/check/camera_imu_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

// What the covariance of the images leaves out: slow moving things, corners that slide. A part that
// does not depend on the angle, and one that does [rad].
constexpr double kFloor = 0.002, kRelative = 0.01;
// In units of sigma.
constexpr double kLossWidths[] = {30, 8, 3};
// The uncertainties of single turns are careful; what the residuals show counts down to this.
constexpr double kLeastVariance = 0.3;
constexpr int kNumSteps = 8;
constexpr double kPriorTurn = 0.5, kPriorScale = 0.3, kPriorBias = 0.3, kPriorTau = 0.3;
constexpr double kTauStep = 0.002;

constexpr double kLargestTau = 0.5, kScanStep = 0.01;
// Of the angles' sizes at the best offset and without any.
constexpr double kLeastCorrelation = 0.8, kLeastGain = 0.05;
constexpr std::size_t kMinTurns = 15;

using Vector8 = Vector<8>;
using Matrix38 = Matrix<3, 8>;

struct Residual {
  Vector3d value;
  Matrix38 J;
};

/// False where there is no gyroscope.
bool ResidualOf(const ImageTurn& turn,
                const GyroTrack& gyro,
                const CameraImuModel& m,
                Residual& residual) {
  const auto turn_at = [&](double tau_s, Vector3d& theta) {
    const Duration tau = FromSeconds(tau_s);
    return gyro.Turn(turn.begin + tau, turn.end + tau, theta);
  };
  Vector3d at, before, after;
  if (!turn_at(m.tau_s, at) || !turn_at(m.tau_s - kTauStep, before) ||
      !turn_at(m.tau_s + kTauStep, after)) {
    return false;
  }
  const double scale = std::exp(m.log_scale);
  const Matrix3d R = m.R_CB.toRotationMatrix();
  const Vector3d g = at - turn.duration_s() * m.bias;
  residual.value = turn.rotation.theta - scale * (R * g);
  residual.J.leftCols<3>() = scale * R * Hat(g);
  residual.J.col(3) = -scale * (R * g);
  residual.J.middleCols<3>(4) = scale * turn.duration_s() * R;
  residual.J.col(7) = -scale * (R * (after - before)) / (2 * kTauStep);
  return true;
}

Matrix3d InformationOf(const ImageTurn& turn) {
  const double sigma = std::hypot(kFloor, kRelative * turn.rotation.theta.norm());
  return (turn.rotation.covariance + sigma * sigma * Matrix3d::Identity()).inverse();
}

struct NormalEquations {
  Matrix<8, 8> H = Matrix<8, 8>::Zero();
  Vector8 b = Vector8::Zero();
  double cost = 0;
  int num = 0;
};

NormalEquations Linearize(std::span<const ImageTurn> turns,
                          const GyroTrack& gyro,
                          const CameraImuModel& model,
                          double width) {
  NormalEquations n;
  Residual residual;
  for (const ImageTurn& turn : turns) {
    if (!ResidualOf(turn, gyro, model, residual)) continue;
    const Matrix3d W = InformationOf(turn);
    const double squared = residual.value.dot(W * residual.value);
    const double weight = 1 / std::pow(1 + squared / (width * width), 2);
    n.H += weight * residual.J.transpose() * W * residual.J;
    n.b -= weight * residual.J.transpose() * W * residual.value;
    n.cost += squared / (1 + squared / (width * width));
    ++n.num;
  }
  return n;
}

/// Of the difference between the model and where it began.
Vector8 Difference(const CameraImuModel& start, const CameraImuModel& m) {
  Vector8 x;
  x << LogSO3(start.R_CB.conjugate() * m.R_CB), m.log_scale - start.log_scale, m.bias - start.bias,
      m.tau_s - start.tau_s;
  return x;
}

Vector8 PriorInformation() {
  Vector8 sigma;
  sigma << Vector3d::Constant(kPriorTurn), kPriorScale, Vector3d::Constant(kPriorBias), kPriorTau;
  return sigma.cwiseAbs2().cwiseInverse();
}

double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double num = static_cast<double>(a.size());
  double sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum_a += a[i];
    sum_b += b[i];
    aa += a[i] * a[i];
    bb += b[i] * b[i];
    ab += a[i] * b[i];
  }
  const double covariance = ab - sum_a * sum_b / num;
  const double variances = (aa - sum_a * sum_a / num) * (bb - sum_b * sum_b / num);
  return variances > 0 ? covariance / std::sqrt(variances) : 0;
}

double SizeCorrelation(std::span<const ImageTurn> turns, const GyroTrack& gyro, double tau_s) {
  std::vector<double> images, gyros;
  const Duration tau = FromSeconds(tau_s);
  for (const ImageTurn& turn : turns) {
    Vector3d theta;
    if (!gyro.Sum(turn.begin + tau, turn.end + tau, theta)) continue;
    images.push_back(turn.rotation.theta.norm());
    gyros.push_back(theta.norm());
  }
  return images.size() < kMinTurns ? 0 : Correlation(images, gyros);
}

}  // namespace

double CameraImuFit::Sigma(int parameter) const {
  return std::sqrt(covariance(parameter, parameter));
}

double CameraImuFit::TurnedSigmas() const {
  const Matrix3d C = covariance.topLeftCorner<3, 3>();
  return std::sqrt(std::max(0.0, turned.dot(C.ldlt().solve(turned))));
}

double RoughTimeOffset(std::span<const ImageTurn> turns, const GyroTrack& gyro) {
  const double without = SizeCorrelation(turns, gyro, 0);
  double best = without, best_tau_s = 0;
  for (double tau_s = -kLargestTau; tau_s <= kLargestTau; tau_s += kScanStep) {
    const double correlation = SizeCorrelation(turns, gyro, tau_s);
    if (correlation > best) {
      best = correlation;
      best_tau_s = tau_s;
    }
  }
  return best > kLeastCorrelation && best > without + kLeastGain ? best_tau_s : 0;
}

CameraImuFit FitCameraImu(std::span<const ImageTurn> turns,
                          const GyroTrack& gyro,
                          const CameraImuModel& start) {
  CameraImuFit fit;
  CameraImuModel& m = fit.model;
  m = start;
  const Vector8 prior = PriorInformation();
  NormalEquations n;
  for (const double width : kLossWidths) {
    for (int step = 0; step < kNumSteps; ++step) {
      n = Linearize(turns, gyro, m, width);
      n.H.diagonal() += prior;
      n.b -= prior.cwiseProduct(Difference(start, m));
      const Vector8 delta = n.H.ldlt().solve(n.b);
      m.R_CB = (m.R_CB * ExpSO3(delta.head<3>())).normalized();
      m.log_scale += delta[3];
      m.bias += delta.segment<3>(4);
      m.tau_s = std::clamp(m.tau_s + delta[7], -kLargestTau, kLargestTau);
      if (delta.norm() < 1e-7) break;
    }
  }
  fit.num_turns = n.num;
  fit.cost = n.cost / std::max(1, n.num);
  fit.covariance = std::max(kLeastVariance, fit.cost / 3) * n.H.inverse();
  fit.turned = Difference(start, m).head<3>();
  return fit;
}

std::pair<double, double> FitTimeOffset(std::span<const ImageTurn> turns,
                                        const GyroTrack& gyro,
                                        const CameraImuModel& model) {
  CameraImuModel m = model;
  double information = 0, cost = 0;
  for (const double width : kLossWidths) {
    for (int step = 0; step < kNumSteps; ++step) {
      const NormalEquations n = Linearize(turns, gyro, m, width);
      information = n.H(7, 7) + 1 / (kPriorTau * kPriorTau);
      cost = n.cost / std::max(1, n.num);
      m.tau_s = std::clamp(m.tau_s + n.b[7] / information, -kLargestTau, kLargestTau);
    }
  }
  return {m.tau_s, std::sqrt(std::max(kLeastVariance, cost / 3) / information)};
}

}  // namespace facet
