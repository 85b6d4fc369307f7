// SPDX-License-Identifier: BSD-2-Clause
// true_warps SEQUENCE [--set key=value]...
// How exact would tracks on flat ground be if the shape of their patches were known? While pipeline
// S tracks a simulated sequence, each track's first patch is found again in later images with the
// true affine warp, shifted, turned and scaled, or free in all six parameters, beginning at the
// truth; the errors stand beside those of the tracker, for the tracks that are still followed and
// found by all ways.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "program.h"
#include "track_residuals.h"
#include "true_run.h"
#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "facet/frontend/patch_tracker.h"
#include "facet/map/observation.h"

namespace facet {
namespace {

constexpr std::array<int, 6> kAges = {1, 2, 8, 20, 40, 80};  // frames
constexpr LevelRange kFinest = {0, 0};

/// How the first patch is found again, from the true place on.
struct Way {
  const char* name;
  int num_parameters;
  bool is_true_shape;
};
constexpr std::array<Way, 4> kWays = {{{"true shape, shift", 2, true},
                                       {"true shape, + turn, scale", 4, true},
                                       {"true shape, all six", 6, true},
                                       {"similarity, + turn, scale", 4, false}}};

struct Birth {
  ScenePoint point;
  SE3 T_WC;
  Vector2d px;
  int frame = 0;
  std::array<PatchPyramid, kWays.size()> patches;
};

/// The affine map of pixels around a point of a plane, from the camera at its birth to that at
/// T_WC.
std::optional<PatchWarp> TrueWarp(const CameraModel& camera, const Birth& birth, const SE3& T_WC) {
  const auto place_of = [&](const Vector2d& px) -> std::optional<Vector2d> {
    const auto ray = camera.Unproject(px);
    if (!ray) return std::nullopt;
    const Vector3d d_W = birth.T_WC.q * *ray;
    const double t = birth.point.n_W.dot(birth.point.p_W - birth.T_WC.p) / birth.point.n_W.dot(d_W);
    return camera.Project(T_WC.Inverse() * Vector3d(birth.T_WC.p + t * d_W));
  };
  const auto middle = place_of(birth.px);
  const auto right = place_of(birth.px + Vector2d::UnitX());
  const auto down = place_of(birth.px + Vector2d::UnitY());
  if (!middle || !right || !down) return std::nullopt;
  const Eigen::Vector2f dx = (*right - *middle).cast<float>(), dy = (*down - *middle).cast<float>();
  return PatchWarp{dx.x(),
                   dy.x(),
                   dx.y(),
                   dy.y(),
                   static_cast<float>(middle->x()),
                   static_cast<float>(middle->y())};
}

PatchWarp NearestSimilarity(PatchWarp warp) {
  const float c = 0.5F * (warp.a00 + warp.a11), s = 0.5F * (warp.a10 - warp.a01);
  warp.a00 = warp.a11 = c;
  warp.a01 = -s;
  warp.a10 = s;
  return warp;
}

/// Along both axes [px]: two values per track.
struct Errors {
  int num_left_out = 0;  ///< tracks that one of the ways did not find
  std::vector<double> tracker;
  std::array<std::vector<double>, kWays.size()> ways;
};

class WarpStudy {
 public:
  WarpStudy(const StereoRig& rig, const TrueScene& scene, const KltOptions& options)
      : rig_(rig), scene_(scene), num_levels_(options.num_levels) {
    for (const Way& way : kWays)
      trackers_.emplace_back(options, way.num_parameters);
  }

  void Add(int index, const SE3& T_WB, const cv::Mat& left, const FrameObservations& frame) {
    ImagePyramid image;
    image.Build(left, num_levels_);
    for (const FeatureObservation& o : frame.features) {
      const auto birth = births_.find(o.landmark);
      if (birth == births_.end()) {
        births_[o.landmark] = Begin(index, T_WB, image, o.px_left);
      } else if (birth->second) {
        Judge(*birth->second, index, T_WB * rig_.T_BC[0], image, o.px_left);
        if (index - birth->second->frame > kAges.back()) birth->second.reset();
      }
    }
  }

