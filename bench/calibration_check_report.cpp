// SPDX-License-Identifier: BSD-2-Clause
// calibration_check_report SEQUENCE [--every SECONDS]
// Runs the check of the calibration alone over a recording, from many starts, and reports after how
// many seconds it refuses the calibration or is convinced of it, and what that cost.
#include <cstdio>
#include <string>
#include <vector>

#include "program.h"
#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "facet/base/stage_timer.h"
#include "facet/frontend/frontend_options.h"
#include "facet/frontend/image_pyramid.h"
#include "facet/frontend/stereo_frontend.h"
#include "facet/io/asl_dataset.h"
#include "facet/plausibility/calibration_check.h"

namespace facet {
namespace {

void RunFrom(std::size_t begin,
             const AslDataset& dataset,
             const ImuBuffer& imu,
             const std::vector<StereoFrame>& frames) {
  CalibrationCheck check(dataset.rig());
  PyramidPair left;
  const double cpu_start_ms = ThreadCpuMs();
  std::string refusal;
  std::size_t i = begin + 1;
  for (; i < frames.size() && refusal.empty() && !check.IsDone(); ++i) {
    const Duration offset = dataset.rig().time_offset;
    const ImuInterval interval = imu.Between(
        frames[i - 1].t + offset, frames[i].t + offset, Duration{21'000'000}, Duration{30'000'000});
    left.Build(frames[i].left, FrontendOptions().klt.num_levels);
    refusal = check.Add(&left, interval);
  }
  std::printf("%6.1f s: %s after %.2f s, %d images followed, %.0f ms CPU. %s\n",
              ToSeconds(frames[begin].t - frames[0].t),
              !refusal.empty() ? "refused  "
              : check.IsDone() ? "convinced"
                               : "undecided",
              ToSeconds(frames[i - 1].t - frames[begin].t),
              check.num_followed(),
              ThreadCpuMs() - cpu_start_ms,
              refusal.c_str());
}

void Report(const std::string& sequence, double every_s) {
  AslDataset dataset(sequence);
  ImuBuffer imu;
  for (const ImuSample& sample : dataset.imu())
    imu.Add(sample);
  std::vector<StereoFrame> frames;
  for (std::size_t i = 0; i < dataset.frames().size(); ++i) {
    StereoFrame frame{dataset.frames()[i].t, {}, {}};
    dataset.ReadPair(i, frame.left, frame.right);
    frame.right.release();
    frames.push_back(frame);
  }
  double next_s = 0;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    const double t_s = ToSeconds(frames[i].t - frames[0].t);
    if (t_s < next_s) continue;
    next_s += every_s;
    RunFrom(i, dataset, imu, frames);
  }
}

int Main(int argc, char** argv) {
  cv::setNumThreads(1);
  CLI::App app("How soon the check of the calibration decides.");
  std::string sequence;
  double every_s = 2;
  app.add_option("sequence", sequence)->required();
  app.add_option("--every", every_s, "seconds between the starts")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  Report(sequence, every_s);
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("calibration_check_report", facet::Main, argc, argv);
}
