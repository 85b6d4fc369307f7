// SPDX-License-Identifier: BSD-2-Clause
#include "facet/plausibility/gyroscope_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

// Slower turns hide behind the bias [rad/s].
constexpr double kLeastRate = 0.15;
// A gyroscope's bias before it is known, and what a careful calibration, 20 ms of clock and a
// rolling shutter leave: a part that does not depend on the rate, and one that does.
constexpr double kBiasSigma = 0.06, kRateSigma = 0.06, kRelativeSigma = 0.06;
// What one turn can cost at most: a board that fills the image counts no more than this.
constexpr double kLargestCost = 25;
// Mean cost of a turn of what fits: three errors of one sigma cost about 3, of three sigma 13.
constexpr double kFits = 5;
// What two explanations must differ by: summed over the turns, and in a turn that counts for it.
constexpr double kClear = 60, kClearTurn = 8;
constexpr int kMinClearTurns = 4;
// Explanations that differ by less are not told apart.
constexpr double kAlike = 15;
// Maps from rate to rate that differ by less are the same.
constexpr double kSameMap = 0.3;
constexpr std::size_t kMinTurns = 5, kMaxTurns = 30;
// What has a free parameter fits a few turns too easily.
constexpr std::size_t kMinTurnsToFit = 15;
constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

struct SignedAxes {
  std::array<std::size_t, 3> source;  // axis k of the body is what is measured along source[k]
  std::array<int, 3> sign;

  Matrix3d Matrix() const {
    Matrix3d M = Matrix3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      M(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(source[k])) = sign[k];
    return M;
  }
  int NumMoved() const {
    int num = 0;
    for (std::size_t k = 0; k < 3; ++k)
      num += source[k] != k ? 1 : 0;
    return num;
  }
  int NumNegated() const { return static_cast<int>(std::ranges::count(sign, -1)); }

  std::string Words() const {
    std::ostringstream text;
    const bool are_moved = NumMoved() > 0;
    text << (are_moved ? "the IMU's axes were swapped (" : "the IMU's axis ");
    const char* separator = "";
    for (std::size_t k = 0; k < 3; ++k) {
      if (!are_moved && sign[k] > 0) continue;
      text << separator << kAxisNames[k];
      if (are_moved) text << " were " << (sign[k] < 0 ? "-" : "") << kAxisNames[source[k]];
      separator = are_moved ? ", " : " and axis ";
    }
    text << (are_moved ? ")" : " were negated");
    return text.str();
  }
};

// All 48, those with the fewest changes first; the first one is as it should be.
std::vector<SignedAxes> AllSignedAxes() {
  std::vector<SignedAxes> all;
  std::array<std::size_t, 3> source = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      const auto sign = [&](int k) { return (signs >> k & 1) != 0 ? -1 : 1; };
      all.push_back({source, {sign(0), sign(1), sign(2)}});
    }
  } while (std::ranges::next_permutation(source).found);
  std::ranges::stable_sort(all, [](const SignedAxes& a, const SignedAxes& b) {
    return 4 * a.NumMoved() + a.NumNegated() < 4 * b.NumMoved() + b.NumNegated();
  });
  return all;
}

// Inverse covariance of the difference between both.
Matrix3d Information(const SharedTurn& turn) {
  const double rate = turn.image.theta.norm() / turn.duration_s;
  const double sigma = std::hypot(kRateSigma, kRelativeSigma * rate) * turn.duration_s;
  return (turn.image.covariance + sigma * sigma * Matrix3d::Identity()).inverse();
}

// Geman and McClure's: never more than kLargestCost.
double Loss(double squared) {
  return squared * kLargestCost / (kLargestCost + squared);
}

double LossWeight(double squared) {
  const double root = kLargestCost / (kLargestCost + squared);
  return root * root;
}

}  // namespace

GyroscopeCheck::GyroscopeCheck(const Quaterniond& R_BC) : R_BC_(R_BC) {
  const Matrix3d R = R_BC.toRotationMatrix();
  const std::string inverted =
      "T_BS of cam0 were inverted (it takes points from the camera to the IMU)";
  const std::string in_degrees = "the gyroscope measured in deg/s";
  const auto add = [&](const Matrix3d& A, const std::string& words, bool is_common) {
    // A camera that looks along an axis of the IMU may be mounted the same both ways round.
    if ((A - R.transpose()).norm() < kSameMap) return;
    Hypothesis& hypothesis = hypotheses_.emplace_back();
    hypothesis.A = A;
    hypothesis.words = words;
    hypothesis.is_common = is_common;
  };
  add(kDegree * R.transpose(), in_degrees, true);
  add(R, inverted, true);
  AddAxes(1, "");
  add(kDegree * R, in_degrees + " and " + inverted, false);
  AddAxes(kDegree, in_degrees + " and ");
}

void GyroscopeCheck::AddAxes(double scale, const std::string& unit_words) {
  for (const SignedAxes& axes : AllSignedAxes()) {
    if (axes.NumMoved() + axes.NumNegated() == 0) continue;
    hypotheses_.push_back({scale * R_BC_.toRotationMatrix().transpose() * axes.Matrix(),
                           unit_words + axes.Words(),
                           unit_words.empty() && axes.NumMoved() == 0 && axes.NumNegated() == 1});
  }
}

bool GyroscopeCheck::IsConvinced() const {
  return std::ranges::all_of(hypotheses_, [](const Hypothesis& h) { return h.is_refuted; });
}

