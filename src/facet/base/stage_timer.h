// SPDX-License-Identifier: BSD-2-Clause
// CPU time of the calling thread, by stage of the pipeline.
#pragma once

#include <array>
#include <cstddef>

namespace facet {

/// Stages of one stereo frame, in the order of timing.csv.
enum class Stage {
  kDecode,
  kTrack,
  kStereo,
  kDetect,
  kImu,
  kOptimize,
  kMarginalize,
  kMesh,
  kRegularities,
  kOutput,
  kCount
};

inline constexpr std::size_t kNumStages = static_cast<std::size_t>(Stage::kCount);
inline constexpr std::array<const char*, kNumStages> kStageNames = {"decode",
                                                                    "track",
                                                                    "stereo",
                                                                    "detect",
                                                                    "imu",
                                                                    "optimize",
                                                                    "marginalize",
                                                                    "mesh",
                                                                    "regularities",
                                                                    "output"};

/// Thread CPU time in milliseconds.
double ThreadCpuMs();

/// Milliseconds spent in each stage of one frame.
struct StageTimes {
  std::array<double, kNumStages> ms{};
  double& operator[](Stage s) { return ms[static_cast<std::size_t>(s)]; }
  double operator[](Stage s) const { return ms[static_cast<std::size_t>(s)]; }
  double Total() const {
    double sum = 0;
    for (double m : ms)
      sum += m;
    return sum;
  }
};

/// Adds the CPU time between construction and destruction to one stage.
class ScopedStage {
 public:
  ScopedStage(StageTimes& times, Stage stage)
      : times_(times), stage_(stage), start_ms_(ThreadCpuMs()) {}
  ScopedStage(const ScopedStage&) = delete;
  ScopedStage& operator=(const ScopedStage&) = delete;
  ~ScopedStage() { times_[stage_] += ThreadCpuMs() - start_ms_; }

 private:
  StageTimes& times_;
  Stage stage_;
  double start_ms_;
};

}  // namespace facet
