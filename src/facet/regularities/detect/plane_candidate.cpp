// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/detect/plane_candidate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "facet/geometry/angles.h"
#include "facet/geometry/plane_fit.h"
#include "facet/geometry/so3.h"
#include "facet/regularities/detect/common_error.h"
#include "facet/regularities/detect/surface_step.h"

namespace facet {

namespace {

constexpr double kMinBand_m = 0.01;  // half thickness that every plane is granted
constexpr int kMinVertices = 10;     // on a plane
// RMS distance of its points above which a plane is none, or 1.5 times what is expected of them.
constexpr double kMaxThickness_m = 0.02;
const double kMinFaceCosine = std::cos(kMaxFaceAngle);
constexpr double kMaxTurn = 20 * kDegree;  // from the peak to the fit
// Beyond these a face is on no plane that a fit from the peak can turn to.
const double kMinAroundCosine = std::cos(45 * kDegree);
constexpr double kMaxAround_m = 0.5;
constexpr int kMaxRounds = 8;
constexpr int kMaxSplits = 2;
constexpr double kCell_m = 0.3;  // pieces farther apart than a cell are not connected

struct WeightedPlane {
  PlaneFit fit;
  std::vector<Vector3d> points;
  std::vector<double> weights;
  double total_weight = 0;
  double expected_thickness_m = 0;
  double length_scale = 1;
};

double MeanLengthScale(const SurfaceFaces& faces, const std::vector<int>& corners) {
  double sum = 0;
  for (const int corner : corners)
    sum += faces.points[corner].length_scale;
  return corners.empty() ? 1 : sum / static_cast<double>(corners.size());
}

// Lists each corner of some faces once. It keeps its marks, because it is asked several times for
// every plane that is tried.
class CornerLister {
 public:
  explicit CornerLister(const SurfaceFaces& faces)
      : faces_(faces), listed_in_(faces.points.size(), 0) {}

  /// Returns the corners of these faces, each once; valid until the next call.
  const std::vector<int>& DistinctCorners(const std::vector<int>& on_plane) {
    ++call_;
    corners_.clear();
    for (const int f : on_plane) {
      for (const int corner : faces_.faces[f].corners) {
        if (listed_in_[corner] != call_) corners_.push_back(corner);
        listed_in_[corner] = call_;
      }
    }
    return corners_;
  }

