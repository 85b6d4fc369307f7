// SPDX-License-Identifier: BSD-2-Clause
// frontend_report SEQUENCE [--set key=value]... [--dump tracks.csv]
// Runs the front end alone over a recording with ground truth and reports cost, track life and the
// error of its pixels against true poses. The rotation hint comes from the true poses.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "program.h"
#include "track_residuals.h"
#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "facet/base/stage_timer.h"
#include "facet/frontend/stereo_frontend.h"
#include "facet/geometry/so3.h"
#include "facet/io/asl_dataset.h"
#include "facet/io/config_file.h"
#include "facet/io/trajectory_file.h"

namespace facet {
namespace {

struct FrameRecord {
  FrontendResult result;
  StageTimes times;
};

struct Run {
  std::vector<FrameRecord> frames;
  TrackSamples tracks;
};

std::optional<SE3> TruthAt(const Trajectory& truth, Timestamp t) {
  const auto after = std::lower_bound(
      truth.poses.begin(), truth.poses.end(), t, [](const StampedPose& p, Timestamp s) {
        return p.t < s;
      });
  if (after == truth.poses.end()) return std::nullopt;
  if (after->t == t) return after->T_WB;
  if (after == truth.poses.begin()) return std::nullopt;
  const auto before = after - 1;
  const double s = ToSeconds(t - before->t) / ToSeconds(after->t - before->t);
  return SE3(before->T_WB.q.slerp(s, after->T_WB.q), (1 - s) * before->T_WB.p + s * after->T_WB.p);
}

struct HintOptions {
  bool depth = true;
  bool translation = true;
  double gyro_bias = 0;  // rad/s about each axis, added to the true rotation
};

Run Process(AslDataset& dataset,
            const Trajectory& truth,
            const FrontendOptions& options,
            const HintOptions& hints) {
  Run run;
  StereoFrontend frontend(dataset.rig(), options);
  std::optional<SE3> T_WB_previous;
  Timestamp t_previous;
  for (std::size_t i = 0; i < dataset.frames().size(); ++i) {
    const FrameEntry& entry = dataset.frames()[i];
    StereoFrame frame{entry.t, {}, {}};
    dataset.ReadPair(i, frame.left, frame.right);
    const std::optional<SE3> T_WB = TruthAt(truth, entry.t + dataset.rig().time_offset);
    FrontendHint hint;
    if (T_WB && T_WB_previous) {
      const SE3 motion = T_WB_previous->Inverse() * *T_WB;
      const double dt = ToSeconds(entry.t - t_previous);
      hint.R_prev_now = motion.q * ExpSO3(Vector3d::Constant(hints.gyro_bias * dt));
      if (hints.translation) hint.p_prev_now = motion.p;
    }
    T_WB_previous = T_WB;
    t_previous = entry.t;
    FrameRecord record;
    record.result = frontend.Process(frame, hint, record.times);
    if (T_WB) {
      for (const FeatureObservation& o : record.result.observations.features) {
        run.tracks[o.landmark].push_back({i, *T_WB, o});
      }
    }
    run.frames.push_back(std::move(record));
  }
  return run;
}

double Mean(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v)
    sum += x;
  return v.empty() ? 0 : sum / static_cast<double>(v.size());
}

double Quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(v.size() - 1));
  std::nth_element(v.begin(), v.begin() + k, v.end());
  return v[static_cast<std::size_t>(k)];
}

void PrintRow(const char* name, const std::vector<double>& v) {
  std::printf("  %-22s %6zu %8.2f %8.2f %8.2f %8.2f %8.2f\n",
              name,
              v.size(),
              Mean(v),
              Quantile(v, 0.1),
              Quantile(v, 0.5),
              Quantile(v, 0.95),
              Quantile(v, 1));
}

