// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/mesh_stage.h"

namespace facet {

MeshStage::MeshStage(const StereoRig& rig, const MeshOptions& options)
    : options_(options),
      camera_(rig.cameras[0]),
      T_BC_(rig.T_BC[0]),
      horizon_(options),
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
    if (known == snapshot.landmarks.end()) break;
    if (known->id != feature.landmark || known->num_observations < options_.min_observations)
      continue;
    const auto undistorted = camera_.Undistort(feature.px_left);
    if (!undistorted) continue;
    view_.points.push_back({feature.landmark,
                            undistorted->xy,
                            T_CW * known->p_W,
                            known->sigma_depth_m,
                            images.intensities[i]});
  }
}

void MeshStage::AddSupport(const MeshPacket& images) {
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
}

std::shared_ptr<MeshSnapshot> MeshStage::Process(const FrameObservations& observations,
                                                 const MeshPacket& images,
                                                 const MapSnapshot& snapshot) {
  if (!options_.enabled) return nullptr;
  FillView(observations, images, snapshot);
  AddSupport(images);
  horizon_.Update(view_, snapshot, T_BC_);
  KeepLostFaces();
  return std::make_shared<MeshSnapshot>(MakeMeshSnapshot(view_, horizon_));
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
  SurfaceMap whole = map_;
  HorizonMesh horizon = horizon_;
  horizon.Clear();
  for (const LostFace& face : horizon.lost())
    whole.Add(face);
  return ExtractSurface(whole);
}

}  // namespace facet