 private:
  const SurfaceFaces& faces_;
  std::vector<int> listed_in_;  // by corner: the last call that has listed it
  int call_ = 0;
  std::vector<int> corners_;
};

// Each corner with its own uncertainty across the plane.
WeightedPlane FitCorners(const SurfaceFaces& faces,
                         const std::vector<int>& corners,
                         const Vector3d& n_W) {
  WeightedPlane out;
  out.points.reserve(corners.size());
  out.weights.reserve(corners.size());
  for (const int corner : corners) {
    const FacePoint& point = faces.points[corner];
    out.points.push_back(point.p_W);
    out.weights.push_back(1 / point.VarianceFromSurface(n_W));
    out.total_weight += out.weights.back();
  }
  if (out.points.empty()) return out;
  out.length_scale = MeanLengthScale(faces, corners);
  out.fit = FitPlane(out.points, out.weights);
  out.expected_thickness_m = std::sqrt(static_cast<double>(out.points.size()) / out.total_weight);
  if (out.fit.plane.n.dot(n_W) < 0) {
    out.fit.plane.n = -out.fit.plane.n;
    out.fit.plane.d = -out.fit.plane.d;
  }
  return out;
}

// A cell of a grid on a plane; cells are ordered by x, then y.
using Cell = std::pair<int, int>;

// The piece of each cell: neighbours, also across corners, are in the same. `cells` is ascending.
std::vector<int> LabelPieces(const std::vector<Cell>& cells, int& num_pieces) {
  std::vector<int> pieces(cells.size(), -1);
  std::vector<std::size_t> open;
  num_pieces = 0;
  for (std::size_t seed = 0; seed < cells.size(); ++seed) {
    if (pieces[seed] >= 0) continue;
    pieces[seed] = num_pieces;
    open.assign(1, seed);
    while (!open.empty()) {
      const auto [x, y] = cells[open.back()];
      open.pop_back();
      for (int column = x - 1; column <= x + 1; ++column) {
        auto cell = std::lower_bound(cells.begin(), cells.end(), Cell(column, y - 1));
        for (; cell != cells.end() && *cell <= Cell(column, y + 1); ++cell) {
          const auto k = static_cast<std::size_t>(cell - cells.begin());
          if (pieces[k] >= 0) continue;
          pieces[k] = num_pieces;
          open.push_back(k);
        }
      }
    }
    ++num_pieces;
  }
  return pieces;
}

// Splits faces of one plane into pieces that are connected over a grid of cells.
std::vector<std::vector<int>> ConnectedPieces(const SurfaceFaces& faces,
                                              const std::vector<int>& on_plane,
                                              const std::vector<int>& corners,
                                              const Plane& plane_W) {
  const Matrix<3, 2> basis = TangentBasis(plane_W.n);
  const double cell_m = MeanLengthScale(faces, corners) * kCell_m;
  const auto cell_of = [&](const Vector3d& p_W) {
    const Vector2d xy = basis.transpose() * p_W / cell_m;
    return Cell(static_cast<int>(std::floor(xy.x())), static_cast<int>(std::floor(xy.y())));
  };
  std::vector<Cell> cells, middles;
  for (const int f : on_plane)
    middles.push_back(cell_of(faces.faces[f].centre_W));
  for (const int corner : corners)
    cells.push_back(cell_of(faces.points[corner].p_W));
  cells.insert(cells.end(), middles.begin(), middles.end());
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  int num_pieces = 0;
  const std::vector<int> piece_of_cell = LabelPieces(cells, num_pieces);
  std::vector<std::vector<int>> pieces(static_cast<std::size_t>(num_pieces));
  for (std::size_t i = 0; i < on_plane.size(); ++i) {
    const auto cell = std::lower_bound(cells.begin(), cells.end(), middles[i]);
    pieces[piece_of_cell[cell - cells.begin()]].push_back(on_plane[i]);
  }
  return pieces;
}

Matrix3d NormalCovariance(const WeightedPlane& plane, double inflation, double common_slope) {
  // The normal turns about each principal direction by an error that the spread across it averages.
  const Vector3d n = plane.fit.plane.n;
  const double w = plane.total_weight;
  const double minor = plane.fit.extent_minor_m, major = plane.fit.extent_major_m;
  const Vector3d e_major = plane.fit.major_W;
  const Vector3d e_minor = n.cross(e_major);
  const double common = common_slope * common_slope;
  return (inflation / (w * major * major) + common) * e_major * e_major.transpose() +
         (inflation / (w * minor * minor) + common) * e_minor * e_minor.transpose();
}

// Large, thin, wide and straight enough.
bool IsAcceptable(const WeightedPlane& plane, const Plane& start, double min_extent_m) {
  const double max_thickness =
      std::max(plane.length_scale * kMaxThickness_m, 1.5 * plane.expected_thickness_m);
  return static_cast<int>(plane.points.size()) >= kMinVertices &&
         plane.fit.extent_minor_m >= min_extent_m && plane.fit.thickness_m <= max_thickness &&
         plane.fit.plane.n.dot(start.n) >= std::cos(kMaxTurn);
}

// Positive when most of the surface was seen from where the normal points to.
double SideOf(const SurfaceFaces& faces, const std::vector<int>& on_plane, const Vector3d& n_W) {
  double side = 0;
  for (const int f : on_plane)
    side += faces.faces[f].area_m2 * faces.faces[f].n_W.dot(n_W);
  return side;
}

PlaneCandidate MakeCandidate(const SurfaceFaces& faces,
                             std::vector<int> on_plane,
                             const WeightedPlane& plane,
                             const DetectionOptions& options) {
  const double ratio = plane.fit.thickness_m / plane.expected_thickness_m;
  const double inflation = std::max(1.0, ratio * ratio);
  PlaneCandidate candidate;
  candidate.plane_W = plane.fit.plane;
  candidate.centroid_W = plane.fit.centroid;
  candidate.area_m2 = AreaOf(faces, on_plane);
  candidate.thickness_m = plane.fit.thickness_m;
  const CommonError common = CommonErrorOf(plane.fit.plane, plane.fit.centroid, faces.camera);
  candidate.normal_covariance = NormalCovariance(plane, inflation, common.slope_rad);
  candidate.length_scale = plane.length_scale;
  candidate.offset_variance_m2 = inflation / plane.total_weight + common.offset_m * common.offset_m;
  candidate.orientation =
      OrientationOf(candidate.plane_W.n, candidate.normal_covariance, options.max_plane_lean_deg);
  if (SideOf(faces, on_plane, candidate.plane_W.n) < 0) {
    candidate.plane_W.n = -candidate.plane_W.n;
    candidate.plane_W.d = -candidate.plane_W.d;
  }
  candidate.faces = std::move(on_plane);
  return candidate;
}

std::vector<int> Without(const std::vector<int>& faces, const std::vector<int>& taken) {
  std::vector<int> out;
  std::set_difference(
      faces.begin(), faces.end(), taken.begin(), taken.end(), std::back_inserter(out));
  return out;
}

// All lists of faces are ascending.
class CandidateSearch {
 public:
  CandidateSearch(const SurfaceFaces& faces, double min_area_m2, const DetectionOptions& options)
      : faces_(faces), min_area_m2_(min_area_m2), options_(options), corners_(faces) {}

