// SPDX-License-Identifier: BSD-2-Clause
// What planes have to do with each other and with gravity (the paper's future work, section IV).
#pragma once

#include <compare>
#include <utility>

#include "facet/base/types.h"

namespace facet {

enum class PlaneRelationKind {
  kParallel,           ///< normals are equal or opposite
  kOrthogonal,         ///< normals are perpendicular
  kCoplanar,           ///< one surface: parallel, and at the same offset
  kHorizontal,         ///< one plane, its normal along gravity
  kVertical,           ///< one plane, its normal across gravity
  kHeadingParallel,    ///< of upright planes: normals seen from above are equal or opposite
  kHeadingOrthogonal,  ///< of upright planes: normals seen from above are perpendicular
};

/// A soft constraint on one plane (`b` is not valid) or on two; of two planes the order says
/// nothing. Link many planes to one representative: a clique counts the same fact many times.
struct PlaneRelation {
  PlaneRelationKind kind = PlaneRelationKind::kParallel;
  PlaneId a;
  PlaneId b{};

  bool IsUnary() const {
    return kind == PlaneRelationKind::kHorizontal || kind == PlaneRelationKind::kVertical;
  }
  bool Involves(PlaneId plane) const { return a == plane || (!IsUnary() && b == plane); }

  /// The same relation with the planes in order of their ids, and no second one where none belongs.
  PlaneRelation Canonical() const {
    if (IsUnary()) return {kind, a, PlaneId{}};
    return b < a ? PlaneRelation{kind, b, a} : *this;
  }
  bool operator==(const PlaneRelation&) const = default;
};

}  // namespace facet
