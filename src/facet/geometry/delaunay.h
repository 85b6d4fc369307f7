// SPDX-License-Identifier: BSD-2-Clause
// Delaunay triangulation of points in the image (paper II-A.1), exact because it counts in
// integers: the same input gives the same triangles on every machine, and no input is degenerate.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace facet {

/// A point on an integer grid; both coordinates within +-kMaxGridCoordinate.
struct GridPoint {
  std::int32_t x = 0;
  std::int32_t y = 0;
  auto operator<=>(const GridPoint&) const = default;
};

inline constexpr std::int32_t kMaxGridCoordinate = 1 << 24;

/// Twice the signed area of a, b, c; positive when they turn from x towards y.
std::int64_t Orientation(GridPoint a, GridPoint b, GridPoint c);

/// Whether d lies inside the circle through a, b, c, which must turn from x towards y.
bool InCircle(GridPoint a, GridPoint b, GridPoint c, GridPoint d);

/// Divide and conquer over quad-edges (Guibas & Stolfi, ACM Transactions on Graphics 1985):
/// O(n log n) for every input. Keeps its buffers from call to call; not thread-safe.
class Delaunay {
 public:
  /// Triangles as indices into `points`, all turning from x towards y, in an order that depends on
  /// the points alone. Together they cover the convex hull. Of several points in one place only the
  /// first is used; points that all lie on one line have no triangles. Where four or more points
  /// lie on one circle, the choice is arbitrary but repeatable. CHECKs the range of the
  /// coordinates. The result is valid until the next call.
  const std::vector<std::array<int, 3>>& Triangulate(std::span<const GridPoint> points);

 private:
  // Directed edge; its reverse is the one with the lowest bit of the index flipped.
  struct Edge {
    int origin = -1;  // index into order_; -1: deleted
    int next = -1;    // next edge with the same origin, from x towards y
    int previous = -1;
  };
  // The edges of a part's convex hull out of its first and into its last point.
  struct Hull {
    int first = -1;
    int last = -1;
  };

  GridPoint At(int rank) const { return points_[static_cast<std::size_t>(order_[rank])]; }
  int Destination(int edge) const { return edges_[edge ^ 1].origin; }
  bool IsLeftOf(int rank, int edge) const;
  bool IsRightOf(int rank, int edge) const;
  int MakeEdge(int from, int to);
  void Splice(int a, int b);
  int Connect(int a, int b);
  void Delete(int edge);
  Hull Build(int begin, int end);
  Hull BuildThree(int begin);
  Hull Merge(Hull left, Hull right);
  int LeftCandidate(int base);
  int RightCandidate(int base);
  void CollectTriangles();

  std::span<const GridPoint> points_;
  std::vector<int> order_;  // distinct points from left to right
  std::vector<Edge> edges_;
  std::vector<std::array<int, 3>> triangles_;
};

}  // namespace facet