  // A plane that bridges two surfaces, or lies across them, is taken apart, and each part finds its
  // own faces.
  void Run(const std::vector<int>& pool,
           const Plane& start,
           int num_splits,
           std::vector<PlaneCandidate>& out) {
    Plane plane = start;
    std::vector<int> on_plane;
    for (int round = 0; round < kMaxRounds; ++round) {
      std::vector<int> found = FacesOnPlane(faces_, pool, plane, options_.max_distance_m);
      if (SearchAreaOf(faces_, found) < min_area_m2_) return;
      if (found == on_plane) break;
      on_plane = std::move(found);
      plane = Fit(on_plane, plane.n).fit.plane;
    }
    const std::vector<std::vector<int>> pieces =
        ConnectedPieces(faces_, on_plane, corners_.DistinctCorners(on_plane), plane);
    if (pieces.size() > 1 && num_splits > 0) {
      const auto is_large = [&](const std::vector<int>& piece) {
        return SearchAreaOf(faces_, piece) >= min_area_m2_;
      };
      const auto num_large = std::count_if(pieces.begin(), pieces.end(), is_large);
      // One among crumbs only has to find its own plane.
      RunParts(
          pieces, pool, start, num_large > 1 ? num_splits - 1 : std::min(num_splits - 1, 1), out);
      return;
    }
    for (const std::vector<int>& piece : pieces) {
      if (SearchAreaOf(faces_, piece) < min_area_m2_) continue;
      const WeightedPlane fit = Fit(piece, start.n);
      const auto step = FindStep(fit.points, fit.weights, fit.fit, fit.length_scale);
      if (!step) {
        Accept(piece, fit, start, out);
      } else if (num_splits > 0) {
        RunParts(BothSides(piece, *step), pool, start, num_splits - 1, out);
      } else {  // extending the sides led here again
        for (const std::vector<int>& side : BothSides(piece, *step))
          Accept(side, Fit(side, start.n), start, out);
      }
    }
  }

 private:
  WeightedPlane Fit(const std::vector<int>& on_plane, const Vector3d& n_W) {
    return FitCorners(faces_, corners_.DistinctCorners(on_plane), n_W);
  }

  void Accept(const std::vector<int>& on_plane,
              const WeightedPlane& fit,
              const Plane& start,
              std::vector<PlaneCandidate>& out) const {
    if (static_cast<int>(on_plane.size()) >= options_.min_faces &&
        SearchAreaOf(faces_, on_plane) >= min_area_m2_ &&
        IsAcceptable(fit, start, MinExtent_m(faces_, on_plane, options_)))
      out.push_back(MakeCandidate(faces_, on_plane, fit, options_));
  }

  void RunParts(const std::vector<std::vector<int>>& parts,
                std::vector<int> pool,
                const Plane& start,
                int num_splits,
                std::vector<PlaneCandidate>& out) {
    const std::size_t num_before = out.size();
    for (std::vector<int> part : parts) {
      for (std::size_t k = num_before; k < out.size(); ++k)
        part = Without(part, out[k].faces);
      if (SearchAreaOf(faces_, part) < min_area_m2_) continue;
      const WeightedPlane fit = Fit(part, start.n);
      if (static_cast<int>(fit.points.size()) < kMinVertices) continue;
      const std::size_t first = out.size();
      Run(pool, fit.fit.plane, num_splits, out);
      for (std::size_t k = first; k < out.size(); ++k)
        pool = Without(pool, out[k].faces);
    }
  }

