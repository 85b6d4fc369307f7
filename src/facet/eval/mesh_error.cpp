// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/mesh_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "facet/base/check.h"
#include "facet/eval/surface_registration.h"
#include "facet/geometry/so3.h"

namespace facet {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr std::size_t kMaxPictureSamples = 12000;
constexpr std::size_t kMaxRegistrationSamples = 20000;
constexpr std::size_t kMaxPlaneSamples = 100000;
constexpr double kMaxCorrection = 0.3;  // [m]
constexpr double kMaxCorrectionDeg = 5;

double Share(const std::vector<double>& sorted, double limit) {
  const auto end = std::upper_bound(sorted.begin(), sorted.end(), limit);
  return static_cast<double>(end - sorted.begin()) / static_cast<double>(sorted.size());
}

double Percentile(const std::vector<double>& sorted, double share) {
  const double rank = std::ceil(share * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

double HarmonicMean(double a, double b) {
  return a + b > 0 ? 2 * a * b / (a + b) : 0;
}

std::vector<Vector3d> Marked(const std::vector<Vector3d>& points, const std::vector<char>& marks) {
  std::vector<Vector3d> marked;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i] != 0) marked.push_back(points[i]);
  }
  return marked;
}

template <class T>
std::vector<T> EveryKth(const std::vector<T>& all, std::size_t most) {
  std::vector<T> some;
  const std::size_t k = std::max<std::size_t>(1, (all.size() + most - 1) / most);
  for (std::size_t i = 0; i < all.size(); i += k)
    some.push_back(all[i]);
  return some;
}

// One mesh against one truth; everything is done twice, before and after the registration.
class Comparison {
 public:
  Comparison(const MeshUnderTest& test, const TruthSurface& truth, const SeenTruth& seen)
      : test_(test),
        truth_(truth),
        index_(test.mesh_G),
        samples_(SampleMesh(test.mesh_G, kSamplesPerSquareMetre)),
        seen_(Marked(truth.points(), seen.points)),
        seen_near_(Marked(truth.points(), seen.near_points)) {
    if (!test.range_m) return;
    for (const MeshSample& sample : samples_)
      ranges_m_.push_back(test.range_m(sample.p, sample.face));
  }

  MeshError Evaluate() {
    MeshError error;
    error.num_vertices = test_.mesh_G.vertices.size();
    error.num_faces = test_.mesh_G.faces.size();
    error.num_samples = samples_.size();
    error.num_seen = seen_.size();
    error.area_m2 = TotalArea(test_.mesh_G);
    const std::vector<double> distances = Distances(SE3());
    error.aligned = Figures(distances, SE3());
    error.icp = Register();
    if (!test_.planes_G.empty()) {
      error.plane_areas =
          EvaluatePlaneAreas(EveryKth(samples_, kMaxPlaneSamples), truth_, test_.planes_G);
    }
    if (test_.wants_doubled_area) error.doubled_area = DoubledArea(test_.mesh_G, index_);
    error.picture_samples_G = EveryKth(Positions(samples_), kMaxPictureSamples);
    error.picture_distances_m = EveryKth(distances, kMaxPictureSamples);
    return error;
  }

 private:
  // `T_GM` moves the mesh.
  std::vector<double> Distances(const SE3& T_GM) const {
    std::vector<double> distances;
    distances.reserve(samples_.size());
    for (const MeshSample& sample : samples_)
      distances.push_back(truth_.Closest(T_GM * sample.p).distance);
    return distances;
  }

  MeshFigures Figures(const std::vector<double>& distances, const SE3& T_GM) const {
    MeshFigures figures;
    std::vector<double> sorted = distances;
    std::sort(sorted.begin(), sorted.end());
    figures.accuracy = SummarizeDistances(sorted);
    for (std::size_t i = 0; i < kFscoreLimits.size(); ++i)
      figures.precision[i] = Share(sorted, kFscoreLimits[i]);
    figures.by_range = ByRange(distances);
    figures.near = Near(distances, T_GM);
    if (seen_.empty()) return figures;
    figures.completeness = Completeness(seen_, T_GM);
    figures.fscore.emplace();
    // The limits of the F-score are the first ones of the completeness.
    for (std::size_t i = 0; i < kFscoreLimits.size(); ++i)
      (*figures.fscore)[i] = HarmonicMean(figures.precision[i], (*figures.completeness)[i]);
    return figures;
  }

  std::vector<RangeBin> ByRange(const std::vector<double>& distances) const {
    std::vector<RangeBin> bins;
    std::array<std::vector<double>, kRangeBorders.size() - 1> sorted_in;
    for (std::size_t s = 0; s < ranges_m_.size(); ++s) {
      for (std::size_t b = 0; b < sorted_in.size(); ++b) {
        if (ranges_m_[s] >= kRangeBorders[b] && ranges_m_[s] < kRangeBorders[b + 1]) {
          sorted_in[b].push_back(distances[s]);
        }
      }
    }
    for (std::size_t b = 0; b < sorted_in.size(); ++b) {
      if (sorted_in[b].empty()) continue;
      bins.push_back({kRangeBorders[b],
                      kRangeBorders[b + 1],
                      sorted_in[b].size(),
                      SummarizeDistances(std::move(sorted_in[b]))});
    }
    return bins;
  }

