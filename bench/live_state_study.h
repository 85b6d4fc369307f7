// SPDX-License-Identifier: BSD-2-Clause
// Is the state at the rate of the IMU as exact, and as honest about it, as those of the frames?
#pragma once

#include <string>
#include <vector>

#include "consistency_study.h"

namespace facet {

struct LiveStateOptions {
  ConsistencyOptions consistency;
  double latency_s = 0.02;     ///< from the exposure of a frame until its state is known
  double ask_after_s = 0.002;  ///< a question comes this long after each sample, which is then held
  double smoothing_s = 0.1;    ///< of the smoothed variant, see PredictionOptions
};

/// Root mean square error of positions, and normalised errors.
struct StateErrors {
  double square_m2 = 0;  ///< sum
  MeanRatios nees;

  void Add(const FrameError& error);
  double PositionRmse() const;
};

/// Duration of calls [us].
struct CallTimes {
  std::vector<double> us;
  double Mean() const;
  double Percentile(double share) const;
};

struct LiveStateFigures {
  std::string name;
  int num_runs = 0;
  StateErrors frames;       ///< causal states at the frames
  StateErrors predictions;  ///< PredictAt after every IMU sample
  StateErrors smoothed;     ///< the same with smoothing; its covariance is the estimate's
  double largest_held_back_m = 0;
  double largest_step_m =
      0;  ///< beyond what the velocity explains, from sample to sample, smoothed
  double largest_jump_m = 0;  ///< the same without smoothing
  CallTimes predict, add_imu, add_frame;

  double RmseRatio() const { return predictions.PositionRmse() / frames.PositionRmse(); }
  /// How far apart the NEES of predictions and frames are, as a share of the frames'.
  double NeesDeviation(StatePart part) const;
};

/// All seeds of one scenario.
LiveStateFigures StudyLiveState(const Scenario& scenario, const LiveStateOptions& options);

/// Text for a terminal.
void PrintFigures(const LiveStateFigures& figures);

}  // namespace facet
