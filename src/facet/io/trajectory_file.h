// SPDX-License-Identifier: BSD-2-Clause
// Trajectories on disk: TUM (`t[s] tx ty tz qx qy qz qw`, blanks) and EuRoC csv
// (`t[ns],px,py,pz,qw,qx,qy,qz,...`, commas; also EuRoC's ground truth).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "facet/geometry/se3.h"

namespace facet {

struct StampedPose {
  Timestamp t;
  SE3 T_WB;
};

/// In order of time; of poses with the same stamp the first one stays.
void SortByTime(std::vector<StampedPose>& poses);

enum class TrajectoryFormat { kTum, kEurocCsv };

struct Trajectory {
  std::vector<StampedPose> poses;  ///< stamps strictly increasing, at least one
  TrajectoryFormat format = TrajectoryFormat::kTum;
  int num_duplicates = 0;  ///< poses left out because their stamp had been there before
  std::vector<std::string> warnings;
};

/// Reads either format, told apart by the separator. Whitespace-separated files with stamps in
/// nanoseconds (ORB-SLAM3 writes them) are accepted with a warning; of poses with the same stamp
/// the first is kept, with a warning. Throws InputError with file and line for a file without a
/// pose, too few columns, numbers that are not finite, quaternions that are not of unit norm
/// (within 1 %), stamps that run backwards, and stamps of the wrong unit.
Trajectory ReadTrajectory(const std::filesystem::path& file);

/// The first line of a TUM file, with its line end.
std::string TumHeader();

/// TUM text of one pose, with the stamp exact to the nanosecond and a line end.
std::string FormatTumLine(const StampedPose& pose);

/// Throws OutputError when the file cannot be written completely.
void WriteTum(const std::filesystem::path& file, std::span<const StampedPose> poses);

/// "1403636584.763555584": seconds with 9 decimals, exact.
std::string FormatSeconds(Timestamp t);

}  // namespace facet