void PrintFrames(const Run& run) {
  std::vector<double> out_of_view, not_found, not_returned, tracked, lost, outliers, refreshed,
      fresh, observed, ratio, all;
  std::vector<double> ordinary_ms, keyframe_ms, track_ms, detect_ms, stereo_ms;
  for (const FrameRecord& frame : run.frames) {
    const FrontendResult& r = frame.result;
    tracked.push_back(r.tracking.num_tracked);
    lost.push_back(r.tracking.num_lost());
    outliers.push_back(r.num_outliers);
    out_of_view.push_back(r.tracking.num_out_of_view);
    not_found.push_back(r.tracking.num_not_found);
    not_returned.push_back(r.tracking.num_not_returned);
    refreshed.push_back(r.tracking.num_refreshed);
    track_ms.push_back(frame.times[Stage::kTrack]);
    all.push_back(frame.times.Total());
    if (!r.observations.is_keyframe) {
      ordinary_ms.push_back(frame.times.Total());
      continue;
    }
    keyframe_ms.push_back(frame.times.Total());
    detect_ms.push_back(frame.times[Stage::kDetect]);
    stereo_ms.push_back(frame.times[Stage::kStereo]);
    fresh.push_back(r.num_new);
    const auto size = static_cast<double>(r.observations.features.size());
    observed.push_back(size);
    ratio.push_back(size > 0 ? 100 * r.num_stereo / size : 0);
  }
  std::printf("per frame                 count     mean      p10   median      p95      max\n");
  PrintRow("tracked", tracked);
  PrintRow("lost", lost);
  PrintRow("  out of view", out_of_view);
  PrintRow("  not found", not_found);
  PrintRow("  not returned", not_returned);
  PrintRow("outliers", outliers);
  PrintRow("refreshed", refreshed);
  PrintRow("new (keyframes)", fresh);
  PrintRow("observed (keyframes)", observed);
  PrintRow("with right pixel, %", ratio);
  PrintRow("ordinary frame, ms", ordinary_ms);
  PrintRow("keyframe, ms", keyframe_ms);
  PrintRow("all frames, ms", all);
  PrintRow("  track, ms", track_ms);
  PrintRow("  detect, ms", detect_ms);
  PrintRow("  stereo, ms", stereo_ms);
}

void PrintLife(const Run& run) {
  std::vector<double> life;
  for (const auto& [id, samples] : run.tracks)
    life.push_back(static_cast<double>(samples.size()));
  PrintRow("track life, frames", life);
  double weighted = 0, sum = 0;
  for (const double l : life)
    weighted += l * l, sum += l;
  std::printf("  life of the track that an observation belongs to: mean %.1f frames\n",
              weighted / std::max(1.0, sum));
}

void PrintSpread(const char* name, const std::vector<double>& v) {
  constexpr double kOutlierPx = 2;
  const Spread s = ComputeSpread(v, kOutlierPx);
  std::printf("  %-22s %7zu %8.3f %8.3f %8.3f %8.2f\n",
              name,
              s.count,
              s.mean,
              s.robust_sigma,
              s.rms,
              100 * s.outliers);
}

void PrintErrors(const std::vector<FittedTrack>& tracks) {
  std::vector<double> lx, ly, rx, ry;
  for (const FittedTrack& track : tracks) {
    for (const TrackResidual& r : track.residuals) {
      lx.push_back(r.left_px.x());
      ly.push_back(r.left_px.y());
      if (!r.right_px) continue;
      rx.push_back(r.right_px->x());
      ry.push_back(r.right_px->y());
    }
  }
  std::printf("residuals, px            count     mean  rob.sig  rms(<2)  >2px,%%\n");
  PrintSpread("left x", lx);
  PrintSpread("left y", ly);
  PrintSpread("right x", rx);
  PrintSpread("right y", ry);
  std::size_t bad = 0;
  for (const FittedTrack& track : tracks) {
    std::vector<double> norms;
    for (const TrackResidual& r : track.residuals)
      norms.push_back(r.left_px.norm());
    bad += Quantile(norms, 0.5) > 1.5 ? 1 : 0;
  }
  std::printf("  bad tracks (median residual > 1.5 px): %zu of %zu\n", bad, tracks.size());
}

// By the sigma that the front end claimed: does it tell good from bad?
void PrintClaims(const std::vector<FittedTrack>& tracks) {
  std::map<int, std::vector<double>> left, right;
  for (const FittedTrack& track : tracks) {
    for (const TrackResidual& r : track.residuals) {
      for (int k = 0; k < 2; ++k) {
        left[static_cast<int>(std::lround(20 * r.sigma_left_px))].push_back(r.left_px[k]);
        if (r.right_px)
          right[static_cast<int>(std::lround(20 * r.sigma_right_px))].push_back((*r.right_px)[k]);
      }
    }
  }
  std::printf("by claimed sigma         count     mean  rob.sig  rms(<2)  >2px,%%\n");
  for (const auto& [k, v] : left)
    PrintSpread(("left " + std::to_string(0.05 * k).substr(0, 4)).c_str(), v);
  for (const auto& [k, v] : right)
    PrintSpread(("right " + std::to_string(0.05 * k).substr(0, 4)).c_str(), v);
}