  std::vector<std::vector<int>> BothSides(const std::vector<int>& piece,
                                          const SurfaceStep& step) const {
    std::vector<std::vector<int>> sides(2);
    for (const int f : piece)
      sides[step.IsBeyond(faces_.faces[f].centre_W) ? 1 : 0].push_back(f);
    return sides;
  }

  const SurfaceFaces& faces_;
  const double min_area_m2_;
  const DetectionOptions& options_;
  CornerLister corners_;
};

}  // namespace

double AreaOf(const SurfaceFaces& faces, std::span<const int> on_plane) {
  double area = 0;
  for (const int f : on_plane)
    area += faces.faces[f].area_m2;
  return area;
}

double SearchAreaOf(const SurfaceFaces& faces, std::span<const int> on_plane) {
  double area = 0;
  for (const int f : on_plane)
    area += faces.faces[f].search_area_m2;
  return area;
}

// Lengths go with the root of areas.
double MinExtent_m(const SurfaceFaces& faces,
                   std::span<const int> on_plane,
                   const DetectionOptions& options) {
  const double counted = SearchAreaOf(faces, on_plane);
  const double share = counted > 0 ? AreaOf(faces, on_plane) / counted : 1;
  return options.min_extent_m * std::sqrt(share);
}

std::vector<int> FacesAround(const SurfaceFaces& faces,
                             std::span<const int> pool,
                             const Plane& start) {
  std::vector<int> out;
  for (const int f : pool) {
    const SurfaceFace& face = faces.faces[f];
    if (std::abs(face.n_W.dot(start.n)) >= kMinAroundCosine &&
        std::abs(start.SignedDistance(face.centre_W)) <= face.length_scale * kMaxAround_m)
      out.push_back(f);
  }
  return out;
}

std::vector<int> FacesOnPlane(const SurfaceFaces& faces,
                              std::span<const int> pool,
                              const Plane& plane_W,
                              double max_distance_m) {
  const double band_m = std::min(kMinBand_m, max_distance_m);
  const auto is_near = [&](int corner) {
    const FacePoint& point = faces.points[corner];
    const double distance = std::abs(plane_W.SignedDistance(point.p_W));
    if (distance <= point.length_scale * band_m) return true;
    return distance <= point.length_scale * max_distance_m &&
           distance * distance <= 9 * point.VarianceAlong(plane_W.n);
  };
  std::vector<int> out;
  for (const int f : pool) {
    const SurfaceFace& face = faces.faces[f];
    // Most faces are far away, and the middle of a face tells.
    if (std::abs(plane_W.SignedDistance(face.centre_W)) > face.length_scale * max_distance_m)
      continue;
    if (std::abs(face.n_W.dot(plane_W.n)) < kMinFaceCosine) continue;
    if (std::all_of(face.corners.begin(), face.corners.end(), is_near)) out.push_back(f);
  }
  return out;
}

PlaneOrientation OrientationOf(const Vector3d& n_W,
                               const Matrix3d& normal_covariance,
                               double max_lean_deg) {
  const Vector3d up = Vector3d::UnitZ();
  const Vector3d steepest = up - up.dot(n_W) * n_W;  // the normal leans by turning this way
  const double sine = steepest.norm();
  const double tilt = std::atan2(sine, std::abs(n_W.z()));
  double sigma = 0;
  if (sine > 1e-9) {
    const Vector3d direction = steepest / sine;
    sigma = std::sqrt(std::max(direction.dot(normal_covariance * direction), 0.0));
  }
  const double limit = std::max(max_lean_deg * kDegree, 3 * sigma);
  const double to_level = tilt, to_upright = 0.5 * std::numbers::pi - tilt;
  if (to_level <= std::min(limit, to_upright)) return PlaneOrientation::kHorizontal;
  if (to_upright <= limit) return PlaneOrientation::kVertical;
  return PlaneOrientation::kOblique;
}

std::vector<PlaneCandidate> FitCandidates(const SurfaceFaces& faces,
                                          const std::vector<int>& around,
                                          const Plane& start,
                                          double min_area_m2,
                                          const DetectionOptions& options) {
  std::vector<PlaneCandidate> out;
  CandidateSearch(faces, min_area_m2, options).Run(around, start, kMaxSplits, out);
  return out;
}

}  // namespace facet
