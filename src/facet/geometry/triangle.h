// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include "facet/base/types.h"

namespace facet {

/// The point of the triangle abc that is nearest to p (Ericson, Real-Time Collision Detection,
/// 5.1.5).
Vector3d ClosestOnTriangle(const Vector3d& p,
                           const Vector3d& a,
                           const Vector3d& b,
                           const Vector3d& c);

}  // namespace facet
