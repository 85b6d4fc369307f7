// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/window/window_plane.h"

#include <algorithm>

namespace facet {

void WindowPlane::ApplyStep(const Vector3d& step) {
  offset += step.z();
  if (frozen) {
    delta += step;
    n = RetractDirection(n_lin, delta.head<2>());
  } else {
    n = n_lin = RetractDirection(n, step.head<2>());
  }
}

void WindowPlane::Freeze() {
  if (frozen) return;
  frozen = true;
  n_lin = n;
  delta.setZero();
}

bool PlaneLinks::Contains(int plane) const {
  return std::find(begin(), end(), plane) != end();
}

bool PlaneLinks::Add(int plane) {
  if (count_ == kMax || Contains(plane)) return false;
  index_[static_cast<std::size_t>(count_++)] = plane;
  return true;
}

void PlaneLinks::Remove(int plane) {
  const auto last = std::remove(index_.begin(), index_.begin() + count_, plane);
  count_ = static_cast<int>(last - index_.begin());
}

void PlaneLinks::RemoveFromWindow(int plane) {
  Remove(plane);
  for (int& other : index_)
    other -= other > plane;
}

}  // namespace facet