void PrintGrowth(const std::vector<FittedTrack>& tracks) {
  const std::vector<int> limits = {1, 2, 3, 5, 9, 17, 33, 65, 129, 1000};
  std::vector<std::vector<double>> change(limits.size());
  for (const FittedTrack& track : tracks) {
    const TrackResidual& first = track.residuals.front();
    for (const TrackResidual& r : track.residuals) {
      if (r.age == 0) continue;
      const auto bin = std::lower_bound(limits.begin(), limits.end(), r.age) - limits.begin();
      const Vector2d d = r.left_px - first.left_px;
      auto& values = change[static_cast<std::size_t>(bin)];
      values.push_back(d.x());
      values.push_back(d.y());
    }
  }
  std::printf("left error minus error in the first frame, by age\n");
  for (std::size_t b = 0; b < limits.size(); ++b) {
    if (change[b].empty()) continue;
    PrintSpread(("age <= " + std::to_string(limits[b])).c_str(), change[b]);
  }
}

void PrintAutocorrelation(const std::vector<FittedTrack>& tracks) {
  constexpr int kMaxLag = 10;
  constexpr double kOutlierPx = 2;
  double variance[kMaxLag + 1] = {}, covariance[kMaxLag + 1] = {}, step[kMaxLag + 1] = {};
  std::size_t count[kMaxLag + 1] = {};
  for (const FittedTrack& track : tracks) {
    if (track.residuals.size() < 20) continue;
    for (std::size_t i = 0; i < track.residuals.size(); ++i) {
      for (std::size_t k = 0; k <= kMaxLag && i + k < track.residuals.size(); ++k) {
        const TrackResidual &a = track.residuals[i], &b = track.residuals[i + k];
        if (b.frame - a.frame != k || a.left_px.norm() > kOutlierPx ||
            b.left_px.norm() > kOutlierPx)
          continue;
        covariance[k] += a.left_px.dot(b.left_px);
        variance[k] += 0.5 * (a.left_px.squaredNorm() + b.left_px.squaredNorm());
        step[k] += 0.5 * (a.left_px - b.left_px).squaredNorm();
        ++count[k];
      }
    }
  }
  std::printf("autocorrelation of the left error (tracks of 20 frames or more)\n  lag ");
  for (int k = 1; k <= kMaxLag; ++k)
    std::printf("%7d", k);
  std::printf("\n  rho ");
  for (int k = 1; k <= kMaxLag; ++k)
    std::printf("%7.2f", covariance[k] / std::max(1e-12, variance[k]));
  std::printf("\n  rms step per axis, px ");
  for (int k = 1; k <= kMaxLag; ++k)
    std::printf("%7.3f",
                std::sqrt(step[k] / static_cast<double>(std::max<std::size_t>(1, count[k]))));
  std::printf("\n");
}

void Dump(const Run& run, const std::string& file) {
  std::ofstream out(file);
  out << "frame,landmark,u,v,ur,vr,keyframe\n";
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const FrameObservations& frame = run.frames[i].result.observations;
    for (const FeatureObservation& o : frame.features) {
      const Vector2d right = o.px_right.value_or(Vector2d(-1, -1));
      out << i << ',' << o.landmark.value << ',' << o.px_left.x() << ',' << o.px_left.y() << ','
          << right.x() << ',' << right.y() << ',' << frame.is_keyframe << '\n';
    }
  }
}

int Main(int argc, char** argv) {
  CLI::App app("Cost, track life and pixel error of the front end");
  std::string sequence, dump;
  std::vector<std::string> overrides;
  HintOptions hints;
  int refinements = 0;
  app.add_option("sequence", sequence, "folder in ASL layout, with ground truth")->required();
  app.add_option("--set", overrides, "option of the front end, key=value");
  app.add_option("--dump", dump, "file for all observations (csv)");
  app.add_option("--gyro-bias", hints.gyro_bias, "error of the rotation hint, rad/s on each axis");
  app.add_option("--translation-hint", hints.translation, "0: rotation hint only");
  app.add_option(
      "--refine-poses", refinements, "rounds that fit the poses too, for noisy ground truth");
  CLI11_PARSE(app, argc, argv);

  cv::setNumThreads(1);  // otherwise OpenCV hides cost in other threads
  FrontendOptions options;
  ApplyOverrides(overrides, ListFields(options));
  AslDataset dataset(sequence);
  const Trajectory truth = ReadTrajectory(RequireTruth(sequence));
  Run run = Process(dataset, truth, options, hints);
  PrintFrames(run);
  PrintLife(run);
  RefinePoses(dataset.rig(), refinements, run.tracks);
  const std::vector<FittedTrack> tracks = FitTracks(dataset.rig(), run.tracks, 5);
  PrintErrors(tracks);
  PrintClaims(tracks);
  PrintGrowth(tracks);
  PrintAutocorrelation(tracks);
  if (!dump.empty()) Dump(run, dump);
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("frontend_report", facet::Main, argc, argv);
}
