// SPDX-License-Identifier: BSD-2-Clause
// laps SEQUENCE... [--hours H | --laps N] [--set key=value]...
// Plays a closed sequence, or in turn several that differ in their noise, again and again to one
// pipeline and prints for each lap its ATE, the memory of the process, and every alarm: on clean
// data there should be none, the memory should stay level, and the later laps should be as good as
// the first ones. Exit code 1 if not. What is learnt in the course of hours from one sequence alone
// is where its noise leads, which is the same in every lap.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lap.h"
#include "program.h"
#include <CLI/CLI.hpp>
#include <malloc.h>
#include <opencv2/core/utility.hpp>
#include <unistd.h>

#include "facet/eval/trajectory_error.h"
#include "facet/io/asl_dataset.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/io/trajectory_file.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/sim/euroc_csv.h"

namespace facet {
namespace {

constexpr double kSettled_s = 300;   // memory is compared from then on
constexpr double kMaxGrowth_mb = 2;  // without the map
constexpr double kMaxAteRatio = 2;   // of a lap to the median of all laps
constexpr double kMaxTrend = 1.25;   // of the median ATE of the second half to that of the first
constexpr std::size_t kMinLapsOfTrend = 16;

/// Everything that should not happen on clean data, by what is said of it.
class Alarms {
 public:
  void Add(const VioOutput& output) {
    if (output.status == TrackingStatus::kInitialising && !has_begun_) return;
    has_begun_ = true;
    if (output.status != TrackingStatus::kOk)
      Count(std::string(ToString(output.status)) + ": " + output.reason);
    if (!output.has_pose) Count("no pose");
    if (output.was_reset) Count("new segment");
    if (output.is_image_repeated) Count("image called repeated");
    if (output.imu_gaps > 0) Count("hole in the IMU");
    if (!output.warning.empty()) Count(output.warning);
  }

  void Add(const RunResult& result) {
    CountUpTo("IMU sample cut out", result.imu_screen.num_cut);
    CountUpTo("IMU sample called saturated", result.imu_screen.num_saturated);
    CountUpTo("IMU sample called repeated", result.imu_screen.num_repeated);
    CountUpTo("IMU sample refused", result.num_refused_imu);
  }

  int Total() const {
    int total = 0;
    for (const auto& [text, count] : counts_)
      total += count;
    return total;
  }

  void Print() const {
    for (const auto& [text, count] : counts_)
      std::printf("alarm: %d x %s\n", count, text.c_str());
  }

 private:
  void Count(const std::string& text) { ++counts_[text]; }
  void CountUpTo(const std::string& text, int count) {
    if (count > 0) counts_[text] = count;
  }

