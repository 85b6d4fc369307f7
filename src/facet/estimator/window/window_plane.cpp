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

bool PlaneLinks::Add(int plane, double row_scale) {
  if (count_ == kMax || Contains(plane)) return false;
  const auto k = static_cast<std::size_t>(count_++);
  index_[k] = plane;
  row_scale_[k] = row_scale;
  return true;
}

void PlaneLinks::Remove(int plane) {
  const int* found = std::find(begin(), end(), plane);
  if (found == end()) return;
  const auto k = found - begin();
  std::copy(index_.begin() + k + 1, index_.begin() + count_, index_.begin() + k);
  std::copy(row_scale_.begin() + k + 1, row_scale_.begin() + count_, row_scale_.begin() + k);
  --count_;
}

void PlaneLinks::RemoveFromWindow(int plane) {
  Remove(plane);
  for (int& other : index_)
    other -= other > plane;
}

}  // namespace facet
