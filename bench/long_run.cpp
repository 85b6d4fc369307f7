// SPDX-License-Identifier: BSD-2-Clause
// long_run [--duration S] [--seeds N] [--pipelines S,planes,relations] [--hover]
//   [--roughness M] [--pixel-sigma PX] [--lasting SLIDE,MATCH] [--track-life S] [--set
//   key=value]...
// Does the covariance still describe the error after ten minutes with planes that stay? Made-up
// flights in one room (with --hover in one place of it), simulated features, true planes and
// relations; points stand out from their walls by what the estimator expects, or by M. With
// --lasting a part of the noise is the same for the whole life of a track. Prints the normalised
// errors minute by minute, and over all runs, and what has become of the calibration, which was
// right.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "consistency_study.h"
#include "oracle_planes.h"
#include "program.h"
#include <CLI/CLI.hpp>
#include <Eigen/LU>

#include "facet/calibration/calibration_error.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr double kMinute = 60;

/// Sums over the frames of one minute, or of everything.
struct Normalised {
  double yaw = 0, pose = 0;               ///< squared, in units of the covariance
  double yaw_square = 0, yaw_sigma2 = 0;  ///< rad^2
  int count = 0;

  void Add(const FrameError& frame) {
    const Vector3d axis_B = frame.R_WB.transpose() * Vector3d::UnitZ();
    const double error = axis_B.dot(frame.error.head<3>());
    const double variance = axis_B.dot(frame.covariance.topLeftCorner<3, 3>() * axis_B);
    yaw += error * error / variance;
    yaw_square += error * error;
    yaw_sigma2 += variance;
    pose += ComputeNeesRatios(frame)[static_cast<std::size_t>(StatePart::kPose)];
    ++count;
  }

  void Print(const char* name) const {
    constexpr double kDegrees = 180 / M_PI;
    std::printf("  %-10s yaw NEES %5.2f   pose NEES %5.2f   yaw error %.3f deg, 1-sigma %.3f deg\n",
                name,
                yaw / count,
                pose / count,
                std::sqrt(yaw_square / count) * kDegrees,
                std::sqrt(yaw_sigma2 / count) * kDegrees);
  }
};

/// Plane errors, squared and normalised, per degree of freedom.
struct NormalisedPlanes {
  double normal = 0, offset = 0;
  double offset_square = 0, offset_sigma2 = 0;  ///< m^2
  int count = 0;

  void Add(const PlaneError& plane) {
    const Vector2d slope = plane.error.head<2>();
    normal += slope.dot(plane.covariance.topLeftCorner<2, 2>().inverse() * slope) / 2;
    offset += plane.error.z() * plane.error.z() / plane.covariance(2, 2);
    offset_square += plane.error.z() * plane.error.z();
    offset_sigma2 += plane.covariance(2, 2);
    ++count;
  }

  void Print(const char* name) const {
    std::printf(
        "  %-10s planes: NEES of the normal %.2f, of the offset %.2f   offset error %.1f mm, "
        "1-sigma %.1f mm\n",
        name,
        normal / count,
        offset / count,
        1000 * std::sqrt(offset_square / count),
        1000 * std::sqrt(offset_sigma2 / count));
  }
};

/// What a run has made of the calibration, which was right.
void PrintCalibration(const StereoRig& estimate, const StereoRig& truth) {
  const CalibrationError error = CompareCalibrations(estimate, truth);
  const Vector3d gyro_scale = error.error.segment<3>(kGyroScale);
  std::printf("  calibration: disparity at infinity %+.3f px, gyroscope %+.2f %+.2f %+.2f %%\n",
              error.disparity_mean_px,
              100 * gyro_scale.x(),
              100 * gyro_scale.y(),
              100 * gyro_scale.z());
}

/// True planes, and true relations between those that the estimator has.
class RelatedOracle {
 public:
  RelatedOracle(const SimulatedRun& run, bool with_relations)
      : run_(run), planes_(run, OraclePlaneOptions()), with_relations_(with_relations) {}

  PlaneAssignments operator()(const FrameObservations& observations, const MapSnapshot& snapshot) {
    PlaneAssignments out = planes_(observations, snapshot);
    if (with_relations_) Relate(snapshot, out);
    return out;
  }

 private:
  void Relate(const MapSnapshot& snapshot, PlaneAssignments& out) {
    using enum PlaneRelationKind;
    for (const LandmarkEstimate& landmark : snapshot.landmarks) {
      const auto truth = run_.landmarks.find(landmark.id);
      if (landmark.planes[0].IsValid() && truth != run_.landmarks.end())
        surfaces_[landmark.planes[0]] = truth->second.surface;
    }
    const std::pair<const PlaneId, PlaneId>* first_wall = nullptr;
    for (const auto& entry : surfaces_) {
      const Vector3d& n = Normal(entry.second);
      if (std::abs(n.z()) > 0.999) out.relations.push_back({kHorizontal, entry.first});
      if (std::abs(n.z()) > 1e-3) continue;
      out.relations.push_back({kVertical, entry.first});
      if (first_wall == nullptr) first_wall = &entry;
      const double cosine = std::abs(Normal(first_wall->second).dot(n));
      if (cosine > 1 - 1e-6)
        out.relations.push_back({kHeadingParallel, first_wall->first, entry.first});
      if (cosine < 1e-3)
        out.relations.push_back({kHeadingOrthogonal, first_wall->first, entry.first});
    }
  }

  const Vector3d& Normal(PlaneId surface) const {
    return run_.surfaces[static_cast<std::size_t>(surface.value)].n_W;
  }

  const SimulatedRun& run_;
  OraclePlanes planes_;
  bool with_relations_;
  std::map<PlaneId, PlaneId> surfaces_;  // by plane
};

