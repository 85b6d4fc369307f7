// SPDX-License-Identifier: BSD-2-Clause
#include "consistency_run.h"

#include <cmath>
#include <map>

#include "consistency_batch.h"

#include "facet/geometry/so3.h"
#include "facet/imu/imu_buffer.h"

namespace facet {

SE3 GaugeTransform(const SE3& T_WB, const SE3& T_GB) {
  const Matrix3d R = (T_WB.q * T_GB.q.conjugate()).toRotationMatrix();
  const double yaw = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
  const Quaterniond q_WG(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return SE3(q_WG, T_WB.p - q_WG * T_GB.p);
}

FrameError CompareWithTruth(const NavState& estimate,
                            const Matrix<15, 15>& covariance,
                            const NavState& truth,
                            const SE3& T_WG) {
  FrameError out;
  out.covariance = covariance;
  out.R_WB = estimate.T_WB.R();
  const SE3 T_WB = T_WG * truth.T_WB;
  out.error.segment<3>(0) = LogSO3(estimate.T_WB.q.conjugate() * T_WB.q);
  out.error.segment<3>(3) = T_WB.p - estimate.T_WB.p;
  out.error.segment<3>(6) = T_WG.q * truth.v_WB - estimate.v_WB;
  out.error.segment<3>(9) = truth.bias.b_g - estimate.bias.b_g;
  out.error.segment<3>(12) = truth.bias.b_a - estimate.bias.b_a;
  return out;
}

FrameObservations AsFrontEnd(const FrameObservations& simulated, bool is_initialised) {
  FrameObservations out = simulated;
  if (!is_initialised || out.is_keyframe) return out;
  for (FeatureObservation& feature : out.features)
    feature.px_right.reset();
  return out;
}

namespace {

constexpr Duration kMaxImuGap{20'000'000};
constexpr Duration kMaxImuExtrapolation{0};

// Everything that happens to one run.
class Runner {
 public:
  Runner(const SimulatedRun& run,
         const ConsistencyOptions& options,
         bool with_batch,
         const PlanePolicy& planes)
      : run_(run),
        options_(options),
        planes_(planes),
        estimator_(run.rig, options.simulator.imu.noise, options.estimator) {
    if (with_batch) batch_.emplace(run.rig, options.simulator.imu.noise, options.estimator);
    for (const ImuSample& sample : run.imu)
      imu_.Add(sample);
  }

  ConsistencyRun Run() {
    for (std::size_t i = 0; i < run_.frames.size(); ++i)
      ProcessFrame(i);
    for (const KeyframePose& keyframe : estimator_.Snapshot().keyframes)
      AddFinal(keyframe);
    if (batch_) SolveBatch();
    out_.calibration = estimator_.Calibration();
    return std::move(out_);
  }

 private:
  void ProcessFrame(std::size_t i) {
    const bool was_initialised = estimator_.is_initialised();
    const FrameObservations observations = AsFrontEnd(run_.frames[i], was_initialised);
    ImuInterval imu;
    if (i > 0) {
      const Timestamp t0 = run_.truth[i - 1].t;
      imu = imu_.Between(t0, run_.truth[i].t, kMaxImuGap, kMaxImuExtrapolation);
    }
    StageTimes times;
    const EstimatorResult result = estimator_.AddFrame(observations, imu, times);
    out_.num_resets += result.was_reset ? 1 : 0;
    if (!result.has_state) return;
    if (!was_initialised) Begin(i, result);
    out_.frames.push_back(CompareWithTruth(result.state, result.covariance, run_.truth[i], T_WG_));
    out_.frames.back().elapsed_s = ToSeconds(run_.frames[i].t - first_t_);
    out_.frames.back().is_keyframe = observations.is_keyframe;
    for (const KeyframePose& keyframe : result.finished_keyframes)
      AddFinal(keyframe);
    if (observations.is_keyframe) {
      out_.keyframes.causal.push_back({run_.frames[i].t, result.state.T_WB});
      out_.keyframes.truth.push_back({run_.frames[i].t, run_.truth[i].T_WB});
    }
    if (planes_ && observations.is_keyframe) {
      const MapSnapshot snapshot = estimator_.Snapshot();
      AddPlaneErrors(snapshot);
      estimator_.Assign(planes_(observations, snapshot));
    }
    if (batch_ && was_initialised) batch_->AddFrame(observations, imu, result.state);
  }

  // Truth is where the points of a rough surface lie in the mean.
  void AddPlaneErrors(const MapSnapshot& snapshot) {
    const double relief_m = std::sqrt(3.0) * options_.simulator.roughness_m;
    FollowSurfaces(snapshot);
    for (const PlaneEstimate& plane : snapshot.planes) {
      const auto surface_id = surface_of_.find(plane.id);
      if (surface_id == surface_of_.end() || plane.covariance.isZero()) continue;
      const Surface& surface = run_.surfaces[static_cast<std::size_t>(surface_id->second.value)];
      const Vector3d& n = plane.plane_W.n;
      Vector3d n_true = T_WG_.q * surface.n_W;
      double at_anchor_m =
          n_true.dot(T_WG_ * Vector3d(surface.center_W + relief_m * surface.n_W) - plane.anchor_W);
      if (n_true.dot(n) < 0) {
        n_true = -n_true;
        at_anchor_m = -at_anchor_m;
      }
      Matrix<3, 4> J = Matrix<3, 4>::Zero();
      J.topLeftCorner<2, 3>() = TangentBasis(n).transpose();
      J(2, 3) = 1;
      PlaneError& out = out_.planes.emplace_back();
      out.elapsed_s = out_.frames.back().elapsed_s;
      out.plane = plane.id;
      out.error << TangentBasis(n).transpose() * n_true,
          at_anchor_m - (plane.plane_W.d - n.dot(plane.anchor_W));
      out.covariance = J * plane.covariance.bottomRightCorner<4, 4>() * J.transpose();
    }
  }

  // A plane belongs to the surface of the first landmark that was seen on it.
  void FollowSurfaces(const MapSnapshot& snapshot) {
    for (const LandmarkEstimate& landmark : snapshot.landmarks) {
      const auto truth = run_.landmarks.find(landmark.id);
      if (landmark.planes[0].IsValid() && truth != run_.landmarks.end())
        surface_of_.emplace(landmark.planes[0], truth->second.surface);
    }
  }

  void Begin(std::size_t i, const EstimatorResult& result) {
    first_t_ = run_.frames[i].t;
    const StartPrior& origin = estimator_.window().start_prior.value();
    T_WG_ = options_.align_at_first_output
                ? GaugeTransform(result.state.T_WB, run_.truth[i].T_WB)
                : GaugeTransform(origin.T_WB, run_.truth[origin.frame.value].T_WB);
    if (batch_) batch_->Begin(estimator_.window());
  }

  void AddFinal(const KeyframePose& keyframe) {
    if (keyframe.t >= first_t_ && run_.frames[keyframe.id.value].is_keyframe) {
      out_.keyframes.final.push_back({keyframe.t, keyframe.T_WB});
    }
  }

  void SolveBatch() {
    const BatchSolution solution = batch_->Solve(options_.batch_iterations);
    for (const NavState& state : solution.states) {
      if (state.t >= out_.keyframes.causal.front().t) {
        out_.keyframes.batch.push_back({state.t, state.T_WB});
      }
    }
    out_.batch_last = CompareWithTruth(solution.states.back(),
                                       solution.last_covariance,
                                       run_.truth[solution.last_frame.value],
                                       T_WG_);
  }

  const SimulatedRun& run_;
  const ConsistencyOptions& options_;
  const PlanePolicy& planes_;
  VioEstimator estimator_;
  ImuBuffer imu_;
  std::optional<BatchProblem> batch_;
  std::map<PlaneId, PlaneId> surface_of_;  // by plane
  Timestamp first_t_;
  SE3 T_WG_;
  ConsistencyRun out_;
};

}  // namespace

ConsistencyRun RunConsistency(const SimulatedRun& run,
                              const ConsistencyOptions& options,
                              bool with_batch,
                              const PlanePolicy& planes) {
  return Runner(run, options, with_batch, planes).Run();
}

}  // namespace facet
