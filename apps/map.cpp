// SPDX-License-Identifier: BSD-2-Clause
// `facet map`: what earlier runs have left for later ones.
#include "map.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "facet/io/errors.h"
#include "facet/io/ply_writer.h"
#include "facet/io/saved_map_file.h"
#include "facet/io/trajectory_file.h"
#include "facet/loop/map_merge.h"

namespace facet {
namespace {

std::vector<Vector3d> PointsInMap(const SavedMap& map) {
  std::vector<Vector3d> points;
  for (const PlaceRecord& place : map.places) {
    const SE3 T_MC = map.graph.nodes[place.node].T_MW.ToSE3() * place.T_WC();
    for (const RecordPoint& point : place.points)
      points.push_back(T_MC * point.p_C.cast<double>());
  }
  return points;
}

/// Of a run, from 1 on, or of all: in order of time.
std::vector<StampedPose> PosesInMap(const SavedMap& map, int run) {
  if (run > map.num_sessions())
    throw InputError("--run " + std::to_string(run) + ": the map has " +
                     std::to_string(map.num_sessions()) + " runs");
  std::vector<StampedPose> poses;
  for (const PlaceRecord& place : map.places) {
    if (run == 0 || place.session == run - 1)
      poses.push_back({place.t, map.graph.nodes[place.node].T_MW.ToSE3() * place.T_WB});
  }
  std::ranges::stable_sort(poses, {}, &StampedPose::t);
  return poses;
}

/// Of one run: its keyframes, how long it was, its places, and what ties it to others.
void PrintSession(const SavedMap& map, int session) {
  const auto is_own = [&](int node) { return map.keyframes[node].session == session; };
  std::vector<Timestamp> stamps;
  for (const MapKeyframe& keyframe : map.keyframes) {
    if (keyframe.session == session) stamps.push_back(keyframe.t);
  }
  const auto [first, last] = std::ranges::minmax_element(stamps);
  const double length_s = stamps.empty() ? 0 : ToSeconds(*last - *first);
  const auto num_places = std::ranges::count_if(
      map.places, [&](const PlaceRecord& place) { return place.session == session; });
  int num_within = 0, num_across = 0;
  for (const GraphEdge& edge : map.graph.edges) {
    if (!edge.is_closure || !is_own(edge.second)) continue;
    ++(is_own(edge.first) ? num_within : num_across);
  }
  std::printf(
      "  run %-3d %6zu keyframes in %.0f s, %d places, %d closures within it, %d with runs "
      "before\n",
      session + 1,
      stamps.size(),
      length_s,
      static_cast<int>(num_places),
      num_within,
      num_across);
}

}  // namespace

void MapInfoCommand(const MapArguments& arguments) {
  const SavedMap map = ReadSavedMap(arguments.map);
  const std::vector<Vector3d> points = PointsInMap(map);
  constexpr double kBytesPerMb = 1e6;
  const auto size =
      std::filesystem::file_size(std::filesystem::path(arguments.map) / kSavedMapName);
  std::printf("map of places, %.1f MB: %zu places with %zu points, %d runs\n",
              static_cast<double>(size) / kBytesPerMb,
              map.places.size(),
              points.size(),
              map.num_sessions());
  for (int session = 0; session < map.num_sessions(); ++session)
    PrintSession(map, session);
  if (points.empty()) return;
  // Few are so far away that they would say nothing of the map's size.
  Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vector3d& point : points)
      values.push_back(point[axis]);
    std::ranges::sort(values);
    low[axis] = values[values.size() / 50];
    high[axis] = values[values.size() - 1 - values.size() / 50];
  }
  std::printf("  nearly all points from (%.1f, %.1f, %.1f) to (%.1f, %.1f, %.1f) m\n",
              low.x(),
              low.y(),
              low.z(),
              high.x(),
              high.y(),
              high.z());
}

void MapMergeCommand(const MapArguments& arguments) {
  const std::filesystem::path out = arguments.out;
  std::error_code error;
  if (std::filesystem::exists(out / kSavedMapName, error))
    throw ConfigError(arguments.out + ": has a map already; name a folder without one");
  const SavedMap first = ReadSavedMap(arguments.map), second = ReadSavedMap(arguments.second);
  const MapMerge merge = MergeMaps(first, second);
  if (!merge.is_found) {
    throw InputError(arguments.second + ": " +
                     (merge.is_ambiguous
                          ? "looks like more than one part of "
                          : "is not found in what both maps show; it must show places of ") +
                     arguments.map + " (" + std::to_string(merge.num_alike) + " of " +
                     std::to_string(merge.num_compared) + " pairs of places look alike)");
  }
  WriteSavedMap(out, merge.map);
  std::printf("%s: %d runs, %zu places; %d pairs of places tie the maps together\n",
              arguments.out.c_str(),
              merge.map.num_sessions(),
              merge.map.places.size(),
              merge.num_closures);
}

void MapExportCommand(const MapArguments& arguments) {
  const SavedMap map = ReadSavedMap(arguments.map);
  if (std::filesystem::path(arguments.out).extension() == ".tum") {
    WriteTum(arguments.out, PosesInMap(map, arguments.run));
  } else {
    if (arguments.run > 0) throw ConfigError("--run is for a .tum only");
    WritePlyPoints(arguments.out, PointsInMap(map));
  }
}

}  // namespace facet
