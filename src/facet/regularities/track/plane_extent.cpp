// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/track/plane_extent.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"

namespace facet {

namespace {

constexpr double kCell_m = 0.1;
constexpr int kBlock = 5;  // cells along the side of a block
constexpr double kCoarse_m = kBlock * kCell_m;
constexpr int kMaxCells = 100;  // per side of one triangle

using Cell = std::array<int, 2>;

int FloorDivide(int a, int b) {
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}

// The middles of a block's cells.
template <class Function>
void ForEachCell(int x, int y, std::uint32_t mask, const Function& function) {
  const Vector2d corner = kCoarse_m * Vector2d(x, y);
  for (int bit = 0; bit < kBlock * kBlock; ++bit) {
    if ((mask >> bit & 1U) == 0) continue;
    function(Vector2d(corner + kCell_m * Vector2d(bit % kBlock + 0.5, bit / kBlock + 0.5)));
  }
}

// Bits of a rectangle of cells, as far as they lie in the block that both are counted from.
constexpr std::uint32_t CellsBetween(const Cell& first, const Cell& last) {
  const int left = std::max(0, first[0]), right = std::min(kBlock - 1, last[0]);
  if (left > right) return 0;
  const std::uint32_t columns = (2U << right) - (1U << left);
  std::uint32_t mask = 0;
  for (int row = std::max(0, first[1]); row <= std::min(kBlock - 1, last[1]); ++row)
    mask |= columns << (kBlock * row);
  return mask;
}

// Bits of the 3 x 3 cells around a cell, as far as they lie in the block that x and y are counted
// from; for cells from -1 to kBlock.
class CellsAround {
 public:
  constexpr CellsAround() {
    for (int y = -1; y <= kBlock; ++y) {
      for (int x = -1; x <= kBlock; ++x)
        masks_[Place(x, y)] = CellsBetween({x - 1, y - 1}, {x + 1, y + 1});
    }
  }

  std::uint32_t operator()(int x, int y) const { return masks_[Place(x, y)]; }

 private:
  static constexpr std::size_t Place(int x, int y) {
    return static_cast<std::size_t>((y + 1) * (kBlock + 2) + x + 1);
  }

