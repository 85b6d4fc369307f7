// SPDX-License-Identifier: BSD-2-Clause
// The beginning of a run: collect frames until gravity and velocity are known, put them into the
// world, and keep them until they have said all they can (docs/math.md, section 6).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/estimator/solver/window_optimizer.h"
#include "facet/estimator/window/imu_intervals.h"
#include "facet/map/map_snapshot.h"

namespace facet {

/// The outcome of an attempt to start.
struct StartAttempt {
  bool has_started = false;
  bool has_failed = false;   ///< no numbers came out: the window is of no use any more
  std::string reason;        ///< why not yet
  int num_constraining = 0;  ///< landmarks that constrain the window
  SolveSummary solve;
  Matrix<15, 15> covariance = Matrix<15, 15>::Zero();  ///< of the newest frame, if it has started
};

/// First there is no state, and every frame is one more attempt; then there is one, but the window
/// only grows; then the start is over. Not thread-safe.
class VioStart {
 public:
  VioStart(const StereoRig& rig, const EstimatorOptions& options) : rig_(rig), options_(options) {}

  bool has_state() const { return has_state_; }

  /// The first frame of a run, upright as the accelerometer says. The start prior holds it.
  static void AppendFirstFrame(WindowFrame frame,
                               const ImuInterval& imu,
                               const StartOptions& options,
                               SlidingWindow& window);

  /// With one more frame in the window, and its observations. Its newest frame is put at the
  /// position and heading of `predicted`, or at the origin if nothing is known of them.
  StartAttempt Try(const std::optional<SE3>& predicted,
                   const ImuIntervals& imu,
                   WindowOptimizer& optimizer,
                   SlidingWindow& window);

  /// After each keyframe since: ends the start and solves the window anew if the tilt is certain
  /// enough, and returns whether the start is over. If it goes on but the window is full of
  /// duplicates, one of them is removed, and its final pose is appended to `finished`.
  /// `covariance`: of the newest frame.
  bool EndIfDue(const Matrix<15, 15>& covariance,
                const ImuIntervals& imu,
                WindowOptimizer& optimizer,
                SlidingWindow& window,
                std::vector<KeyframePose>& finished);

 private:
  bool HasEnoughFrames(const SlidingWindow& window) const;
  void TryFrames(const std::optional<SE3>& predicted,
                 const ImuIntervals& imu,
                 WindowOptimizer& optimizer,
                 SlidingWindow& window,
                 StartAttempt& attempt);
  std::string FindFirstValues(int num_constraining, SlidingWindow& window) const;
  void Solve(const ImuIntervals& imu,
             WindowOptimizer& optimizer,
             SlidingWindow& window,
             StartAttempt& attempt) const;
  std::string WhyNotYet(const Matrix<15, 15>& covariance,
                        double doubted_s,
                        const SlidingWindow& window) const;
  void Begin(const std::optional<SE3>& predicted,
             WindowOptimizer& optimizer,
             SlidingWindow& window,
             StartAttempt& attempt);
  bool ShouldEnd(const Matrix<15, 15>& covariance,
                 const ImuIntervals& imu,
                 SlidingWindow& window,
                 std::vector<KeyframePose>& finished) const;

  StereoRig rig_;
  EstimatorOptions options_;
  std::optional<Timestamp> first_try_;  // with enough frames
  bool has_state_ = false;
  bool is_over_ = false;
};

}  // namespace facet