bool GyroscopeCheck::IsOfUse(const Vector3d& gyro_B) const {
  const Matrix3d R_CB = R_BC_.toRotationMatrix().transpose();
  for (int k = 0; k < 3; ++k) {
    if (std::abs(gyro_B[k]) < kLeastRate) continue;
    for (const Hypothesis& h : hypotheses_) {
      if (!h.is_refuted && (h.A - R_CB).col(k).norm() > kSameMap) return true;
    }
  }
  return false;
}

// Robust sum over the turns, with the best bias; as if half the turns were wrong at most.
GyroscopeCheck::Costs GyroscopeCheck::Cost(const Matrix3d& A) const {
  Vector3d bias = Vector3d::Zero();  // in the camera
  Costs costs;
  for (int step = 0; step < 4; ++step) {
    Matrix3d H = Matrix3d::Identity() / (kBiasSigma * kBiasSigma);
    Vector3d b = Vector3d::Zero();
    costs.sum = bias.squaredNorm() / (kBiasSigma * kBiasSigma);
    costs.turns.clear();
    for (const auto& [turn, W] : turns_) {
      const Vector3d error = turn.image.theta - A * turn.gyro_B;
      const Vector3d left = error - turn.duration_s * bias;
      const double squared = left.dot(W * left);
      const double weight = turn.duration_s * LossWeight(squared);
      H += weight * turn.duration_s * W;
      b += weight * W * error;
      costs.turns.push_back(Loss(squared));
      costs.sum += costs.turns.back();
    }
    bias = H.ldlt().solve(b);
  }
  return costs;
}

// Errors without a name: any scale, any rotation.
std::vector<GyroscopeCheck::Hypothesis> GyroscopeCheck::Fitted() const {
  const Matrix3d R_CB = R_BC_.toRotationMatrix().transpose();
  double product = 0, square = 0;
  Matrix3d C = Matrix3d::Zero();
  for (const auto& [turn, W] : turns_) {
    product += turn.image.theta.dot(R_CB * turn.gyro_B);
    square += turn.gyro_B.squaredNorm();
    C += turn.image.theta * turn.gyro_B.transpose();
  }
  std::vector<Hypothesis> fitted;
  const double scale = std::max(product, 1e-12) / std::max(square, 1e-12);
  char words[80];
  std::snprintf(words, sizeof(words), "the gyroscope measured %.2g times the true rate", 1 / scale);
  fitted.push_back({scale * R_CB, words});
  const Eigen::JacobiSVD<Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) *= -1;
  const Matrix3d rotation = U * svd.matrixV().transpose();
  const double angle = LogSO3(Quaterniond(Matrix3d(R_CB.transpose() * rotation))).norm();
  fitted.push_back({rotation,
                    "the rotation of T_BS were off by " +
                        std::to_string(std::lround(angle / kDegree)) + " deg"});
  return fitted;
}

// Whether `better` explains the turns and `worse` does not.
bool GyroscopeCheck::IsClear(const Costs& better, const Costs& worse) const {
  const double num = static_cast<double>(turns_.size());
  if (better.sum > kFits * num || worse.sum - better.sum < kClear) return false;
  int num_clear = 0;
  for (std::size_t i = 0; i < turns_.size(); ++i)
    num_clear += worse.turns[i] - better.turns[i] > kClearTurn ? 1 : 0;
  return num_clear >= kMinClearTurns;
}

// What explains the turns where the calibration as given does not, in words.
std::string GyroscopeCheck::Decide(const Costs& as_given,
                                   const std::vector<const Hypothesis*>& open) const {
  if (as_given.sum < kClear || open.empty()) return {};
  std::vector<Costs> costs;
  for (const Hypothesis* hypothesis : open)
    costs.push_back(Cost(hypothesis->A));
  const Costs& best = *std::ranges::min_element(costs, {}, &Costs::sum);
  // A camera that stands still or repeats its image says nothing about the gyroscope.
  if (!IsClear(best, as_given) || !IsClear(best, Cost(Matrix3d::Zero()))) return {};
  // Where the motion leaves several, name the simplest one and what people usually do.
  std::string words;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (!IsClear(costs[i], as_given) || costs[i].sum > best.sum + kAlike) continue;
    if (!words.empty() && !open[i]->is_common) continue;
    words += (words.empty() ? "" : ", or as if ") + open[i]->words;
  }
  return words;
}

std::string GyroscopeCheck::Add(const SharedTurn& turn) {
  turns_.push_back({turn, Information(turn)});
  if (turns_.size() > kMaxTurns) turns_.pop_front();
  if (turns_.size() < kMinTurns) return {};
  const Costs as_given = Cost(R_BC_.toRotationMatrix().transpose());
  std::vector<const Hypothesis*> open;
  for (Hypothesis& hypothesis : hypotheses_) {
    if (hypothesis.is_refuted) continue;
    hypothesis.is_refuted = IsClear(as_given, Cost(hypothesis.A));
    if (!hypothesis.is_refuted) open.push_back(&hypothesis);
  }
  const std::string words = Decide(as_given, open);
  if (!words.empty() || turns_.size() < kMinTurnsToFit) return words;
  const std::vector<Hypothesis> fitted = Fitted();
  return Decide(as_given, {&fitted[0], &fitted[1]});
}

}  // namespace facet
