// SPDX-License-Identifier: BSD-2-Clause
// Question: which stage does the error of pipeline S on a simulated sequence come from, and which
//   tracks hold it? Tracked pixels are replaced by the truth, all of them or those of one kind of
//   ground; the errors of the others are told by what they lie on. The point of a track is where
//   the ray of its first left pixel meets the true mesh. With planes (--set pipeline=SPR --set
//   mesh.enabled=true) it also tells how far their landmarks truly are from them.
// Command: true_stages SEQUENCE [--left exact] [--right exact] [--noise PX] [--set key=value]...
// Answer: with exact pixels 0.01 mm are left, so the error is that of the tracks, and no kind of
//   track alone has it (docs/notebook/tracking_limits.md). A fifth of the landmarks on planes are 3
//   to 30 mm in front of their wall (docs/notebook/planes_common_error.md).
// Date: 2026-11-21 to 2026-11-23.
#include <algorithm>
#include <bit>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <unordered_map>
#include <vector>

#include "bench/program.h"
#include "bench/track_residuals.h"
#include "plane_members.h"
#include "true_run.h"
#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "facet/base/random.h"
#include "facet/eval/trajectory_error.h"

namespace facet {
namespace {

struct TrueTrack {
  ScenePoint point;
  int age = 0;
};

struct Errors {
  std::vector<double> left, right;
};

struct Replacement {
  bool left = false, right = false;
  double noise_px = 0;
  std::vector<std::string> exact_on;  ///< names of Grounds; empty: all
  std::vector<std::string> only;      ///< others are dropped; empty: none is
};

bool IsAmong(const std::vector<std::string>& names, Ground ground) {
  const char* name = kGroundNames[static_cast<std::size_t>(ground)];
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

/// Errors of the tracked pixels, and the observations with true ones instead.
class PixelJudge {
 public:
  PixelJudge(const StereoRig& rig, const TrueScene& scene, const Replacement& replacement)
      : rig_(rig), scene_(scene), replacement_(replacement) {}

  void Replace(const SE3& T_WB, FrameObservations& frame, std::ostream* dump) {
    std::vector<FeatureObservation> kept;
    for (FeatureObservation o : frame.features) {
      auto track = tracks_.find(o.landmark);
      if (track == tracks_.end()) {
        const auto found = scene_.Find(rig_, T_WB, o.px_left);
        if (!found) continue;
        track = tracks_.emplace(o.landmark, TrueTrack{*found, 0}).first;
      }
      ++track->second.age;
      const ScenePoint& point = track->second.point;
      const auto left = ProjectInto(0, T_WB, point.p_W), right = ProjectInto(1, T_WB, point.p_W);
      if (!left) continue;
      Count(track->second, *left, right, o);
      if (dump) {
        const Vector2d error = *left - o.px_left;
        *dump << frame.frame.value << ',' << o.landmark.value << ',' << track->second.age << ','
              << kGroundNames[static_cast<std::size_t>(point.ground)] << ',' << point.plane << ','
              << o.px_left.x() << ',' << o.px_left.y() << ',' << error.x() << ',' << error.y();
        DumpRight(T_WB, o, right, *dump);
      }
      if (!IsAmong(replacement_.only, point.ground)) continue;
      const bool is_exact = IsAmong(replacement_.exact_on, point.ground);
      if (replacement_.left && is_exact) o.px_left = *left + Noise();
      if (replacement_.right && is_exact && o.px_right) {
        o.px_right.reset();
        if (right) o.px_right = *right + Noise();
      }
      kept.push_back(o);
    }
    frame.features = kept;
  }

  /// Where a landmark was seen first; null if its ray met nothing.
  const ScenePoint* PointOf(LandmarkId landmark) const {
    const auto track = tracks_.find(landmark);
    return track == tracks_.end() ? nullptr : &track->second.point;
  }

  void Print() const {
    std::printf("left error by ground     count     mean  rob.sig  rms(<2)  >2px,%%\n");
    for (const auto& [ground, errors] : by_ground_)
      PrintRow(kGroundNames[static_cast<std::size_t>(ground)], errors.left);
    std::printf("left error by age on flat ground\n");
    for (const auto& [age, errors] : by_age_)
      PrintRow(("age < " + std::to_string(1 << age)).c_str(), errors);
    std::printf("right error by ground\n");
    for (const auto& [ground, errors] : by_ground_)
      PrintRow(kGroundNames[static_cast<std::size_t>(ground)], errors.right);
  }

 private:
  std::optional<Vector2d> ProjectInto(std::size_t camera,
                                      const SE3& T_WB,
                                      const Vector3d& p_W) const {
    return rig_.cameras[camera].Project((T_WB * rig_.T_BC[camera]).Inverse() * p_W);
  }

  // The error of the right pixel, and of its match alone: from where the place that the left pixel
  // shows now must be seen.
  void DumpRight(const SE3& T_WB,
                 const FeatureObservation& o,
                 const std::optional<Vector2d>& right,
                 std::ostream& dump) const {
    const auto shown = scene_.Find(rig_, T_WB, o.px_left);
    const auto matched = shown ? ProjectInto(1, T_WB, shown->p_W) : std::nullopt;
    if (o.px_right && right && matched) {
      const Vector2d error = *right - *o.px_right, of_match = *matched - *o.px_right;
      dump << ',' << error.x() << ',' << error.y() << ',' << of_match.x() << ',' << of_match.y();
    } else {
      dump << ",,,,";
    }
    dump << '\n';
  }

  Vector2d Noise() { return replacement_.noise_px * Vector2d(rng_.Normal(), rng_.Normal()); }

  void Count(const TrueTrack& track,
             const Vector2d& left,
             const std::optional<Vector2d>& right,
             const FeatureObservation& o) {
    Errors& errors = by_ground_[track.point.ground];
    if (track.age > 1) {
      const int bin = static_cast<int>(std::bit_width(static_cast<unsigned>(track.age)));
      for (int k = 0; k < 2; ++k) {
        errors.left.push_back(left(k) - o.px_left(k));
        if (track.point.ground == Ground::kFlat) by_age_[bin].push_back(left(k) - o.px_left(k));
      }
    }
    for (int k = 0; k < 2 && right && o.px_right; ++k)
      errors.right.push_back((*right)(k) - (*o.px_right)(k));
  }

  static void PrintRow(const char* name, const std::vector<double>& errors) {
    const Spread s = ComputeSpread(errors, 2);
    std::printf("  %-22s %7zu %8.3f %8.3f %8.3f %8.2f\n",
                name,
                s.count,
                s.mean,
                s.robust_sigma,
                s.rms,
                100 * s.outliers);
  }

  const StereoRig& rig_;
  const TrueScene& scene_;
  Replacement replacement_;
  Rng rng_{1};
  std::unordered_map<LandmarkId, TrueTrack> tracks_;
  std::map<Ground, Errors> by_ground_;
  std::map<int, std::vector<double>> by_age_;
};

void Process(const std::string& sequence,
             const VioOptions& options,
             const Replacement& what,
             const std::string& dump_file) {
  std::ofstream dump(dump_file);
  if (!dump_file.empty())
    dump << "frame,landmark,age,ground,plane,x,y,error_x,error_y,right_x,right_y,match_x,match_y\n";
  TrueSequence run(sequence);
  PlaneMembers members(sequence);
  PixelJudge judge(run.exact_rig, run.scene, what);
  std::vector<StampedPose> estimate;
  const auto replace = [&](const SE3& T_WB, FrameObservations& frame) {
    judge.Replace(T_WB, frame, dump_file.empty() ? nullptr : &dump);
  };
  RunStages(run, options, replace, [&](const VioOutput& out) {
    if (out.has_pose) estimate.push_back({out.t, out.state.T_WB});
    if (out.snapshot) members.Add(*out.snapshot);
  });
  const TrajectoryError error = EvaluateTrajectory(estimate, run.truth.poses);
  std::printf("left %s, right %s: ATE rmse %.3f mm, %zu of %zu poses\n",
              what.left ? "exact" : "tracked",
              what.right ? "exact" : "tracked",
              1e3 * error.ate_m.rmse,
              estimate.size(),
              run.dataset.frames().size());
  judge.Print();
  members.Print([&](LandmarkId landmark) { return judge.PointOf(landmark); });
}

int Main(int argc, char** argv) {
  CLI::App app("Pipeline S with tracked pixels replaced by the truth of a simulated sequence");
  std::string sequence, dump, left = "tracked", right = "tracked";
  std::vector<std::string> overrides;
  Replacement what;
  app.add_option("sequence", sequence, "made by facet simulate")->required();
  app.add_option("--left", left)->check(CLI::IsMember({"tracked", "exact"}));
  app.add_option("--right", right)->check(CLI::IsMember({"tracked", "exact"}));
  app.add_option("--noise", what.noise_px, "1-sigma, added to exact pixels");
  app.add_option("--only", what.only, "flat, curved, crease, 'depth edge': drop other tracks");
  app.add_option("--exact-on", what.exact_on, "the same: exact pixels on these only");
  app.add_option("--dump", dump, "file for the errors (csv)");
  app.add_option("--set", overrides, "option of the pipeline, key=value");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  what.left = left == "exact";
  what.right = right == "exact";
  Process(sequence, OptionsOfS(overrides), what, dump);
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("true_stages", facet::Main, argc, argv);
}
