// SPDX-License-Identifier: BSD-2-Clause
#include "track_residuals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "facet/geometry/so3.h"

namespace facet {
namespace {

// (x, y, rho) in the first left camera.
struct Projection {
  Vector2d px;
  Matrix<2, 3> J;
};

std::optional<Projection> Project(const StereoRig& rig,
                                  int camera,
                                  const SE3& T_Bi_C,
                                  const Vector3d& point) {
  const auto c = static_cast<std::size_t>(camera);
  const SE3 T = rig.T_BC[c].Inverse() * T_Bi_C;
  const Vector3d p = T.q * Vector3d(point.x(), point.y(), 1) + point.z() * T.p;
  Matrix<2, 3> J_px_p;
  const auto px = rig.cameras[c].Project(p, &J_px_p);
  if (!px) return std::nullopt;
  Matrix3d J_p;
  J_p.leftCols<2>() = T.R().leftCols<2>();
  J_p.col(2) = T.p;
  return Projection{*px, J_px_p * J_p};
}

struct NormalEquations {
  Matrix3d H = Matrix3d::Identity() * 1e-9;
  Vector3d b = Vector3d::Zero();
  double cost = 0;

  void Add(const std::optional<Projection>& projection, const Vector2d& measured) {
    constexpr double kCauchyPx = 0.5;
    if (!projection) return;
    const Vector2d r = projection->px - measured;
    const double weight = 1 / (1 + r.squaredNorm() / (kCauchyPx * kCauchyPx));
    H += weight * projection->J.transpose() * projection->J;
    b -= weight * projection->J.transpose() * r;
    cost += std::log1p(r.squaredNorm() / (kCauchyPx * kCauchyPx));
  }
};

NormalEquations Linearize(const StereoRig& rig,
                          const std::vector<TrackSample>& samples,
                          const Vector3d& point) {
  NormalEquations equations;
  const SE3 T_WC = samples.front().T_WB * rig.T_BC[0];
  for (const TrackSample& sample : samples) {
    const SE3 T_Bi_C = sample.T_WB.Inverse() * T_WC;
    equations.Add(Project(rig, 0, T_Bi_C, point), sample.observation.px_left);
    if (!sample.observation.px_right) continue;
    equations.Add(Project(rig, 1, T_Bi_C, point), *sample.observation.px_right);
  }
  return equations;
}

// Levenberg-Marquardt from several depths; the lowest robust cost wins.
Vector3d FitPoint(const StereoRig& rig, const std::vector<TrackSample>& samples) {
  const auto ray = rig.cameras[0].Unproject(samples.front().observation.px_left);
  Vector3d best = Vector3d::Zero();
  double best_cost = std::numeric_limits<double>::max();
  for (const double rho : {0.02, 0.2, 0.8}) {
    Vector3d point(ray->x() / ray->z(), ray->y() / ray->z(), rho);
    double lambda = 1e-3;
    NormalEquations now = Linearize(rig, samples, point);
    for (int i = 0; i < 20; ++i) {
      const Matrix3d damping = (lambda * now.H.diagonal()).asDiagonal();
      const Vector3d candidate = point + (now.H + damping).ldlt().solve(now.b);
      const NormalEquations next = Linearize(rig, samples, candidate);
      const bool better = next.cost < now.cost;
      lambda *= better ? 0.1 : 10;
      if (!better) continue;
      point = candidate;
      now = next;
    }
    if (now.cost >= best_cost) continue;
    best_cost = now.cost;
    best = point;
  }
  return best;
}

// A landmark in the world, homogeneous, with what one frame saw of it.
struct Measurement {
  Vector4d p_W;
  TrackSample* sample = nullptr;
};

struct PoseEquations {
  Matrix<6, 6> H = Matrix<6, 6>::Identity() * 1e-6;
  Vector<6> b = Vector<6>::Zero();

