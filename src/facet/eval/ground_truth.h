// SPDX-License-Identifier: BSD-2-Clause
// Everything that is known to be true about a recording: poses, states, surfaces, planes.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "facet/camera/stereo_rig.h"
#include "facet/eval/truth_surface.h"
#include "facet/io/planes_file.h"
#include "facet/io/states_file.h"
#include "facet/io/trajectory_file.h"

namespace facet {

/// The true surface, read when it is asked for the first time: a laser scan has millions of
/// points. Not thread-safe.
class SurfaceFile {
 public:
  explicit SurfaceFile(std::filesystem::path path) : path_(std::move(path)) {}
  const std::filesystem::path& path() const { return path_; }
  /// Throws InputError.
  const TruthSurface& Get();

 private:
  std::filesystem::path path_;
  std::unique_ptr<TruthSurface> surface_;
};

struct GroundTruth {
  std::filesystem::path path;
  std::filesystem::path pose_file;
  std::vector<StampedPose> poses;
  std::vector<NavState> states;   ///< empty unless the file has more columns than poses
  std::vector<Timestamp> frames;  ///< stamps of the left images; empty when the truth is one file
  std::shared_ptr<SurfaceFile>
      surface;                        ///< truth/mesh.ply, else mav0/pointcloud0/data.ply, or null
  std::filesystem::path planes_file;  ///< truth/planes.csv; empty: none
  std::filesystem::path mav0;         ///< for the calibration; empty: none
  /// truth/ if it holds the exact calibration, as `facet simulate` writes it; empty: not known.
  std::filesystem::path calibration;
};

/// Whether a folder has a file with true poses.
bool HasGroundTruth(const std::filesystem::path& sequence);

/// A sequence folder (holds mav0/, or is it), or a trajectory file (TUM or EuRoC csv).
GroundTruth LoadGroundTruth(const std::filesystem::path& sequence_or_file);

}  // namespace facet
