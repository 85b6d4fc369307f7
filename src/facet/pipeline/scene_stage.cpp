// SPDX-License-Identifier: BSD-2-Clause
#include "facet/pipeline/scene_stage.h"

#include <memory>
#include <utility>

#include "facet/camera/image_extent.h"
#include "facet/mesh/mesh_snapshot.h"
#include "facet/regularities/report/plane_ids.h"

namespace facet {

namespace {

bool PlanesJudgeFaces(const VioOptions& options) {
  return options.pipeline == Formulation::kSPR && options.regularities.faces.enabled;
}

MeshOptions MeshOptionsOf(const VioOptions& options, const CameraModel& camera) {
  const MeshOptions& mesh = options.mesh;
  return ForPointsApart(options.frontend.support.enabled ? WithSupportPoints(mesh) : mesh,
                        RelativeViewAngle(camera));
}

}  // namespace

SceneStage::SceneStage(const StereoRig& rig, const VioOptions& options)
    : options_(MeshOptionsOf(options, rig.cameras[0])),
      T_BC_(rig.T_BC[0]),
      view_builder_(rig, options_),
      horizon_(options_, PlanesJudgeFaces(options)),
      map_(options_.map) {
  if (options.pipeline == Formulation::kSPR) planes_.emplace(options.regularities);
  if (options.pipeline == Formulation::kSP) projections_.emplace(options.regularities.detection);
}

void SceneStage::UpdateMesh(const TrackedFrame& frame, VioOutput& out) {
  if (out.was_reset) Reset();
  if (!IsWorked(out)) return;
  const ScopedStage stage(out.times, Stage::kMesh);
  horizon_.Update(view_builder_.Build(frame.frontend, *out.snapshot), *out.snapshot, T_BC_);
  KeepExpiredFaces();
}

RegularityResult SceneStage::FindPlanes(VioOutput& out) {
  if (!IsWorked(out) || (!planes_ && !projections_)) return {};
  const ScopedStage stage(out.times, Stage::kRegularities);
  horizon_.FillSearchMesh(view_builder_.view(), search_mesh_);
  if (planes_) return planes_->Process(search_mesh_, *out.snapshot);
  return {projections_->Process(search_mesh_, *out.snapshot), {}};
}

void SceneStage::ShowPlanes(const MeshRegularities& regularities, VioOutput& out) {
  if (!IsWorked(out)) return;
  const ScopedStage stage(out.times, Stage::kMesh);
  if (planes_) horizon_.Take(regularities);
  out.mesh = std::make_shared<MeshSnapshot>(MakeMeshSnapshot(view_builder_.view(), horizon_));
  if (is_update_wanted_.exchange(false)) AddUpdate(out);
}

void SceneStage::AddUpdate(VioOutput& out) {
  auto update = std::make_shared<SceneUpdate>();
  if (options_.map.enabled) {
    // 16 MB, which are copied in a few milliseconds.
    constexpr std::size_t kMostBlocks = 2048;
    update->map_blocks = map_.TakeChanged(kMostBlocks);
    update->is_partial = update->map_blocks.size() == kMostBlocks;
  }
  if (planes_) update->planes = planes_->Records();
  out.scene_update = std::move(update);
}

// What was in the horizon stays in the map as it is.
void SceneStage::Reset() {
  horizon_.Clear();
  KeepExpiredFaces();
  if (planes_) planes_->Reset();
  if (projections_) projections_->Reset();
}

void SceneStage::KeepExpiredFaces() {
  if (!options_.map.enabled) return;
  for (const ExpiredFace& face : horizon_.expired())
    map_.Add(face);
}

TriangleMesh SceneStage::MeshOf(SurfaceMap map, HorizonMesh horizon, MapMemory& memory) const {
  const SurfaceMap whole = WithHorizon(std::move(map), std::move(horizon));
  memory = whole.memory();
  TriangleMesh mesh = ExtractSurface(whole);
  if (planes_) UseCurrentPlaneIds(planes_->Records(), mesh.plane_ids);
  return mesh;
}

std::optional<TriangleMesh> SceneStage::Map(MapMemory& memory) const {
  memory = map_.memory();
  if (!options_.enabled || !options_.map.enabled) return std::nullopt;
  return MeshOf(map_, horizon_, memory);
}

std::optional<TriangleMesh> SceneStage::TakeMap(MapMemory& memory) {
  memory = map_.memory();
  if (!options_.enabled || !options_.map.enabled) return std::nullopt;
  return MeshOf(std::move(map_), std::move(horizon_), memory);
}

std::optional<std::vector<PlaneRecord>> SceneStage::Planes() const {
  if (!planes_) return std::nullopt;
  return planes_->Records();
}

}  // namespace facet
