// SPDX-License-Identifier: BSD-2-Clause
// Lists of planes: planes.csv of a result folder and truth/planes.csv of a sequence.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "facet/base/types.h"

namespace facet {

/// A plane of a run: n_W . p_W = d_W, seen around centre_W.
struct EstimatedPlane {
  std::int64_t id = -1;
  Vector3d n_W = Vector3d::UnitZ();
  double d_W = 0;
  Vector3d centre_W = Vector3d::Zero();
  std::string orientation, label;
  double area_m2 = 0;
  double sigma_normal_rad = 0, sigma_d_m = 0;  ///< 0 where the file does not say
  int num_landmarks = 0;
  std::vector<Vector3d> outline_W;  ///< empty where the file does not say
};

/// A true planar surface.
struct TruePlane {
  Vector3d n_G = Vector3d::UnitZ();
  double d_G = 0;
  double area_m2 = 0;
  double seen_area_m2 = 0;
  std::string label;
};

/// planes.csv of `facet run`: columns id, nx, ny, nz, d, cx, cy, cz, orientation, label,
/// first_seen_ns, last_seen_ns, landmarks, area_m2, and, if they are there, sigma_normal_rad,
/// sigma_d_m and outline. A file with nothing but the header is an
/// answer: no plane was found. Throws InputError with file and line for missing columns, numbers
/// that are not finite, normals that are not of unit norm (within 1 %), more than 20 000 planes,
/// and an empty file.
std::vector<EstimatedPlane> ReadEstimatedPlanes(const std::filesystem::path& file);

/// Columns by position: plane, nx, ny, nz, d, area, seen area, label, ... A file with nothing but
/// the header is an answer, too: a scene without planar surfaces. Throws InputError like
/// ReadEstimatedPlanes.
std::vector<TruePlane> ReadTruePlanes(const std::filesystem::path& file);

}  // namespace facet
