// SPDX-License-Identifier: BSD-2-Clause
// The paper's histograms (II-A.3): faces vote for the heights of level planes and for azimuth and
// distance of upright ones. Every vote is a smooth bump, so no bin edge matters, and votes can be
// taken back, so a plane that was found does not hide its neighbours.
#pragma once

#include <optional>
#include <vector>

#include "facet/geometry/plane.h"

namespace facet {

/// A peak: the plane it stands for, and the surface that voted for about this plane [m^2].
struct VotePeak {
  Plane plane_W;
  double area_m2 = 0;
};

/// Heights of level planes. Not thread-safe.
class HeightVotes {
 public:
  /// Votes between these heights [m], each a bump of 1-sigma `sigma_m`. Heights farther than 100 m
  /// from the middle are not counted.
  void Reset(double min_m, double max_m, double sigma_m);

  /// `weight` is negative to take a vote back. What is not finite is left out.
  void Add(double height_m, double weight);

  std::optional<VotePeak> Highest() const;

  /// Takes away what is left around a peak.
  void Erase(const Plane& plane_W);

 private:
  double origin_m_ = 0, bin_m_ = 0;
  std::vector<float> bins_;
};

/// Upright planes by the azimuth of the normal, 0 to pi, and the distance from a given point. A
/// face votes for every azimuth near its own, each time with the distance that its centre has under
/// that azimuth: faces of one wall agree in the true azimuth's column however noisy their normals
/// are. Not thread-safe.
class WallVotes {
 public:
  /// Distances count from `origin_W`, up to `radius_m` on both sides (at most 100 m).
  void Reset(const Vector3d& origin_W, double radius_m, double sigma_m, double sigma_rad);

  /// A face with the given centre and normal; `weight` is negative to take a vote back. What is not
  /// finite is left out.
  void Add(const Vector3d& centre_W, const Vector3d& n_W, double weight);

  /// The same with the distance of the face's own plane under every azimuth: the error of its
  /// normal times the distance from the origin moves the vote.
  void AddOwnDistance(const Vector3d& centre_W, const Vector3d& n_W, double weight);

  std::optional<VotePeak> Highest();

  void Erase(const Plane& plane_W);

 private:
  template <class Distance>
  void AddBumps(const Vector3d& n_W, double weight, const Distance& distance);
  void AddColumn(int column, double distance_m, double weight);

  Vector3d origin_W_ = Vector3d::Zero();
  double radius_m_ = 0, bin_m_ = 0, sigma_rad_ = 0;
  double decay_ = 0;  // of the ratio of a vote's weights in neighbouring columns
  int num_distances_ = 0;
  std::vector<Vector3d> directions_;  // of the columns
  std::vector<float> bins_;           // [azimuth][distance]
  std::vector<float> highest_;        // of each column, negative: changed since it was looked up
};

}  // namespace facet
