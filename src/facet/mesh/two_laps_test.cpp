// SPDX-License-Identifier: BSD-2-Clause
// A camera that goes around a ring of corridors twice: the horizon mesh stays as large as it is,
// and the map does not grow where it has been, though the estimate has drifted and sees other
// corners.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/mesh/horizon_mesh.h"
#include "facet/mesh/surface_map.h"

namespace facet {
namespace {

// Centre line of the ring: 72 m. The walls stand 1 m beside it.
constexpr double kLength_m = 24, kWidth_m = 12, kHalf_m = 1, kHeight_m = 2.6, kEye_m = 1.3;
constexpr double kLap_m = 2 * (kLength_m + kWidth_m);
constexpr double kStep_m = 0.2;
constexpr int kWindow = 10;  // keyframes in which a landmark stays known

struct Place {
  Vector2d p = Vector2d::Zero();
  double heading = 0;
};

/// Along the centre line.
Place PlaceAt(double s) {
  s = std::fmod(s, kLap_m);
  const std::array<Vector2d, 4> corners = {
      Vector2d(0, 0), Vector2d(kLength_m, 0), Vector2d(kLength_m, kWidth_m), Vector2d(0, kWidth_m)};
  for (std::size_t side = 0;; ++side) {
    const Vector2d along = corners[(side + 1) % 4] - corners[side];
    if (s <= along.norm() || side == 3) {
      // Turns within the last metre before a corner and the first behind it.
      const double left = along.norm() - s;
      double turn = 0;
      if (left < 1) turn = 0.25 * std::numbers::pi * (1 - left);
      if (s < 1) turn = -0.25 * std::numbers::pi * (1 - s);
      return {corners[side] + s * along.normalized(),
              static_cast<double>(side) * 0.5 * std::numbers::pi + turn};
    }
    s -= along.norm();
  }
}

/// The left camera: z forward, y down.
SE3 CameraAt(double s) {
  const Place place = PlaceAt(s);
  Matrix3d R_WC;
  R_WC.col(2) = Vector3d(std::cos(place.heading), std::sin(place.heading), 0);
  R_WC.col(1) = -Vector3d::UnitZ();
  R_WC.col(0) = R_WC.col(1).cross(R_WC.col(2));
  return {Quaterniond(R_WC), Vector3d(place.p.x(), place.p.y(), kEye_m)};
}

/// Whether a point of the floor plan is inside the block that the ring goes around.
bool IsInBlock(const Vector2d& p) {
  return p.x() > kHalf_m && p.x() < kLength_m - kHalf_m && p.y() > kHalf_m &&
         p.y() < kWidth_m - kHalf_m;
}

bool IsHidden(const Vector2d& eye, const Vector2d& p) {
  constexpr int kSamples = 40;
  for (int i = 1; i < kSamples; ++i) {
    if (IsInBlock(eye + (p - eye) * (static_cast<double>(i) / kSamples))) return true;
  }
  return false;
}

/// Random corners on walls, floor and ceiling.
std::vector<Vector3d> RandomCorners(Rng& rng) {
  constexpr int kCount = 8000;  // 12 per m2
  std::vector<Vector3d> corners;
  while (static_cast<int>(corners.size()) < kCount) {
    const Vector2d q(rng.Uniform(-kHalf_m, kLength_m + kHalf_m),
                     rng.Uniform(-kHalf_m, kWidth_m + kHalf_m));
    const double z = rng.Uniform(0, kHeight_m);
    switch (rng.Index(4)) {
      case 0:
        if (!IsInBlock(q)) corners.push_back({q.x(), q.y(), rng.Index(2) * kHeight_m});
        break;
      case 1:  // the outer walls
        corners.push_back({q.x(), rng.Index(2) * (kWidth_m + 2 * kHalf_m) - kHalf_m, z});
        corners.push_back({rng.Index(2) * (kLength_m + 2 * kHalf_m) - kHalf_m, q.y(), z});
        break;
      case 2:  // the inner walls
        if (q.x() > kHalf_m && q.x() < kLength_m - kHalf_m)
          corners.push_back({q.x(), kHalf_m + rng.Index(2) * (kWidth_m - 2 * kHalf_m), z});
        if (q.y() > kHalf_m && q.y() < kWidth_m - kHalf_m)
          corners.push_back({kHalf_m + rng.Index(2) * (kLength_m - 2 * kHalf_m), q.y(), z});
        break;
      default:
        break;
    }
  }
  return corners;
}

/// Not along the grid of the map: there the number of vertices depends on where in its voxel a wall
/// lies.
SE3 SceneInWorld() {
  return {Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized())), Vector3d::Zero()};
}

/// The estimate: what the camera sees is moved by the drift so far.
class Walk {
 public:
  explicit Walk(const MeshOptions& options) : horizon_(options), map_(options.map) {}

  void Lap(int lap, Rng& rng) {
    const std::vector<Vector3d> corners = RandomCorners(rng);
    max_faces_ = 0;
    const int steps = static_cast<int>(kLap_m / kStep_m);
    for (int i = 0; i < steps; ++i)
      Step((lap * steps + i) * kStep_m, lap, corners, rng);
  }

