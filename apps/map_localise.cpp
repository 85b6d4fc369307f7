// SPDX-License-Identifier: BSD-2-Clause
// `facet map localise`: where in a map a recording begins.
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "align_stereo.h"
#include "load_options.h"
#include "map.h"
#include "run_sequence.h"

#include "facet/geometry/angles.h"
#include "facet/io/errors.h"
#include "facet/io/saved_map_file.h"
#include "facet/pipeline/vio_pipeline.h"
#include "facet/recording/open_recording.h"

namespace facet {
namespace {

/// Without planes and mesh, which take no part in it, unless the overrides say so.
VioOptions OptionsFor(const MapArguments& arguments) {
  std::vector<std::string> overrides = {"pipeline=S", "mesh.enabled=false"};
  overrides.insert(overrides.end(), arguments.overrides.begin(), arguments.overrides.end());
  VioOptions options = LoadOptions("", overrides).options;
  options.loops.enabled = true;
  options.known_map = std::make_shared<SavedMap>(ReadSavedMap(arguments.map));
  return options;
}

/// The first pose of the run, and the first one that is in the map.
struct Found {
  std::optional<Timestamp> first, in_map;
  SE3 T_MB;
};

void Print(const Found& found, const MapArguments& arguments) {
  const Vector3d& p = found.T_MB.p;
  const Matrix3d R = found.T_MB.R();
  std::printf(
      "found %.2f s after the first pose, at (%.3f, %.3f, %.3f) m in %s, x of the body %.1f "
      "deg from x of the map\n",
      ToSeconds(*found.in_map - *found.first),
      p.x(),
      p.y(),
      p.z(),
      arguments.map.c_str(),
      std::atan2(R(1, 0), R(0, 0)) / kDegree);
}

}  // namespace

void MapLocaliseCommand(const MapArguments& arguments) {
  const VioOptions options = OptionsFor(arguments);
  RecordingOptions how;
  how.calibration = {arguments.calibration, arguments.imu_calibration};
  const std::unique_ptr<Recording> recording = OpenRecording(arguments.recording, how);
  const AlignedRig aligned = AlignStereo(*recording, arguments.start_s);
  if (!aligned.refusal.empty())
    throw InputError(arguments.recording + ": the calibration cannot be right: " + aligned.refusal);
  VioPipeline vio(aligned.rig, recording->calibration()->imu_noise, options);
  VioFunctions functions;
  functions.add_imu = [&](const ImuSample& sample) { vio.AddImu(sample); };
  functions.add_stereo = [&](const StereoFrame& frame) {
    return std::vector{vio.AddStereo(frame)};
  };
  functions.finish = [] { return std::vector<VioOutput>(); };
  functions.result = [&] { return vio.TakeResult(); };
  Found found;
  RunRange range;
  range.start_s = arguments.start_s;
  range.duration_s = arguments.duration_s;
  const SequenceRun run =
      RunSequence(*recording, functions, range, [&](const RunProgress&, const VioOutput& output) {
        if (!output.has_pose) return true;
        if (!found.first) found.first = output.t;
        if (!output.is_in_map) return true;
        found.in_map = output.t;
        found.T_MB = output.T_MW * output.state.T_WB;
        return false;
      });
  if (found.in_map) return Print(found, arguments);
  if (!found.first) throw InputError(arguments.recording + ": no pose: " + run.message);
  if (run.end != RunEnd::kComplete) throw InputError(arguments.recording + ": " + run.message);
  const bool is_ambiguous = run.record.loops && run.record.loops->is_ambiguous;
  throw InputError(arguments.recording + ": not found in " + arguments.map +
                   (is_ambiguous
                        ? ": it looks like more than one place there"
                        : ": nothing that was seen looks like it; --duration SECONDS looks "
                          "for longer"));
}

}  // namespace facet