  void Add(const StereoRig& rig,
           std::size_t camera,
           const SE3& T_WB,
           const Vector4d& p_W,
           const Vector2d& measured) {
    constexpr double kCauchyPx = 0.5;
    const SE3 T_CB = rig.T_BC[camera].Inverse();
    const Vector3d p_B = T_WB.q.conjugate() * (p_W.head<3>() - p_W.w() * T_WB.p);
    Matrix<2, 3> J_px_p;
    const auto px = rig.cameras[camera].Project(T_CB.q * p_B + p_W.w() * T_CB.p, &J_px_p);
    if (!px) return;
    Matrix<2, 6> J;
    J.leftCols<3>() = J_px_p * T_CB.R() * Hat(p_B);
    J.rightCols<3>() = -p_W.w() * J_px_p * T_CB.R() * T_WB.R().transpose();
    const Vector2d r = *px - measured;
    const double weight = 1 / (1 + r.squaredNorm() / (kCauchyPx * kCauchyPx));
    H += weight * J.transpose() * J;
    b -= weight * J.transpose() * r;
  }
};

void FitPose(const StereoRig& rig, std::vector<Measurement>& measurements) {
  SE3 T_WB = measurements.front().sample->T_WB;
  for (int i = 0; i < 5; ++i) {
    PoseEquations equations;
    for (const Measurement& s : measurements) {
      equations.Add(rig, 0, T_WB, s.p_W, s.sample->observation.px_left);
      if (s.sample->observation.px_right)
        equations.Add(rig, 1, T_WB, s.p_W, *s.sample->observation.px_right);
    }
    const Vector<6> d = equations.H.ldlt().solve(equations.b);
    T_WB = T_WB.Retract(d.head<3>(), d.tail<3>());
  }
  for (Measurement& s : measurements)
    s.sample->T_WB = T_WB;
}

}  // namespace

void RefinePoses(const StereoRig& rig, int rounds, TrackSamples& tracks) {
  constexpr std::size_t kMinLength = 5, kMinMeasurements = 15;
  for (int round = 0; round < rounds; ++round) {
    std::map<std::size_t, std::vector<Measurement>> frames;
    for (auto& [id, samples] : tracks) {
      if (samples.size() < kMinLength) continue;
      const Vector3d point = FitPoint(rig, samples);
      const SE3 T_WC = samples.front().T_WB * rig.T_BC[0];
      Vector4d p_W;
      p_W << T_WC.q * Vector3d(point.x(), point.y(), 1) + point.z() * T_WC.p, point.z();
      for (TrackSample& sample : samples)
        frames[sample.frame].push_back({p_W, &sample});
    }
    for (auto& [frame, measurements] : frames) {
      if (measurements.size() >= kMinMeasurements) FitPose(rig, measurements);
    }
  }
}

std::vector<FittedTrack> FitTracks(const StereoRig& rig,
                                   const TrackSamples& tracks,
                                   int min_length) {
  std::vector<FittedTrack> fitted;
  for (const auto& [id, samples] : tracks) {
    if (static_cast<int>(samples.size()) < min_length) continue;
    const Vector3d point = FitPoint(rig, samples);
    FittedTrack track{id, point.z(), {}};
    const SE3 T_WC = samples.front().T_WB * rig.T_BC[0];
    for (const TrackSample& sample : samples) {
      const SE3 T_Bi_C = sample.T_WB.Inverse() * T_WC;
      const auto left = Project(rig, 0, T_Bi_C, point);
      if (!left) continue;
      TrackResidual residual;
      residual.frame = sample.frame;
      residual.age = static_cast<int>(sample.frame - samples.front().frame);
      residual.left_px = left->px - sample.observation.px_left;
      residual.sigma_left_px = sample.observation.sigma_left_px;
      residual.sigma_right_px = sample.observation.sigma_right_px;
      const auto right = Project(rig, 1, T_Bi_C, point);
      if (sample.observation.px_right && right)
        residual.right_px = right->px - *sample.observation.px_right;
      track.residuals.push_back(residual);
    }
    fitted.push_back(std::move(track));
  }
  return fitted;
}

Spread ComputeSpread(std::vector<double> values, double limit) {
  Spread spread;
  spread.count = values.size();
  if (values.empty()) return spread;
  const auto median = [](std::vector<double>& v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
  };
  std::size_t inside = 0;
  for (const double v : values) {
    if (std::abs(v) > limit) continue;
    ++inside;
    spread.mean += v;
    spread.rms += v * v;
  }
  const double n = static_cast<double>(std::max<std::size_t>(1, inside));
  spread.mean /= n;
  spread.rms = std::sqrt(spread.rms / n);
  spread.outliers = 1 - static_cast<double>(inside) / static_cast<double>(values.size());
  const double centre = median(values);
  for (double& v : values)
    v = std::abs(v - centre);
  spread.robust_sigma = 1.4826 * median(values);
  return spread;
}

}  // namespace facet
