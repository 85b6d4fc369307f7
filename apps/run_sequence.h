// SPDX-License-Identifier: BSD-2-Clause
// The run loop: feeds a recording to the estimator and keeps what comes out.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "facet/frontend/stereo_frontend.h"
#include "facet/io/result_writer.h"
#include "facet/pipeline/run_result.h"
#include "facet/pipeline/vio_output.h"
#include "facet/recording/recording.h"

namespace facet {

/// The estimator as the loop sees it: VioPipeline, ThreadedVio, or a stand-in for tests. There is
/// one output for each frame, in order; it may come with a later call.
struct VioFunctions {
  std::function<void(const ImuSample&)> add_imu;
  std::function<std::vector<VioOutput>(const StereoFrame&)> add_stereo;
  std::function<std::vector<VioOutput>()> finish;
  std::function<RunResult()> result;
  /// When the pose of the frame with this stamp was known, which may be before its output comes;
  /// called once for each output, in order. Empty: with the output.
  std::function<std::chrono::steady_clock::time_point(Timestamp)> when_posed = nullptr;
};

/// Which part of a recording is run and how fast.
struct RunRange {
  double start_s = 0;  ///< after the first stereo pair; both borders to the millisecond
  double duration_s = std::numeric_limits<double>::infinity();
  double imu_history_s = 0;  ///< IMU from before the first frame
  bool realtime = false;     ///< at recorded speed; what arrives while busy is dropped
  /// Threads that decode the images of the next frames meanwhile, with the same results; none at
  /// recorded speed, because the next frames have not arrived.
  int num_decoders = 0;
};

enum class RunEnd {
  kComplete,
  kStopped,     ///< by the observer
  kRefused,     ///< the calibration cannot be right, or a sensor is dead
  kNotStarted,  ///< no frame got a pose
  kDamaged,     ///< the recording cannot be read to its end
  kLost         ///< the last second or more has no pose
};

struct SequenceRun {
  RunRecord record;  ///< of everything up to the end, whatever the end was
  RunEnd end = RunEnd::kComplete;
  std::string message;  ///< what happened and what to do; empty when complete
};

/// How far a run has come.
struct RunProgress {
  int num_frames = 0;    ///< so far, also those that were dropped or damaged
  int num_expected = 0;  ///< in all (about, as Recording::NumFrames)
  int num_dropped = 0;   ///< arrived while busy
  int num_damaged = 0;   ///< left image unreadable
  Timestamp first_pair;
  const FrameRecord* newest = nullptr;  ///< what is kept of the processed frame
};

/// Called after each processed frame; false stops the run.
using RunObserver = std::function<bool(const RunProgress& progress, const VioOutput& output)>;

/// Runs one part of a recording. Before each frame the IMU samples up to its stamp (plus the rig's
/// time offset) and one more are fed. A frame whose left image is unusable is skipped like a
/// missing one, however many there are in a row; one with an unusable right image becomes a mono
/// frame. Both are counted, and one warning for each camera names the first.
///
/// Reads on from where the recording stands, which must be its beginning; it must have a
/// calibration. Throws ConfigError when the part is empty, InputError when none of its left images
/// can be read or the recording is damaged before the part. The caller fills in version, pipeline,
/// threads and config.
SequenceRun RunSequence(Recording& recording,
                        const VioFunctions& vio,
                        const RunRange& range,
                        const RunObserver& observer);

}  // namespace facet
