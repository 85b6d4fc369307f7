// SPDX-License-Identifier: BSD-2-Clause
// Joins what the front end saw in a keyframe with what the estimator knows, for the mesh.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "facet/calibration/lens_modes.h"
#include "facet/camera/stereo_rig.h"
#include "facet/camera/stereo_triangulation.h"
#include "facet/frontend/stereo_frontend.h"
#include "facet/map/map_snapshot.h"
#include "facet/mesh/border_points.h"
#include "facet/mesh/mesh_options.h"
#include "facet/mesh/mesh_view.h"

namespace facet {

/// Keeps its buffers; not thread-safe. Never throws for any content of the observations.
class MeshViewBuilder {
 public:
  MeshViewBuilder(const StereoRig& rig, const MeshOptions& options);

  /// The points of a keyframe with a pose.
  const MeshView& Build(const FrontendResult& keyframe, const MapSnapshot& snapshot);

  /// The view that the last Build made.
  const MeshView& view() const { return view_; }

 private:
  struct StereoPoint {
    Vector3d bearing;  // unit vector of the left camera
    StereoDistance stereo;
  };

  void SetRig(const std::shared_ptr<const StereoRig>& now);
  void AddObservations(const FrontendResult& keyframe, const MapSnapshot& snapshot);
  void AddUnknownCorner(const FeatureObservation& feature, std::uint8_t intensity);
  void AddSupport(const std::vector<SupportPoint>& support);
  /// By the present calibration.
  std::optional<StereoPoint> Triangulate(const Vector2d& px, const Vector2d& px_right) const;
  void AddBorder();
  LandmarkId NextSupportId() { return LandmarkId{next_support_id_++}; }

  MeshOptions options_;
  StereoRig rig_;                         // the calibration that was given
  std::shared_ptr<const StereoRig> now_;  // at present; null: that one
  LensFields beside_model_;               // of the lenses at present
  double max_support_sigma_;              // of the distance, over itself
  std::vector<Vector3d> border_places_;   // bearings on the image's border; empty: not used
  BorderPoints border_;
  std::vector<MeshPoint> found_;  // buffer of AddBorder
  MeshView view_;
  std::int64_t next_support_id_ = kFirstSupportId;
};

}  // namespace facet
