// SPDX-License-Identifier: BSD-2-Clause
// How good a mesh is: how far its surface is from the true one (accuracy), and how much of the true
// surface that the cameras saw it covers (completeness). Definitions: docs/evaluation.md.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "facet/eval/mesh_sampling.h"
#include "facet/eval/plane_areas.h"
#include "facet/eval/truth_surface.h"
#include "facet/geometry/se3.h"

namespace facet {

/// Distances of mesh samples to the true surface [m].
struct DistanceStatistics {
  double mean_m = 0, median_m = 0, p90_m = 0, rmse_m = 0;
};

/// CHECKs that there is at least one value.
DistanceStatistics SummarizeDistances(std::vector<double> distances_m);

inline constexpr std::array<double, 3> kCompletenessLimits = {0.05, 0.10, 0.20};  // [m]
inline constexpr std::array<double, 2> kFscoreLimits = {0.05, 0.10};              // [m]
inline constexpr std::array<double, 4> kRangeBorders = {0, 2, 4, 8};              // [m]

struct RangeBin {
  double from_m = 0, to_m = 0;
  std::size_t num_samples = 0;
  DistanceStatistics accuracy;
};

inline constexpr double kNearRange = 3;     // [m]
inline constexpr double kNearLimit = 0.05;  // [m]

/// Figures of what lies near the cameras: samples nearer than kNearRange to the camera that their
/// range is counted from, and true points that a camera saw from less than kNearRange.
struct NearFigures {
  std::size_t num_samples = 0;
  double median_m = 0;
  double precision = 0;  ///< share of these samples within kNearLimit of the truth
  /// Share of these true points within kNearLimit of the mesh, and the harmonic mean of both;
  /// absent when there is no such point or nobody knows.
  std::optional<double> completeness, fscore;
};

/// The figures of one mesh in one position.
struct MeshFigures {
  DistanceStatistics accuracy;
  std::array<double, 2> precision{};  ///< share of the samples within kFscoreLimits
  std::vector<RangeBin> by_range;     ///< bins with at least one sample
  /// Share of the true points within kCompletenessLimits of the mesh; absent when no true point
  /// was seen or nobody knows.
  std::optional<std::array<double, 3>> completeness;
  std::optional<std::array<double, 2>> fscore;
  std::optional<NearFigures> near;  ///< absent without such samples
};

struct IcpFigures {
  MeshFigures figures;
  double correction_translation_m = 0;  ///< how far the centre of the mesh was moved
  double correction_rotation_deg = 0;
  /// More than 0.3 m or 5 deg: not the remains of drift but another place.
  bool is_suspicious = false;
};

struct MeshError {
  int num_files = 1;
  std::size_t num_vertices = 0, num_faces = 0, num_samples = 0;
  std::size_t num_seen = 0;  ///< true points that completeness is counted on
  double area_m2 = 0;
  MeshFigures aligned;  ///< as the trajectory's alignment puts it
  IcpFigures icp;
  std::optional<double> doubled_area;           ///< share of the area, where it was asked for
  std::optional<PlaneAreaFigures> plane_areas;  ///< as aligned; absent without true planes there
  /// Every k-th sample and its distance, as aligned; pictures show them.
  std::vector<Vector3d> picture_samples_G;
  std::vector<double> picture_distances_m;
};

/// A mesh in the frame of the truth.
struct MeshUnderTest {
  TriangleMesh mesh_G;
  /// Distance of a point of face f from the camera that saw it; empty: no bins by range.
  std::function<double(const Vector3d& p_G, int face)> range_m;
  bool wants_doubled_area = false;
  std::vector<TruePlane> planes_G;  ///< true planes; may be empty
};

/// Which of truth.points() the cameras saw. Empty: nobody knows, and there is no completeness.
struct SeenTruth {
  std::vector<char> points;
  std::vector<char> near_points;  ///< from less than kNearRange
};

/// CHECKs that the mesh has a face with an area, and the sizes of `seen`.
MeshError EvaluateMesh(const MeshUnderTest& test, const TruthSurface& truth, const SeenTruth& seen);

/// Share of the area above or below which, at 1 to 10 cm along the normal, lies another face whose
/// normal differs by less than 20 deg and that shares no vertex with it: surfaces mapped twice.
double DoubledArea(const TriangleMesh& mesh, const TriangleIndex& index);

}  // namespace facet