  bool has_begun_ = false;
  std::map<std::string, int> counts_;
};

struct LapFigures {
  double end_s = 0, ate_m = 0, cpu_ms = 0;
  double heap_mb = 0, rss_mb = 0, map_mb = 0;
  double OwnMemory() const { return heap_mb - map_mb; }
};

double HeapMb() {
  const struct mallinfo2 info = mallinfo2();
  return 1e-6 * static_cast<double>(info.uordblks + info.hblkhd);
}

double RssMb() {
  std::ifstream stream("/proc/self/statm");
  double size = 0, resident = 0;
  stream >> size >> resident;
  return 1e-6 * resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

std::vector<Timestamp> StampsOf(const AslDataset& dataset) {
  std::vector<Timestamp> stamps;
  for (const auto& frame : dataset.frames())
    stamps.push_back(frame.t);
  return stamps;
}

/// One sequence that can be played as any lap. Its images are decoded again each time: all of them
/// would be half a gigabyte. Not thread-safe.
class Take {
 public:
  Take(const std::string& sequence, const std::optional<ImuBias>& bias)
      : sequence_(sequence),
        dataset_(sequence),
        lap_(StampsOf(dataset_), dataset_.imu(), LoadGroundTruthCsv(RequireTruth(sequence)), bias) {
  }

  const std::string& sequence() const { return sequence_; }
  const AslDataset& dataset() const { return dataset_; }
  const Lap& lap() const { return lap_; }

  StereoFrame Frame(int i) {
    const auto index = static_cast<std::size_t>(i);
    StereoFrame frame{dataset_.frames()[index].t, {}, {}};
    const std::string problem = dataset_.ReadPair(index, frame.left, frame.right);
    if (!problem.empty()) throw InputError(problem);
    return frame;
  }

 private:
  std::string sequence_;
  AslDataset dataset_;
  Lap lap_;
};

/// Throws InputError if they are not the same motion.
void RequireSameMotion(const Take& first, const Take& other) {
  constexpr double kMost_m = 1e-3;
  const auto of_first = LoadGroundTruthCsv(RequireTruth(first.sequence()));
  const auto of_other = LoadGroundTruthCsv(RequireTruth(other.sequence()));
  bool is_same =
      StampsOf(first.dataset()) == StampsOf(other.dataset()) && of_first.size() == of_other.size();
  for (std::size_t i = 0; is_same && i < of_first.size(); ++i)
    is_same = (of_first[i].T_WB.p - of_other[i].T_WB.p).norm() < kMost_m;
  if (!is_same)
    throw InputError(other.sequence() + ": its motion is not that of " + first.sequence());
}

std::vector<Take> OpenTakes(const std::vector<std::string>& sequences) {
  std::vector<Take> takes;
  for (const std::string& sequence : sequences) {
    takes.emplace_back(
        sequence, takes.empty() ? std::nullopt : std::make_optional(takes.front().lap().bias()));
    RequireSameMotion(takes.front(), takes.back());
  }
  return takes;
}

double AteOf(const std::vector<StampedPose>& poses, const std::vector<StampedPose>& truth) {
  const Association association = Associate(poses, truth);
  if (association.pairs.size() < 3) return NAN;
  const auto alignment = AlignPairs(association.pairs, AlignmentKind::kSE3);
  return Summarize(AbsoluteErrors(association.pairs, alignment)).rmse;
}

/// Plays laps to one pipeline. Not thread-safe.
class Player {
 public:
  Player(std::vector<Take> takes, const VioOptions& options)
      : takes_(std::move(takes)),
        truth_(ReadTrajectory(RequireTruth(takes_.front().sequence())).poses),
        vio_(takes_.front().dataset().rig(), takes_.front().dataset().imu_noise(), options) {}

  Alarms& alarms() { return alarms_; }

  LapFigures PlayNext() {
    std::vector<StampedPose> poses;
    LapFigures figures;
    Take& take = TakeOf(num_laps_);
    const Lap& lap = take.lap();
    for (int i = 0; i < lap.num_frames(); ++i) {
      StereoFrame frame = take.Frame(i);
      const Timestamp in_first_lap = frame.t;
      frame.t = lap.FrameStamp(num_laps_, i);
      FeedImu(frame.t);
      const VioOutput output = vio_.AddStereo(frame);
      alarms_.Add(output);
      figures.cpu_ms += output.times.Total() / lap.num_frames();
      if (output.has_pose) poses.push_back({in_first_lap, output.state.T_WB});
    }
    ++num_laps_;
    figures.end_s = num_laps_ * ToSeconds(lap.period());
    figures.ate_m = AteOf(poses, truth_);
    poses = {};
    figures.heap_mb = HeapMb();
    figures.rss_mb = RssMb();
    const RunResult result = vio_.Result();
    alarms_.Add(result);
    figures.map_mb = result.map_memory.used_mb;
    return figures;
  }

 private:
  Take& TakeOf(int lap) { return takes_[static_cast<std::size_t>(lap) % takes_.size()]; }

  /// The samples up to the stamp, and one beyond it.
  void FeedImu(Timestamp t) {
    while (last_imu_ <= t) {
      if (next_imu_ == imu_.size()) {
        imu_ = TakeOf(num_imu_laps_).lap().ImuOf(num_imu_laps_);
        ++num_imu_laps_;
        next_imu_ = 0;
      }
      last_imu_ = imu_[next_imu_].t;
      vio_.AddImu(imu_[next_imu_++]);
    }
  }

  std::vector<Take> takes_;
  std::vector<StampedPose> truth_;
  VioPipeline vio_;
  Alarms alarms_;
  int num_laps_ = 0, num_imu_laps_ = 0;
  std::vector<ImuSample> imu_;
  std::size_t next_imu_ = 0;
  Timestamp last_imu_;
};

/// What the memory gained after it had settled; zero for a short run.
double GrowthMb(std::span<const LapFigures> laps) {
  const auto settled = std::find_if(
      laps.begin(), laps.end(), [](const LapFigures& lap) { return lap.end_s >= kSettled_s; });
  if (settled == laps.end()) return 0;
  double largest = settled->OwnMemory();
  for (auto lap = settled; lap != laps.end(); ++lap)
    largest = std::max(largest, lap->OwnMemory());
  return largest - settled->OwnMemory();
}

/// Sorted.
std::vector<double> AtesOf(std::span<const LapFigures> laps) {
  std::vector<double> ates;
  for (const LapFigures& lap : laps)
    ates.push_back(lap.ate_m);
  std::sort(ates.begin(), ates.end());
  return ates;
}

double MedianAte(std::span<const LapFigures> laps) {
  return AtesOf(laps)[laps.size() / 2];
}

bool Judge(std::span<const LapFigures> laps, const Alarms& alarms) {
  for (const LapFigures& lap : laps) {
    if (std::isfinite(lap.ate_m)) continue;
    std::printf("a lap has no poses\n");
    return false;
  }
  const std::vector<double> ates = AtesOf(laps);
  const double median = MedianAte(laps), growth = GrowthMb(laps);
  const double early = MedianAte(laps.first(std::max<std::size_t>(1, laps.size() / 2)));
  const double late = MedianAte(laps.subspan(laps.size() / 2));
  alarms.Print();
  std::printf(
      "%zu laps, %.4f h: ATE per lap %.2f to %.2f mm, median %.2f (first half %.2f, second half "
      "%.2f); memory without the map +%.2f MB after the first %.0f s; %d alarms\n",
      laps.size(),
      laps.back().end_s / 3600,
      1e3 * ates.front(),
      1e3 * ates.back(),
      1e3 * median,
      1e3 * early,
      1e3 * late,
      growth,
      kSettled_s,
      alarms.Total());
  const bool is_level = laps.size() < kMinLapsOfTrend || late <= kMaxTrend * early;
  return is_level && ates.back() <= kMaxAteRatio * median && growth <= kMaxGrowth_mb &&
         alarms.Total() == 0;
}

int Main(int argc, char** argv) {
  CLI::App app("The same closed lap again and again: alarms, memory, accuracy");
  std::vector<std::string> sequences;
  double hours = 2;
  int num_laps = 0, print_every = 1;
  std::vector<std::string> overrides;
  app.add_option("sequence",
                 sequences,
                 "folders in ASL layout whose ends join their beginnings, with the same motion")
      ->required();
  app.add_option("--hours", hours, "of data");
  app.add_option("--laps", num_laps, "instead of hours");
  app.add_option("--print-every", print_every, "laps")->check(CLI::PositiveNumber);
  app.add_option("--set", overrides, "option of the pipeline, key=value");
  CLI11_PARSE(app, argc, argv);

  cv::setNumThreads(1);
  VioOptions options;
  ApplyOverrides(overrides, ListFields(options));
  std::vector<Take> takes = OpenTakes(sequences);
  const double period_h = ToSeconds(takes.front().lap().period()) / 3600;
  Player player(std::move(takes), options);
  if (num_laps == 0) num_laps = std::max(1, static_cast<int>(std::ceil(hours / period_h - 1e-9)));
  std::vector<LapFigures> laps;
  std::printf("  lap    end[s]  ATE[mm]  cpu[ms]   heap[MB]  map[MB]  resident[MB]  alarms\n");
  for (int i = 0; i < num_laps; ++i) {
    laps.push_back(player.PlayNext());
    const LapFigures& lap = laps.back();
    if (i % print_every != 0 && i + 1 != num_laps) continue;
    std::printf("%5d %9.0f %8.2f %8.2f %10.3f %8.3f %13.1f %7d\n",
                i,
                lap.end_s,
                1e3 * lap.ate_m,
                lap.cpu_ms,
                lap.heap_mb,
                lap.map_mb,
                lap.rss_mb,
                player.alarms().Total());
    std::fflush(stdout);
  }
  return Judge(laps, player.alarms()) ? 0 : 1;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("laps", facet::Main, argc, argv);
}