  std::array<std::uint32_t, (kBlock + 2) * (kBlock + 2)> masks_{};
};

constexpr CellsAround kCellsAround;

// Into which block beside its own the 3 x 3 cells around a cell reach: -1, 1, or 0: none.
int BlockBeside(int cell) {
  if (cell == 0) return -1;
  return cell == kBlock - 1 ? 1 : 0;
}

// What is farther off than this has no cell: neither have coordinates that are not numbers.
constexpr double kMaxReach_m = 1e5;

bool HasCell(const Vector2d& xy) {
  return xy.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < kMaxReach_m;
}

// Rounds down what HasCell; without SSE 4.1 std::floor is a call.
int CellOf(double m, double size_m) {
  const double cells = m / size_m;
  const int towards_zero = static_cast<int>(cells);
  return towards_zero - (cells < towards_zero ? 1 : 0);
}

double Cross(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

}  // namespace

PlaneExtent::PlaneExtent(const Plane& plane_W, const Vector3d& origin_W)
    : origin_W_(origin_W), basis_(TangentBasis(plane_W.n)), n_W_(plane_W.n) {}

Vector2d PlaneExtent::ToPlane(const Vector3d& p_W) const {
  return basis_.transpose() * (p_W - origin_W_);
}

Vector3d PlaneExtent::ToWorld(const Vector2d& xy, const Plane& plane_W) const {
  const Vector3d p = origin_W_ + basis_ * xy;
  return p - plane_W.SignedDistance(p) * plane_W.n;
}

void PlaneExtent::AddTriangle(const std::array<Vector3d, 3>& p_W) {
  Vector2d a = ToPlane(p_W[0]), b = ToPlane(p_W[1]), c = ToPlane(p_W[2]);
  if (!HasCell(a) || !HasCell(b) || !HasCell(c)) return;
  if (Cross(a, b, c) < 0) std::swap(b, c);
  const Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const Cell first = {CellOf(low.x(), kCell_m), CellOf(low.y(), kCell_m)};
  const Cell last = {CellOf(high.x(), kCell_m), CellOf(high.y(), kCell_m)};
  if (last[0] - first[0] > kMaxCells || last[1] - first[1] > kMaxCells) return;
  // Which side of each edge a middle is on is linear along a column.
  const Vector3d step = kCell_m * Vector3d(b.x() - a.x(), c.x() - b.x(), a.x() - c.x());
  for (int x = first[0]; x <= last[0]; ++x) {
    const Vector2d middle = kCell_m * Vector2d(x + 0.5, first[1] + 0.5);
    const Vector3d sides(Cross(a, b, middle), Cross(b, c, middle), Cross(c, a, middle));
    for (int y = first[1]; y <= last[1]; ++y) {
      const Vector3d here = sides + (y - first[1]) * step;
      if (here.x() >= 0 && here.y() >= 0 && here.z() >= 0) AddCell(x, y);
    }
  }
}

void PlaneExtent::AddCell(int x, int y) {
  const int block_x = FloorDivide(x, kBlock), block_y = FloorDivide(y, kBlock);
  const int bit = (x - kBlock * block_x) + kBlock * (y - kBlock * block_y);
  std::uint32_t* const block = blocks_.At(block_x, block_y);
  if (block == nullptr || (*block >> bit & 1U) != 0) return;
  *block |= 1U << bit;
  ++num_cells_;
  sum_ += kCell_m * Vector2d(x + 0.5, y + 0.5);
}

void PlaneExtent::Remove(const Vector3d& p_W) {
  const Vector2d xy = ToPlane(p_W);
  if (!HasCell(xy)) return;
  const Cell middle = {CellOf(xy.x(), kCell_m), CellOf(xy.y(), kCell_m)};
  for (int x = middle[0] - 1; x <= middle[0] + 1; ++x) {
    for (int y = middle[1] - 1; y <= middle[1] + 1; ++y) {
      const int block_x = FloorDivide(x, kBlock), block_y = FloorDivide(y, kBlock);
      const std::uint32_t bit = 1U << ((x - kBlock * block_x) + kBlock * (y - kBlock * block_y));
      if ((blocks_.Get(block_x, block_y) & bit) == 0) continue;
      *blocks_.At(block_x, block_y) &= ~bit;
      --num_cells_;
      sum_ -= kCell_m * Vector2d(x + 0.5, y + 0.5);
    }
  }
}

// The cells of the other lie at an angle to these: a few stay empty.
void PlaneExtent::Add(const PlaneExtent& other, const Plane& plane_W) {
  other.blocks_.ForEach([&](int x, int y, std::uint32_t mask) {
    ForEachCell(x, y, mask, [&](const Vector2d& middle) {
      const Vector2d xy = ToPlane(other.ToWorld(middle, plane_W));
      AddCell(CellOf(xy.x(), kCell_m), CellOf(xy.y(), kCell_m));
    });
  });
}

// The cells around the point lie in one block, two or four; most often the first look tells.
bool PlaneExtent::HasSurface(const Vector3d& p_W) const {
  const Vector2d xy = ToPlane(p_W);
  if (!HasCell(xy)) return false;
  const Cell middle = {CellOf(xy.x(), kCell_m), CellOf(xy.y(), kCell_m)};
  const int block_x = FloorDivide(middle[0], kBlock), block_y = FloorDivide(middle[1], kBlock);
  const int x = middle[0] - kBlock * block_x, y = middle[1] - kBlock * block_y;
  if ((blocks_.Get(block_x, block_y) & kCellsAround(x, y)) != 0) return true;
  const int dx = BlockBeside(x), dy = BlockBeside(y);
  const auto has_any = [&](int right, int up) {
    return (blocks_.Get(block_x + right, block_y + up) &
            kCellsAround(x - kBlock * right, y - kBlock * up)) != 0;
  };
  return (dx != 0 && has_any(dx, 0)) || (dy != 0 && has_any(0, dy)) ||
         (dx != 0 && dy != 0 && has_any(dx, dy));
}

bool PlaneExtent::IsNear(const PlaneExtent& other, const Plane& plane_W, double radius_m) const {
  return other.blocks_.AnyOf([&](int x, int y, std::uint32_t) {
    for (int k = 0; k < 4; ++k) {
      const Vector2d corner = kCoarse_m * Vector2d(x + k % 2, y + k / 2);
      if (IsNear(other.ToWorld(corner, plane_W), radius_m)) return true;
    }
    return false;
  });
}

bool PlaneExtent::IsNear(const Vector3d& p_W, double radius_m) const {
  const Vector2d xy = ToPlane(p_W);
  if (!HasCell(xy)) return false;
  const int x = CellOf(xy.x(), kCoarse_m), y = CellOf(xy.y(), kCoarse_m);
  if (blocks_.Get(x, y) != 0) return true;  // most often
  const int reach = std::max(1, static_cast<int>(std::lround(radius_m / kCoarse_m)));
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int dy = -reach; dy <= reach; ++dy) {
      if (blocks_.Get(x + dx, y + dy) != 0) return true;
    }
  }
  return false;
}

double PlaneExtent::area_m2() const {
  return kCell_m * kCell_m * num_cells_;
}

Vector3d PlaneExtent::Centroid(const Plane& plane_W) const {
  if (num_cells_ == 0) return ToWorld(Vector2d::Zero(), plane_W);
  return ToWorld(sum_ / num_cells_, plane_W);
}

// Andrew's monotone chain.
std::vector<Vector3d> PlaneExtent::Outline(const Plane& plane_W) const {
  std::vector<Vector2d> corners;
  blocks_.ForEach([&](int x, int y, std::uint32_t mask) {
    ForEachCell(x, y, mask, [&](const Vector2d& middle) {
      for (int k = 0; k < 4; ++k)
        corners.push_back(middle + 0.5 * kCell_m * Vector2d(k % 2 * 2 - 1, k / 2 * 2 - 1));
    });
  });
  std::sort(corners.begin(), corners.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Vector2d> hull;
  const auto extend = [&](const Vector2d& p, std::size_t floor) {
    while (hull.size() >= floor + 2 && Cross(hull[hull.size() - 2], hull.back(), p) <= 1e-9)
      hull.pop_back();
    hull.push_back(p);
  };
  for (const Vector2d& p : corners)
    extend(p, 0);
  const std::size_t lower = hull.empty() ? 0 : hull.size() - 1;
  for (auto p = corners.rbegin(); p != corners.rend(); ++p)
    extend(*p, lower);
  if (!hull.empty()) hull.pop_back();
  const bool is_right_handed = basis_.col(0).cross(basis_.col(1)).dot(plane_W.n) > 0;
  if (!is_right_handed) std::reverse(hull.begin(), hull.end());
  std::vector<Vector3d> out;
  for (const Vector2d& p : hull)
    out.push_back(ToWorld(p, plane_W));
  return out;
}

}  // namespace facet
