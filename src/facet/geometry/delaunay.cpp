// SPDX-License-Identifier: BSD-2-Clause
#include "facet/geometry/delaunay.h"

#include <algorithm>
#include <cstdlib>

#include "facet/base/check.h"

namespace facet {
namespace {

// Differences of coordinates have 26 bits, the terms of InCircle at most 106.
__extension__ using Int128 = __int128;

}  // namespace

std::int64_t Orientation(GridPoint a, GridPoint b, GridPoint c) {
  const auto difference = [](std::int32_t p, std::int32_t q) { return std::int64_t{p} - q; };
  return difference(b.x, a.x) * difference(c.y, a.y) - difference(b.y, a.y) * difference(c.x, a.x);
}

bool InCircle(GridPoint a, GridPoint b, GridPoint c, GridPoint d) {
  const std::int64_t ax = std::int64_t{a.x} - d.x, ay = std::int64_t{a.y} - d.y;
  const std::int64_t bx = std::int64_t{b.x} - d.x, by = std::int64_t{b.y} - d.y;
  const std::int64_t cx = std::int64_t{c.x} - d.x, cy = std::int64_t{c.y} - d.y;
  const Int128 determinant = Int128{ax * ax + ay * ay} * (bx * cy - by * cx) +
                             Int128{bx * bx + by * by} * (cx * ay - cy * ax) +
                             Int128{cx * cx + cy * cy} * (ax * by - ay * bx);
  return determinant > 0;
}

bool Delaunay::IsLeftOf(int rank, int edge) const {
  return Orientation(At(rank), At(edges_[edge].origin), At(Destination(edge))) > 0;
}

bool Delaunay::IsRightOf(int rank, int edge) const {
  return Orientation(At(rank), At(Destination(edge)), At(edges_[edge].origin)) > 0;
}

int Delaunay::MakeEdge(int from, int to) {
  const int edge = static_cast<int>(edges_.size());
  edges_.push_back({from, edge, edge});
  edges_.push_back({to, edge + 1, edge + 1});
  return edge;
}

void Delaunay::Splice(int a, int b) {
  if (a == b) return;
  const int a_next = edges_[a].next, b_next = edges_[b].next;
  edges_[a_next].previous = b;
  edges_[b_next].previous = a;
  edges_[a].next = b_next;
  edges_[b].next = a_next;
}

// An edge from the end of a to the start of b, so that all three have the same face on the left.
int Delaunay::Connect(int a, int b) {
  const int edge = MakeEdge(Destination(a), edges_[b].origin);
  Splice(edge, edges_[a ^ 1].previous);
  Splice(edge ^ 1, b);
  return edge;
}

void Delaunay::Delete(int edge) {
  Splice(edge, edges_[edge].previous);
  Splice(edge ^ 1, edges_[edge ^ 1].previous);
  edges_[edge].origin = edges_[edge ^ 1].origin = -1;
}

Delaunay::Hull Delaunay::BuildThree(int begin) {
  const int a = MakeEdge(begin, begin + 1), b = MakeEdge(begin + 1, begin + 2);
  Splice(a ^ 1, b);
  const std::int64_t turn = Orientation(At(begin), At(begin + 1), At(begin + 2));
  if (turn == 0) return {a, b ^ 1};
  const int c = Connect(b, a);
  if (turn > 0) return {a, b ^ 1};
  return {c ^ 1, c};
}

Delaunay::Hull Delaunay::Build(int begin, int end) {
  if (end - begin == 2) {
    const int edge = MakeEdge(begin, begin + 1);
    return {edge, edge ^ 1};
  }
  if (end - begin == 3) return BuildThree(begin);
  const int middle = begin + (end - begin) / 2;
  const Hull left = Build(begin, middle);
  return Merge(left, Build(middle, end));
}

// The next point of the left part that the rising base meets, as an edge from the base's end;
// deletes edges that are not Delaunay any more. Invalid (not right of the base) if there is none.
int Delaunay::LeftCandidate(int base) {
  int candidate = edges_[base ^ 1].next;
  if (!IsRightOf(Destination(candidate), base)) return candidate;
  while (InCircle(At(Destination(base)),
                  At(edges_[base].origin),
                  At(Destination(candidate)),
                  At(Destination(edges_[candidate].next)))) {
    const int next = edges_[candidate].next;
    Delete(candidate);
    candidate = next;
  }
  return candidate;
}

int Delaunay::RightCandidate(int base) {
  int candidate = edges_[base].previous;
  if (!IsRightOf(Destination(candidate), base)) return candidate;
  while (InCircle(At(Destination(base)),
                  At(edges_[base].origin),
                  At(Destination(candidate)),
                  At(Destination(edges_[candidate].previous)))) {
    const int next = edges_[candidate].previous;
    Delete(candidate);
    candidate = next;
  }
  return candidate;
}

Delaunay::Hull Delaunay::Merge(Hull left, Hull right) {
  int left_inner = left.last, right_inner = right.first;
  while (true) {  // down to the lower common tangent
    if (IsLeftOf(edges_[right_inner].origin, left_inner)) {
      left_inner = edges_[left_inner ^ 1].previous;
    } else if (IsRightOf(edges_[left_inner].origin, right_inner)) {
      right_inner = edges_[right_inner ^ 1].next;
    } else {
      break;
    }
  }
  int base = Connect(right_inner ^ 1, left_inner);
  if (edges_[left_inner].origin == edges_[left.first].origin) left.first = base ^ 1;
  if (edges_[right_inner].origin == edges_[right.last].origin) right.last = base;
  while (true) {  // the base rises like a bubble
    const int l = LeftCandidate(base), r = RightCandidate(base);
    const bool left_is_valid = IsRightOf(Destination(l), base);
    const bool right_is_valid = IsRightOf(Destination(r), base);
    if (!left_is_valid && !right_is_valid) break;
    const bool takes_right = !left_is_valid || (right_is_valid && InCircle(At(Destination(l)),
                                                                           At(edges_[l].origin),
                                                                           At(edges_[r].origin),
                                                                           At(Destination(r))));
    base = takes_right ? Connect(r, base ^ 1) : Connect(base ^ 1, l ^ 1);
  }
  return {left.first, right.last};
}

void Delaunay::CollectTriangles() {
  const auto left_next = [this](int edge) { return edges_[edge ^ 1].previous; };
  for (int a = 0; a < static_cast<int>(edges_.size()); ++a) {
    if (edges_[a].origin < 0) continue;
    const int b = left_next(a), c = left_next(b);
    if (b < a || c < a || left_next(c) != a) continue;  // each face once
    const int i = edges_[a].origin, j = edges_[b].origin, k = edges_[c].origin;
    if (Orientation(At(i), At(j), At(k)) <= 0) continue;  // the outside of a single triangle
    triangles_.push_back({order_[i], order_[j], order_[k]});
  }
}

const std::vector<std::array<int, 3>>& Delaunay::Triangulate(std::span<const GridPoint> points) {
  points_ = points;
  order_.clear();
  edges_.clear();
  triangles_.clear();
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    FACET_CHECK(std::abs(points[i].x) <= kMaxGridCoordinate &&
                std::abs(points[i].y) <= kMaxGridCoordinate)
        << points[i].x << ' ' << points[i].y;
    order_.push_back(i);
  }
  std::sort(order_.begin(), order_.end(), [&](int i, int j) {
    if (points[i] != points[j]) return points[i] < points[j];
    return i < j;
  });
  const auto same = [&](int i, int j) { return points[i] == points[j]; };
  order_.erase(std::unique(order_.begin(), order_.end(), same), order_.end());
  if (order_.size() < 3) return triangles_;
  Build(0, static_cast<int>(order_.size()));
  CollectTriangles();
  return triangles_;
}

}  // namespace facet