  std::optional<NearFigures> Near(const std::vector<double>& distances, const SE3& T_GM) const {
    std::vector<double> near;
    for (std::size_t s = 0; s < ranges_m_.size(); ++s) {
      if (ranges_m_[s] < kNearRange) near.push_back(distances[s]);
    }
    if (near.empty()) return std::nullopt;
    std::sort(near.begin(), near.end());
    NearFigures figures;
    figures.num_samples = near.size();
    figures.median_m = SummarizeDistances(near).median_m;
    figures.precision = Share(near, kNearLimit);
    if (seen_near_.empty()) return figures;
    static_assert(kCompletenessLimits[0] == kNearLimit);
    figures.completeness = Completeness(seen_near_, T_GM)[0];
    figures.fscore = HarmonicMean(figures.precision, *figures.completeness);
    return figures;
  }

  std::array<double, 3> Completeness(const std::vector<Vector3d>& seen_G, const SE3& T_GM) const {
    std::array<std::size_t, 3> count{};
    const SE3 T_MG = T_GM.Inverse();
    for (const Vector3d& p_G : seen_G) {
      const auto found = index_.Closest(T_MG * p_G, kCompletenessLimits.back());
      if (!found) continue;
      for (std::size_t i = 0; i < count.size(); ++i)
        count[i] += found->distance <= kCompletenessLimits[i] ? 1 : 0;
    }
    std::array<double, 3> share{};
    for (std::size_t i = 0; i < count.size(); ++i)
      share[i] = static_cast<double>(count[i]) / static_cast<double>(seen_G.size());
    return share;
  }

  IcpFigures Register() const {
    const std::vector<Vector3d> points = EveryKth(Positions(samples_), kMaxRegistrationSamples);
    const SE3 T_GM = RegisterToSurface(points, truth_);
    Vector3d centre = Vector3d::Zero();
    for (const Vector3d& p : points)
      centre += p / static_cast<double>(points.size());
    IcpFigures icp;
    icp.figures = Figures(Distances(T_GM), T_GM);
    icp.correction_translation_m = (T_GM * centre - centre).norm();
    icp.correction_rotation_deg = LogSO3(T_GM.q).norm() * kDegPerRad;
    icp.is_suspicious = icp.correction_translation_m > kMaxCorrection ||
                        icp.correction_rotation_deg > kMaxCorrectionDeg;
    return icp;
  }

  const MeshUnderTest& test_;
  const TruthSurface& truth_;
  TriangleIndex index_;
  std::vector<MeshSample> samples_;
  std::vector<double> ranges_m_;  // of the samples; empty: unknown
  std::vector<Vector3d> seen_, seen_near_;
};

bool ShareAVertex(const TriangleMesh& mesh, int face, int other) {
  for (int i : mesh.faces[face]) {
    for (int j : mesh.faces[other]) {
      // Horizon meshes that were pooled repeat their vertices, so places count as well as indices.
      if (i == j || mesh.vertices[i] == mesh.vertices[j]) return true;
    }
  }
  return false;
}

}  // namespace

DistanceStatistics SummarizeDistances(std::vector<double> distances_m) {
  FACET_CHECK(!distances_m.empty()) << "statistics of nothing";
  std::sort(distances_m.begin(), distances_m.end());
  const std::size_t n = distances_m.size();
  DistanceStatistics s;
  const double count = static_cast<double>(n);
  s.mean_m = std::accumulate(distances_m.begin(), distances_m.end(), 0.0) / count;
  s.median_m = 0.5 * (distances_m[(n - 1) / 2] + distances_m[n / 2]);
  s.p90_m = Percentile(distances_m, 0.9);
  s.rmse_m = std::sqrt(
      std::inner_product(distances_m.begin(), distances_m.end(), distances_m.begin(), 0.0) / count);
  return s;
}

MeshError EvaluateMesh(const MeshUnderTest& test,
                       const TruthSurface& truth,
                       const SeenTruth& seen) {
  FACET_CHECK(TotalArea(test.mesh_G) > 0) << "a mesh without area";
  const auto fits = [&truth](const std::vector<char>& marks) {
    return marks.empty() || marks.size() == truth.points().size();
  };
  FACET_CHECK(fits(seen.points)) << seen.points.size();
  FACET_CHECK(fits(seen.near_points)) << seen.near_points.size();
  return Comparison(test, truth, seen).Evaluate();
}

double DoubledArea(const TriangleMesh& mesh, const TriangleIndex& index) {
  constexpr double kNear = 0.01, kFar = 0.10;  // [m]
  const double min_cosine = std::cos(20 / kDegPerRad);
  const std::vector<MeshSample> samples = SampleMesh(mesh, kSamplesPerSquareMetre);
  if (samples.empty()) return 0;
  std::size_t num_doubled = 0;
  for (const MeshSample& sample : samples) {
    const Vector3d n = FaceNormal(mesh, sample.face);
    bool is_doubled = false;
    index.VisitLine(sample.p, n, -kFar, kFar, [&](int other, double t) {
      is_doubled = std::abs(t) >= kNear && !ShareAVertex(mesh, sample.face, other) &&
                   std::abs(FaceNormal(mesh, other).dot(n)) > min_cosine;
      return !is_doubled;
    });
    num_doubled += is_doubled ? 1 : 0;
  }
  return static_cast<double>(num_doubled) / static_cast<double>(samples.size());
}

}  // namespace facet
