// SPDX-License-Identifier: BSD-2-Clause
// Planes of the window, the relations between them, and which landmark lies on which plane.
#pragma once

#include <array>
#include <cstddef>

#include "facet/base/types.h"
#include "facet/geometry/plane.h"
#include "facet/map/plane_relation.h"

namespace facet {

/// One plane in the window: n . (p - anchor) = offset. The anchor is a constant near the surface,
/// so that normal and offset are hardly correlated wherever the origin is (docs/math.md, section
/// 7).
struct WindowPlane {
  PlaneId id;
  Vector3d anchor_W;
  Vector3d n;               ///< unit normal in W
  double offset;            ///< [m]
  double unevenness_m = 0;  ///< how far the surface is from flat, 1-sigma; 0: as planes usually are
  double row_sigma_m;       ///< 1-sigma of the rows that hold landmarks on it (WeighPlanes)

  /// Once the prior touches it, Jacobians are taken at n_lin, and n = n_lin (+) delta.
  bool frozen = false;
  /// Known well enough to linearise about for good: only then may the prior touch it.
  bool persistent = false;
  Vector3d n_lin;
  Vector3d delta = Vector3d::Zero();  ///< two tangent directions at n_lin [rad], offset [m]

  WindowPlane(PlaneId plane_id, const Plane& plane, const Vector3d& anchor, double row_sigma)
      : id(plane_id),
        anchor_W(anchor),
        n(plane.n),
        offset(plane.d - plane.n.dot(anchor)),
        row_sigma_m(row_sigma),
        n_lin(plane.n) {}

  Plane plane() const { return {n, offset + n.dot(anchor_W)}; }
  double SignedDistance(const Vector3d& p_W) const { return n.dot(p_W - anchor_W) - offset; }

  /// Two tangent directions (TangentBasis of n_lin), offset.
  void ApplyStep(const Vector3d& step);

  /// From here on the Jacobians are taken at the present normal, unless they already are at one.
  void Freeze();
};

/// A relation in force. It is expressed relative to one frame, so that neither a common translation
/// nor a common turn about gravity changes anything (docs/math.md, section 8).
struct WindowRelation {
  PlaneRelation relation;               ///< Canonical()
  FrameId frame;                        ///< in the window; its heading carries the relation along
  Vector3d point_B = Vector3d::Zero();  ///< held to that frame: where offsets are compared
};

/// The planes a landmark lies on, as indices into SlidingWindow::planes: an edge has two, a corner
/// three.
class PlaneLinks {
 public:
  static constexpr int kMax = 3;

  int count() const { return count_; }
  const int* begin() const { return index_.data(); }
  const int* end() const { return index_.data() + count_; }
  int operator[](int k) const { return index_[static_cast<std::size_t>(k)]; }

  bool Contains(int plane) const;

  /// Times the plane's row_sigma_m: the 1-sigma of the k-th link's row.
  double row_scale(int k) const { return row_scale_[static_cast<std::size_t>(k)]; }

  /// False if it is there already or there is no room.
  bool Add(int plane, double row_scale = 1);
  void Remove(int plane);

  /// The plane with this index is no longer in the window: removes it, and the later ones move up.
  void RemoveFromWindow(int plane);

 private:
  int count_ = 0;
  std::array<int, kMax> index_{};
  std::array<double, kMax> row_scale_{};
};

}  // namespace facet
