// SPDX-License-Identifier: BSD-2-Clause
// The state at the rate of the IMU: goes on from the newest causal state with the samples since,
// each of which is integrated once.
#pragma once

#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "facet/estimator/estimator_options.h"
#include "facet/imu/causal_state.h"
#include "facet/imu/imu_buffer.h"
#include "facet/live/imu_step.h"
#include "facet/live/predicted_state.h"

namespace facet {

struct PredictionOptions {
  /// Seconds over which a correction by a new frame is let through, evenly; 0: at once, the state
  /// jumps by as much as the frame knows better.
  double smoothing_s = 0;
  /// There is no state for moments further than this after the newest frame with a pose.
  double max_age_s = 1;
  OutputFrame frame;
};

/// Causal states and samples up to the present, kept sample by sample. Not thread-safe.
class ImuTrail {
 public:
  struct Entry {
    ImuSample sample;
    ReckonedState state;  ///< at the sample
  };

  /// Starts at a causal state. `samples` in order of time; what is before the state is not used but
  /// for the values at its moment.
  void Begin(const CausalState& from, const std::deque<ImuSample>& samples, const StepModel& model);

  /// Integrates what has been added to the samples since; takes back what is not among them any
  /// more.
  void Follow(const std::deque<ImuSample>& samples);

  bool empty() const { return entries_.empty(); }
  Timestamp begin() const { return entries_.front().sample.t; }
  const Entry& newest() const { return entries_.back(); }
  const StepModel& model() const { return model_; }

  /// The newest entry at or before t, which must not be before begin().
  const Entry* At(Timestamp t) const;
  /// The entry after one of them; null after the newest.
  const Entry* After(const Entry* entry) const;

 private:
  std::vector<Entry> entries_;
  StepModel model_;
};

/// Thread-safe: samples, states and questions may come from three threads. A question waits for the
/// others for no longer than it takes to integrate one sample, or the few that have come while a
/// new state was taken up.
class StatePredictor {
 public:
  StatePredictor(const ImuNoise& noise, const ImuOptions& imu, const PredictionOptions& options);

  /// In order of time (IMU clock). Glitches, and what is not finite or not in order, are left out
  /// as ImuBuffer does.
  void AddImu(const ImuSample& sample);

  /// After each stereo frame, also one without a pose: then the state before goes on, with the new
  /// status. A state older than the one in use is ignored. `state` is not looked at without a pose.
  void AddFrame(const CausalState& state, bool has_pose, TrackingStatus status, int segment);

  /// At t by the IMU's clock; empty before the first pose, for t before the newest frame with a
  /// pose, and where max_age_s is over.
  std::optional<PredictedState> PredictAt(Timestamp t) const;

  /// Stamp of the newest sample that is believed; empty before the first.
  std::optional<Timestamp> newest_imu() const;

 private:
  /// What a frame has changed, and when.
  struct Correction {
    Timestamp t;
    Vector<9> offset;  ///< estimate before (-) estimate since: theta p v
  };

  /// What is held back of all corrections: output (-) estimate.
  Vector<9> OffsetAt(Timestamp t) const;
  /// `next` takes the place of the trail.
  void KeepCorrection(const ImuTrail& next, int segment);

  const ImuParameters parameters_;
  const BiasWalk walk_;
  const Duration max_gap_;
  const PredictionOptions options_;
  const bool is_body_in_W_;  ///< there is nothing to turn

  std::mutex frame_mutex_;                ///< one new state after the other
  ImuTrail next_;                         ///< of the state that is being taken up
  std::deque<ImuSample> recent_samples_;  ///< those it is integrated over; keeps its storage

  mutable std::mutex mutex_;  ///< of all that follows
  ImuBuffer imu_;
  ImuTrail trail_;
  Timestamp frame_t_;                    ///< of the state in use
  std::vector<Correction> corrections_;  ///< that are not through yet, oldest first
  TrackingStatus status_ = TrackingStatus::kInitialising;
  int segment_ = 0;
};

}  // namespace facet
