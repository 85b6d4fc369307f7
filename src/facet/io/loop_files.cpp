// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/loop_files.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <numbers>

namespace facet {

namespace {

UprightPose Interpolate(const MapCorrection& a,
                        const MapCorrection& b,
                        double share,
                        const SE3& T_WB) {
  UprightPose T_MW;
  T_MW.yaw_rad = a.T_MW.yaw_rad +
                 share * std::remainder(b.T_MW.yaw_rad - a.T_MW.yaw_rad, 2 * std::numbers::pi);
  // What is interpolated is where the body is, not where the world's origin is.
  const Vector3d p_M = (1 - share) * (a.T_MW * T_WB.p) + share * (b.T_MW * T_WB.p);
  T_MW.p = p_M - T_MW * T_WB.p;
  return T_MW;
}

// `corrections`: of one segment, at least one.
SE3 CorrectionOf(const StampedPose& pose, std::span<const MapCorrection> corrections) {
  const auto after = std::ranges::lower_bound(corrections, pose.t, {}, &MapCorrection::t);
  if (after == corrections.begin()) return after->T_MW.ToSE3();
  const MapCorrection& before = *std::prev(after);
  if (after == corrections.end()) return before.T_MW.ToSE3();
  const double share = ToSeconds(pose.t - before.t) / ToSeconds(after->t - before.t);
  return Interpolate(before, *after, share, pose.T_WB).ToSE3();
}

}  // namespace

std::vector<StampedPose> MoveIntoMap(std::span<const OdometryPose> odometry,
                                     std::span<const MapCorrection> corrections) {
  std::map<int, std::vector<MapCorrection>> by_segment;
  for (const MapCorrection& correction : corrections)
    by_segment[correction.segment].push_back(correction);
  std::vector<StampedPose> moved;
  for (const auto& [pose, segment] : odometry) {
    moved.push_back(pose);
    const auto own = by_segment.find(segment);
    if (own != by_segment.end()) moved.back().T_WB = CorrectionOf(pose, own->second) * pose.T_WB;
  }
  return moved;
}

std::string ClosuresCsv(std::span<const ClosureRecord> closures) {
  std::string text =
      "timestamp_ns,place_timestamp_ns,matches,inliers,visible,yaw_deg,dx,dy,dz,sigma_m,"
      "sigma_yaw_deg,verdict\n";
  constexpr double kDeg = 180 / std::numbers::pi;
  for (const ClosureRecord& c : closures) {
    char line[300];
    std::snprintf(line,
                  sizeof(line),
                  "%lld,%lld,%d,%d,%d,%.6g,%.6g,%.6g,%.6g,%.4g,%.4g,",
                  static_cast<long long>(c.t.ns),
                  static_cast<long long>(c.t_place.ns),
                  c.num_matches,
                  c.num_inliers,
                  c.num_visible,
                  c.T_WplaceWquery.yaw_rad * kDeg,
                  c.T_WplaceWquery.p.x(),
                  c.T_WplaceWquery.p.y(),
                  c.T_WplaceWquery.p.z(),
                  c.sigma_m,
                  c.sigma_yaw_rad * kDeg);
    text += line + c.verdict + "\n";
  }
  return text;
}

}  // namespace facet