  void Print() const {
    for (const auto& [age, errors] : errors_) {
      std::printf("after %2d frames                 count  rob.sig  rms(<2)  >2px,%%\n", age);
      PrintRow("tracker", errors.tracker);
      for (std::size_t w = 0; w < kWays.size(); ++w)
        PrintRow(kWays[w].name, errors.ways[w]);
      std::printf("  left out, not found by all %7d\n", errors.num_left_out);
    }
  }

 private:
  // Null unless it is on flat ground.
  std::unique_ptr<Birth> Begin(int index,
                               const SE3& T_WB,
                               const ImagePyramid& image,
                               const Vector2d& px) const {
    const auto point = scene_.Find(rig_, T_WB, px);
    if (!point || point->ground != Ground::kFlat) return nullptr;
    auto birth = std::make_unique<Birth>();
    birth->point = *point;
    birth->T_WC = T_WB * rig_.T_BC[0];
    birth->px = px;
    birth->frame = index;
    const auto x = static_cast<float>(px.x()), y = static_cast<float>(px.y());
    for (std::size_t w = 0; w < kWays.size(); ++w)
      trackers_[w].Extract(image, x, y, kFinest, birth->patches[w]);
    return birth;
  }

  void Judge(const Birth& birth,
             int index,
             const SE3& T_WC,
             const ImagePyramid& image,
             const Vector2d& tracked_px) {
    const int age = index - birth.frame;
    if (std::find(kAges.begin(), kAges.end(), age) == kAges.end()) return;
    const auto truth = TrueWarp(rig_.cameras[0], birth, T_WC);
    if (!truth) return;
    std::array<PatchWarp, kWays.size()> found;
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      found[w] = kWays[w].is_true_shape ? *truth : NearestSimilarity(*truth);
      if (!trackers_[w].Align(birth.patches[w], image, kFinest, found[w]).ok) {
        ++errors_[age].num_left_out;
        return;
      }
    }
    Errors& errors = errors_[age];
    const Vector2d place(truth->x, truth->y);
    const auto add = [&](const Vector2d& px, std::vector<double>& list) {
      list.push_back(px.x() - place.x());
      list.push_back(px.y() - place.y());
    };
    add(tracked_px, errors.tracker);
    for (std::size_t w = 0; w < kWays.size(); ++w)
      add({found[w].x, found[w].y}, errors.ways[w]);
  }

  static void PrintRow(const char* name, const std::vector<double>& errors) {
    const Spread s = ComputeSpread(errors, 2);
    std::printf(
        "  %-26s %7zu %8.3f %8.3f %8.2f\n", name, s.count, s.robust_sigma, s.rms, 100 * s.outliers);
  }

  const StereoRig& rig_;
  const TrueScene& scene_;
  int num_levels_;
  std::vector<PatchTracker> trackers_;
  std::unordered_map<LandmarkId, std::unique_ptr<Birth>> births_;
  std::map<int, Errors> errors_;
};

void Process(const std::string& sequence, const VioOptions& options) {
  TrueSequence run(sequence);
  WarpStudy study(run.exact_rig, run.scene, options.frontend.klt);
  const auto add = [&](int index, const SE3& T_WB, const cv::Mat& left, FrameObservations& frame) {
    study.Add(index, T_WB, left, frame);
  };
  RunStages(run, options, add, [](const VioOutput&) {});
  study.Print();
}

int Main(int argc, char** argv) {
  CLI::App app("Errors of tracks on flat ground, and what they would be with known shapes");
  std::string sequence;
  std::vector<std::string> overrides;
  app.add_option("sequence", sequence, "made by facet simulate")->required();
  app.add_option("--set", overrides, "option of the pipeline, key=value");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  Process(sequence, OptionsOfS(overrides));
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("true_warps", facet::Main, argc, argv);
}
