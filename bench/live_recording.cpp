// SPDX-License-Identifier: BSD-2-Clause
// live_recording RECORDING [--seconds S] [--smoothing S] [--two-threads]
// A recording at its own speed through LiveVio: the IMU, the images (decoded before) and a
// controller on a thread each. Is the state that the controller gets 200 times a second as exact as
// the frames'?
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "program.h"
#include <CLI/CLI.hpp>

#include "facet/eval/ground_truth.h"
#include "facet/eval/trajectory_error.h"
#include "facet/io/errors.h"
#include "facet/live/live_vio.h"
#include "facet/recording/frame_decoder.h"
#include "facet/recording/open_recording.h"

namespace facet {
namespace {

using Clock = std::chrono::steady_clock;

struct Stretch {
  std::vector<ImuSample> imu;
  std::vector<StereoFrame> frames;
};

Stretch Load(Recording& recording, double seconds) {
  Stretch stretch;
  FrameDecoder decoder(recording.calibration()->rig);
  while (const auto event = recording.Next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      stretch.imu.push_back(*sample);
      continue;
    }
    const auto& frame = std::get<RecordedFrame>(*event);
    if (!stretch.frames.empty() && ToSeconds(frame.t - stretch.frames[0].t) > seconds) break;
    StereoFrame images{frame.t, {}, {}};
    decoder.Decode(frame, images.left, images.right);
    stretch.frames.push_back(images);
  }
  if (stretch.frames.empty() || stretch.imu.empty()) throw InputError("no images, or no IMU");
  std::erase_if(stretch.imu, [&](const ImuSample& s) { return s.t < stretch.frames[0].t; });
  return stretch;
}

struct Answers {
  std::vector<StampedPose> poses;
  std::vector<double> us, age_ms;
  int num_empty = 0;
};

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Plays the stretch; `frames` gets the causal poses.
Answers Play(const Stretch& stretch,
             const Calibration& calibration,
             const LiveOptions& options,
             std::vector<StampedPose>& frames) {
  LiveVio live(
      calibration.rig, calibration.imu_noise, VioOptions{}, options, [&](const VioOutput& output) {
        if (output.has_pose) frames.push_back({output.t, output.state.T_WB});
      });
  const Timestamp first = stretch.frames[0].t;
  const Clock::time_point start = Clock::now();
  const auto wait_for = [&](Timestamp t) {
    std::this_thread::sleep_until(start + std::chrono::nanoseconds((t - first).ns));
  };
  std::thread imu([&] {
    for (const ImuSample& sample : stretch.imu) {
      wait_for(sample.t);
      live.AddImu(sample);
    }
  });
  std::thread images([&] {
    for (const StereoFrame& frame : stretch.frames) {
      wait_for(frame.t);
      live.AddStereo(frame);
    }
  });
  Answers answers;
  constexpr Duration kPeriod{5'000'000};
  for (Timestamp t = first; t < stretch.frames.back().t; t = t + kPeriod) {
    wait_for(t);
    const auto begin = Clock::now();
    const auto state = live.PredictAt(t + calibration.rig.time_offset);
    answers.us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    if (!state) {
      ++answers.num_empty;
      continue;
    }
    answers.poses.push_back({t, state->T_WF});
    answers.age_ms.push_back(1e3 * ToSeconds(state->since_frame));
  }
  imu.join();
  images.join();
  live.Finish();
  const LiveCounts counts = live.counts();
  std::printf(
      "%lld pairs, %lld dropped, %lld without the sample after them; latency up to %.1f ms\n",
      static_cast<long long>(counts.frames),
      static_cast<long long>(counts.dropped_frames),
      static_cast<long long>(counts.late_imu_frames),
      1e3 * counts.max_latency_s);
  return answers;
}

int Main(int argc, char** argv) {
  CLI::App app("A recording at its own speed, with a controller that asks 200 times a second");
  std::string sequence;
  double seconds = 16;
  LiveOptions options;
  app.add_option("RECORDING", sequence, "with ground truth")->required();
  app.add_option("--seconds", seconds, "of it")->check(CLI::Range(1.0, 60.0));
  app.add_option("--smoothing", options.prediction.smoothing_s, "of corrections [s]")
      ->check(CLI::Range(0.0, 10.0));
  app.add_flag("--two-threads", options.two_threads, "as LiveOptions");
  CLI11_PARSE(app, argc, argv);
  const std::unique_ptr<Recording> recording = OpenRecording(sequence);
  const std::vector<StampedPose> truth = LoadGroundTruth(sequence).poses;
  const Stretch stretch = Load(*recording, seconds);
  std::vector<StampedPose> frames;
  const Answers answers = Play(stretch, *recording->calibration(), options, frames);

  const Association of_frames = Associate(frames, truth),
                    of_answers = Associate(answers.poses, truth);
  if (of_frames.pairs.empty() || of_answers.pairs.empty()) throw InputError("no pose with truth");
  const TrajectoryAlignment alignment = AlignPairs(of_frames.pairs, AlignmentKind::kSE3);
  const double frames_m = Summarize(AbsoluteErrors(of_frames.pairs, alignment)).rmse;
  const double answers_m = Summarize(AbsoluteErrors(of_answers.pairs, alignment)).rmse;
  std::printf("position rmse: %zu frames %.2f mm, %zu answers %.2f mm, ratio %.3f\n",
              of_frames.pairs.size(),
              1e3 * frames_m,
              of_answers.pairs.size(),
              1e3 * answers_m,
              answers_m / frames_m);
  std::printf("age of answers: median %.1f ms, 99 %% within %.1f; %d without an answer\n",
              Percentile(answers.age_ms, 0.5),
              Percentile(answers.age_ms, 0.99),
              answers.num_empty);
  std::printf("a call: median %.1f us, 99 %% within %.1f\n",
              Percentile(answers.us, 0.5),
              Percentile(answers.us, 0.99));
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("live_recording", facet::Main, argc, argv);
}
