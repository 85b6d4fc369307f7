// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/mesh_view_builder.h"

#include <algorithm>
#include <cmath>

#include "facet/camera/image_extent.h"

namespace facet {

namespace {

constexpr double kBorderStep_px = 60;

// Support points whose distance is known worse than this, 1-sigma over itself, would only roughen
// the surface between the corners. With EuRoC's cameras; where points are farther apart an error in
// depth tilts the surface less.
constexpr double kMaxSupportSigma = 0.06;

std::vector<Vector3d> PlacesOnBorder(const CameraModel& camera) {
  const double right = camera.width() - 1, bottom = camera.height() - 1;
  std::vector<Vector3d> places;
  const auto add = [&](double x, double y) {
    if (const auto bearing = camera.Unproject({x, y})) places.push_back(*bearing);
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

MeshViewBuilder::MeshViewBuilder(const StereoRig& rig, const MeshOptions& options)
    : options_(options),
      rig_(rig),
      beside_model_(FieldsOf(rig)),
      max_support_sigma_(kMaxSupportSigma * RelativeViewAngle(rig.cameras[0])) {
  if (options.border.enabled) border_places_ = PlacesOnBorder(rig_.cameras[0]);
}

const MeshView& MeshViewBuilder::Build(const FrontendResult& keyframe,
                                       const MapSnapshot& snapshot) {
  view_.frame = keyframe.observations.frame;
  view_.t = keyframe.observations.t;
  SetRig(snapshot.rig);
  view_.T_WC = snapshot.T_WC0;
  view_.focal_px = rig_.cameras[0].mean_focal_px();
  view_.baseline_m = rig_.baseline_m();
  view_.points.clear();
  AddObservations(keyframe, snapshot);
  AddSupport(keyframe.depths.support);
  AddBorder();
  return view_;
}

void MeshViewBuilder::SetRig(const std::shared_ptr<const StereoRig>& now) {
  if (now == now_) return;
  now_ = now;
  beside_model_ = FieldsOf(now_ ? *now_ : rig_);
}

// Both lists are sorted by landmark.
void MeshViewBuilder::AddObservations(const FrontendResult& keyframe, const MapSnapshot& snapshot) {
  const SE3 T_CW = view_.T_WC.Inverse();
  auto known = snapshot.landmarks.begin();
  for (std::size_t i = 0; i < keyframe.observations.features.size(); ++i) {
    const FeatureObservation& feature = keyframe.observations.features[i];
    const std::uint8_t intensity = keyframe.depths.intensities[i];
    while (known != snapshot.landmarks.end() && known->id < feature.landmark)
      ++known;
    const bool is_known = known != snapshot.landmarks.end() && known->id == feature.landmark &&
                          known->num_observations >= options_.min_observations;
    if (!is_known) {
      if (options_.unknown_corners && feature.px_right) AddUnknownCorner(feature, intensity);
      continue;
    }
    const auto bearing =
        (now_ ? *now_ : rig_).cameras[0].Unproject(ByModel(beside_model_, 0, feature.px_left));
    if (!bearing) continue;
    view_.points.push_back(
        {feature.landmark, *bearing, T_CW * known->p_W, known->sigma_depth_m, intensity});
  }
}

void MeshViewBuilder::AddUnknownCorner(const FeatureObservation& feature, std::uint8_t intensity) {
  const auto seen = Triangulate(feature.px_left, *feature.px_right);
  if (!seen || !(seen->stereo.inverse_distance > 0)) return;
  const double distance_m = 1 / seen->stereo.inverse_distance;
  const double sigma_m =
      distance_m * distance_m * feature.sigma_right_px / seen->stereo.px_per_inverse_distance;
  view_.points.push_back(
      {NextSupportId(), seen->bearing, distance_m * seen->bearing, sigma_m, intensity});
}

std::optional<MeshViewBuilder::StereoPoint> MeshViewBuilder::Triangulate(
    const Vector2d& px, const Vector2d& px_right) const {
  const StereoRig& rig = now_ ? *now_ : rig_;
  const auto left = rig.cameras[0].Unproject(ByModel(beside_model_, 0, px));
  const auto right = rig.cameras[1].BearingOf(ByModel(beside_model_, 1, px_right));
  if (!left || !right) return std::nullopt;
  const auto stereo = TriangulateOnRay(*left, *right, rig.T_C1C0());
  if (!stereo) return std::nullopt;
  return StereoPoint{*left, *stereo};
}

void MeshViewBuilder::AddSupport(const std::vector<SupportPoint>& support) {
  view_.first_match = LandmarkId{next_support_id_};
  for (SupportPoint point : support) {
    if (now_) {
      const auto found = Triangulate(point.px, point.px_right);
      if (!found || !(found->stereo.inverse_distance > 0)) continue;
      point.bearing = found->bearing;
      point.inverse_distance = found->stereo.inverse_distance;
    }
    const double distance_m = 1 / point.inverse_distance;
    const double sigma_m = distance_m * distance_m * point.sigma_inverse_distance;
    if (!(sigma_m <= max_support_sigma_ * distance_m)) continue;
    view_.points.push_back(
        {NextSupportId(), point.bearing, distance_m * point.bearing, sigma_m, point.intensity});
  }
  view_.end_match = LandmarkId{next_support_id_};
}

void MeshViewBuilder::AddBorder() {
  found_.clear();
  for (const Vector3d& place : border_places_) {
    if (const auto point = border_.Continue(view_, place)) found_.push_back(*point);
  }
  for (MeshPoint& point : found_) {
    point.id = NextSupportId();
    view_.points.push_back(point);
  }
}

}  // namespace facet
