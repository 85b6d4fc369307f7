// SPDX-License-Identifier: BSD-2-Clause
#include "consistency_run.h"

#include <cmath>

#include "consistency_batch.h"

#include "facet/geometry/so3.h"
#include "facet/imu/imu_buffer.h"

namespace facet {

namespace {

constexpr Duration kMaxImuGap{20'000'000};
constexpr Duration kMaxImuExtrapolation{0};

// Moves the truth's frame G into W by heading and position: T_WG with T_WG * T_GB ~ T_WB.
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

// The simulated front end: right pixels on keyframes only, once there is a pose.
FrameObservations AsFrontEnd(const FrameObservations& simulated, bool is_initialised) {
  FrameObservations out = simulated;
  if (!is_initialised || out.is_keyframe) return out;
  for (FeatureObservation& feature : out.features)
    feature.px_right.reset();
  return out;
}

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
    if (planes_ && observations.is_keyframe)
      estimator_.Assign(planes_(observations, estimator_.Snapshot()));
    if (batch_ && was_initialised) batch_->AddFrame(observations, imu, result.state);
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
