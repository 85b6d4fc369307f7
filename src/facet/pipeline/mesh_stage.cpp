// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/mesh_stage.h"

#include <algorithm>
#include <cmath>

namespace facet {

namespace {

constexpr double kBorderStep_px = 60;

/// The options in force with support points.
MeshOptions Effective(MeshOptions options) {
  if (!options.support.enabled) return options;
  options.faces.max_side_per_depth =
      std::min(options.faces.max_side_per_depth, options.support.max_side_per_depth);
  options.border.enabled = false;  // what can be matched near the border is measured
  return options;
}

std::vector<Vector2d> PlacesOnBorder(const CameraModel& camera) {
  const double right = camera.width() - 1, bottom = camera.height() - 1;
  std::vector<Vector2d> places;
  const auto add = [&](double x, double y) {
    if (const auto point = camera.Undistort({x, y})) places.push_back(point->xy);
  };
  const int columns = std::max(1, static_cast<int>(std::lround(right / kBorderStep_px)));
  const int rows = std::max(1, static_cast<int>(std::lround(bottom / kBorderStep_px)));
  for (int i = 0; i <= columns; ++i) {
    add(i * right / columns, 0);
    add(i * right / columns, bottom);
  }
  for (int i = 1; i < rows; ++i) {
    add(0, i * bottom / rows);
    add(right, i * bottom / rows);
  }
  return places;
}

}  // namespace

MeshStage::MeshStage(const StereoRig& rig, const MeshOptions& options, bool planes_judge)
    : options_(Effective(options)),
      camera_(rig.cameras[0]),
      T_BC_(rig.T_BC[0]),
      baseline_focal_px_(rig.baseline_m() * rig.cameras[1].mean_focal_px()),
      border_xy_(PlacesOnBorder(rig.cameras[0])),
      border_(options.border),
      horizon_(options_, planes_judge),
      map_(options.map) {}

// Both lists are sorted by landmark.
void MeshStage::FillView(const FrameObservations& observations,
                         const MeshPacket& images,
                         const MapSnapshot& snapshot) {
  view_.frame = observations.frame;
  view_.t = observations.t;
  view_.T_WC = snapshot.latest.T_WB * T_BC_;
  view_.focal_px = camera_.mean_focal_px();
  view_.points.clear();
  const SE3 T_CW = view_.T_WC.Inverse();
  auto known = snapshot.landmarks.begin();
  for (std::size_t i = 0; i < observations.features.size(); ++i) {
    const FeatureObservation& feature = observations.features[i];
    while (known != snapshot.landmarks.end() && known->id < feature.landmark)
      ++known;
    const bool is_known = known != snapshot.landmarks.end() && known->id == feature.landmark &&
                          known->num_observations >= options_.min_observations;
    if (!is_known) {
      if (options_.unknown_corners && feature.px_right)
        AddUnknownCorner(feature, images.inverse_depths[i], images.intensities[i]);
      continue;
    }
    const auto undistorted = camera_.Undistort(feature.px_left);
    if (!undistorted) continue;
    view_.points.push_back({feature.landmark,
                            undistorted->xy,
                            T_CW * known->p_W,
                            known->sigma_depth_m,
                            images.intensities[i]});
  }
}

void MeshStage::AddUnknownCorner(const FeatureObservation& feature,
                                 double inverse_depth,
                                 std::uint8_t intensity) {
  const auto undistorted = camera_.Undistort(feature.px_left);
  if (!undistorted || !(inverse_depth > 0)) return;
  const Vector2d& xy = undistorted->xy;
  const double z = 1 / inverse_depth;
  const double sigma_m = z * z * feature.sigma_right_px / baseline_focal_px_;
  view_.points.push_back(
      {LandmarkId{next_support_id_++}, xy, z * Vector3d(xy.x(), xy.y(), 1), sigma_m, intensity});
}

void MeshStage::AddBorder() {
  found_.clear();
  for (const Vector2d& xy : border_xy_) {
    if (const auto point = border_.Continue(view_, xy)) found_.push_back(*point);
  }
  for (MeshPoint& point : found_) {
    point.id = LandmarkId{next_support_id_++};
    view_.points.push_back(point);
  }
}

void MeshStage::AddSupport(const MeshPacket& images) {
  view_.first_match = LandmarkId{next_support_id_};
  for (std::size_t i = 0; i < images.support.size(); ++i) {
    const DepthPoint& point = images.support[i];
    const double z = 1 / point.inverse_depth;
    const double sigma_m = z * z * point.sigma_inverse_depth;
    if (!(sigma_m <= options_.support.max_depth_sigma * z)) continue;
    view_.points.push_back({LandmarkId{next_support_id_++},
                            point.xy,
                            z * Vector3d(point.xy.x(), point.xy.y(), 1),
                            sigma_m,
                            images.support_intensities[i]});
  }
  view_.end_match = LandmarkId{next_support_id_};
}

std::shared_ptr<MeshSnapshot> MeshStage::Process(const FrameObservations& observations,
                                                 const MeshPacket& images,
                                                 const MapSnapshot& snapshot) {
  if (!options_.enabled) return nullptr;
  FillView(observations, images, snapshot);
  AddSupport(images);
  if (options_.border.enabled) AddBorder();
  horizon_.Update(view_, snapshot, T_BC_);
  KeepLostFaces();
  return std::make_shared<MeshSnapshot>(MakeMeshSnapshot(view_, horizon_));
}

void MeshStage::JudgeBy(const TriangleJudge& judge) {
  horizon_.SetStandings(judge(horizon_.vertices(), horizon_.Triangles()));
}

void MeshStage::Reset() {
  horizon_.Clear();
  KeepLostFaces();
}

void MeshStage::KeepLostFaces() {
  if (!options_.map.enabled) return;
  for (const LostFace& face : horizon_.lost())
    map_.Add(face);
}

std::optional<TriangleMesh> MeshStage::Map() const {
  if (!options_.enabled || !options_.map.enabled) return std::nullopt;
  return ExtractSurface(WithHorizon(map_, horizon_));
}

}  // namespace facet