  int max_faces() const { return max_faces_; }

  /// What a run that ends here writes.
  SurfaceMap Map() const { return WithHorizon(map_, horizon_); }

 private:
  // 0.05 % of the path to the side and up, 0.1 deg of heading per lap: what S shows in the
  // corridor.
  static SE3 Drift(double s) {
    const double heading = 0.1 / 180 * std::numbers::pi * s / kLap_m;
    const SE3 drift(Quaterniond(Eigen::AngleAxisd(heading, Vector3d::UnitZ())),
                    5e-4 * s * Vector3d(0.6, 0.6, 0.5));
    return SceneInWorld() * drift;
  }

  void Step(double s, int lap, const std::vector<Vector3d>& corners, Rng& rng) {
    const SE3 T_WC = CameraAt(s), T_CW = T_WC.Inverse(), drift = Drift(s);
    MeshView view;
    view.frame = FrameId{next_frame_++};
    view.t = Timestamp{view.frame.value * 200'000'000};
    view.T_WC = drift * T_WC;
    view.focal_px = 458;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector3d p_C = T_CW * corners[i];
      if (p_C.z() < 0.4 || p_C.z() > 6 || std::abs(p_C.x()) > 0.8 * p_C.z() ||
          std::abs(p_C.y()) > 0.5 * p_C.z() || IsHidden(T_WC.p.head<2>(), corners[i].head<2>())) {
        continue;
      }
      const double sigma_m = 0.003 * p_C.z() * p_C.z();
      const Vector3d seen = p_C * (1 + sigma_m * rng.Normal() / p_C.z());
      const LandmarkId id{lap * 100'000 + static_cast<std::int64_t>(i)};
      view.points.push_back({id, p_C.normalized(), seen, sigma_m, 100});
      known_[id] = {{id, view.T_WC * seen, 5, sigma_m}, view.frame};
    }
    MapSnapshot snapshot;
    std::erase_if(known_, [&](const auto& entry) {
      return entry.second.last_seen.value + kWindow <= view.frame.value;
    });
    for (const auto& [id, known] : known_)
      snapshot.landmarks.push_back(known.estimate);
    horizon_.Update(view, snapshot, SE3());
    for (const ExpiredFace& face : horizon_.expired())
      map_.Add(face);
    max_faces_ = std::max(max_faces_, static_cast<int>(horizon_.faces().size()));
  }

  struct Known {
    LandmarkEstimate estimate;
    FrameId last_seen;
  };
  HorizonMesh horizon_;
  SurfaceMap map_;
  std::map<LandmarkId, Known> known_;
  std::int64_t next_frame_ = 0;
  int max_faces_ = 0;
};

/// Distance to the nearest true surface.
double ErrorOf(const Vector3d& p) {
  const auto to = [](double x, double wall) { return std::abs(x - wall); };
  double error = std::min(to(p.z(), 0), to(p.z(), kHeight_m));
  for (double side : {-kHalf_m, kHalf_m}) {
    error = std::min({error,
                      to(p.x(), side),
                      to(p.x(), kLength_m + side),
                      to(p.y(), side),
                      to(p.y(), kWidth_m + side)});
  }
  return error;
}

/// Vertices of the surface, and those that are out of place.
std::array<double, 2> CountVertices(const SurfaceMap& map) {
  std::array<double, 2> count{};
  const SE3 T_SW = SceneInWorld().Inverse();
  for (const Vector3d& p : ExtractSurface(map).vertices) {
    ++count[0];
    if (ErrorOf(T_SW * p) > 0.15) ++count[1];
  }
  return count;
}

TEST(TwoLaps, TheSecondAddsHardlyAnything) {
  Rng rng(1);
  Walk walk{MeshOptions()};
  walk.Lap(0, rng);
  SurfaceMap map = walk.Map();
  const auto blocks = static_cast<double>(map.blocks().size());
  const auto [vertices, wrong] = CountVertices(map);
  const int faces = walk.max_faces();
  EXPECT_GT(blocks, 1000);
  walk.Lap(1, rng);
  map = walk.Map();
  const auto blocks_after = static_cast<double>(map.blocks().size());
  const auto [vertices_after, wrong_after] = CountVertices(map);
  EXPECT_LT(blocks_after, 1.05 * blocks);
  // The other corners show what lay between those of the first lap.
  EXPECT_LT(vertices_after, 1.1 * vertices);
  // What was seen through is gone.
  EXPECT_LT(wrong, 0.01 * vertices);
  EXPECT_LT(wrong_after, 0.01 * vertices_after);
  EXPECT_LT(walk.max_faces(), 1.2 * faces);
  std::printf(
      "blocks %.0f -> %.0f, vertices %.0f (%.0f out of place) -> %.0f (%.0f), largest horizon %d "
      "-> %d faces\n",
      blocks,
      blocks_after,
      vertices,
      wrong,
      vertices_after,
      wrong_after,
      faces,
      walk.max_faces());
}

}  // namespace
}  // namespace facet