enum class Pipeline { kS, kPlanes, kRelations };
constexpr const char* kNames[] = {"S", "planes", "relations"};

/// Adds the mean yaw NEES of each run: runs are independent, the minutes of one are not.
void Study(const Scenario& scenario,
           const ConsistencyOptions& options,
           Pipeline pipeline,
           std::vector<double>& yaw_by_run) {
  std::vector<Normalised> minutes(
      static_cast<std::size_t>(std::ceil(scenario.duration_s / kMinute)));
  Normalised all;
  std::vector<NormalisedPlanes> plane_minutes(minutes.size());
  NormalisedPlanes all_planes;
  int num_resets = 0;
  for (int i = 0; i < options.num_seeds; ++i) {
    const SimulatedRun run =
        Simulate(scenario, options, static_cast<std::uint64_t>(options.first_seed + i));
    PlanePolicy planes;
    if (pipeline != Pipeline::kS) planes = RelatedOracle(run, pipeline == Pipeline::kRelations);
    const ConsistencyRun result = RunConsistency(run, options, false, planes);
    num_resets += result.num_resets;
    if (result.calibration) PrintCalibration(*result.calibration, run.rig);
    Normalised one;
    for (const FrameError& frame : result.frames) {
      one.Add(frame);
      minutes[static_cast<std::size_t>(frame.elapsed_s / kMinute)].Add(frame);
      all.Add(frame);
    }
    for (const PlaneError& plane : result.planes) {
      plane_minutes[static_cast<std::size_t>(plane.elapsed_s / kMinute)].Add(plane);
      all_planes.Add(plane);
    }
    yaw_by_run.push_back(one.yaw / one.count);
  }
  std::printf("%s, %.0f s, %d realisations, %s; resets %d\n",
              scenario.name.c_str(),
              scenario.duration_s,
              options.num_seeds,
              kNames[static_cast<int>(pipeline)],
              num_resets);
  for (std::size_t k = 0; k < minutes.size(); ++k) {
    const std::string name = "minute " + std::to_string(k + 1);
    if (minutes[k].count > 0) minutes[k].Print(name.c_str());
    if (plane_minutes[k].count > 0) plane_minutes[k].Print(name.c_str());
  }
  all.Print("all");
  if (all_planes.count > 0) all_planes.Print("all");
  std::fflush(stdout);
}

void PrintMean(const char* name, const std::vector<double>& yaw_by_run) {
  const double n = static_cast<double>(yaw_by_run.size());
  double sum = 0, square = 0;
  for (double yaw : yaw_by_run) {
    sum += yaw;
    square += yaw * yaw;
  }
  const double mean = sum / n;
  const double error = std::sqrt(std::max(square / n - mean * mean, 0.0) / std::max(n - 1, 1.0));
  std::printf("%s: yaw NEES over %.0f runs %.2f, standard error %.2f\n", name, n, mean, error);
}

int Main(int argc, char** argv) {
  CLI::App app("Normalised errors over long runs with planes that stay");
  ConsistencyOptions options;
  options.num_seeds = 4;
  std::vector<std::string> overrides;
  double duration_s = 600;
  std::vector<std::string> pipelines = {"planes", "relations"};
  app.add_option("--seeds", options.num_seeds, "realisations per flight")
      ->check(CLI::Range(1, 100000));
  app.add_option("--first-seed", options.first_seed, "the first of them");
  app.add_option("--duration", duration_s, "length of a run [s]")->check(CLI::Range(10, 7200));
  app.add_option(
         "--pipelines", pipelines, "S, planes (true ones, kept), relations (the same with them)")
      ->delimiter(',')
      ->check(CLI::IsMember({"S", "planes", "relations"}));
  std::optional<double> roughness_m;
  app.add_option("--roughness",
                 roughness_m,
                 "how far points stand out from their walls, 1-sigma [m]; otherwise "
                 "solver.plane_sigma_m")
      ->check(CLI::Range(0.0, 1.0));
  bool is_hovering = false;
  app.add_flag("--hover", is_hovering, "in one place of a room, instead of flying through it");
  std::vector<double> lasting_px = {0, 0};
  app.add_option("--lasting",
                 lasting_px,
                 "1-sigma of errors that a track keeps for its whole life, in both images and of "
                 "its match in the right one [px]")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--pixel-sigma", options.simulator.pixel_sigma, "of other errors, 1-sigma [px]")
      ->check(CLI::Range(0.01, 10.0));
  app.add_option("--track-life", options.simulator.mean_track_life_s, "mean, in seconds")
      ->check(CLI::Range(0.05, 1e4));
  app.add_option("--set", overrides, "option of the estimator, key=value");
  CLI11_PARSE(app, argc, argv);

  ApplyOverrides(overrides, ListFields(options.estimator));
  options.simulator.slide_sigma_px = lasting_px[0];
  options.simulator.match_sigma_px = lasting_px[1];
  options.simulator.roughness_m = roughness_m.value_or(options.estimator.solver.plane_sigma_m);
  if (!std::isfinite(options.simulator.roughness_m)) throw ConfigError("--roughness: not a number");
  std::printf("points stand out from their walls by %g m, 1-sigma\n",
              options.simulator.roughness_m);
  for (const std::string& name : pipelines) {
    const auto index = std::find(std::begin(kNames), std::end(kNames), name) - std::begin(kNames);
    std::vector<double> yaw_by_run;
    for (const Scenario& scenario :
         is_hovering ? HoverScenarios(duration_s) : MadeUpScenarios(duration_s))
      Study(scenario, options, static_cast<Pipeline>(index), yaw_by_run);
    PrintMean(name.c_str(), yaw_by_run);
  }
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("long_run", facet::Main, argc, argv);
}
