// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/truth_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <nanoflann.hpp>

#include "facet/base/check.h"
#include "facet/eval/mesh_sampling.h"

namespace facet {
namespace {

constexpr int kNumNeighbours = 12;     // that a disc's plane is fitted to
constexpr int kRadiusNeighbour = 6;    // whose distance is the disc's radius
constexpr int kNumCandidates = 6;      // nearest points whose discs are tried
constexpr double kMaxFlatness = 0.05;  // smallest over middle eigenvalue of a plane

class MeshSurface : public TruthSurface {
 public:
  explicit MeshSurface(const TriangleMesh& mesh)
      : index_(mesh), points_(Positions(SampleMesh(mesh, kSamplesPerSquareMetre))) {
    if (points_.empty()) points_ = mesh.vertices;
  }

  SurfacePoint Closest(const Vector3d& p_G) const override {
    const auto found = index_.Closest(p_G, std::numeric_limits<double>::max());
    return found ? *found : SurfacePoint{};
  }
  const std::vector<Vector3d>& points() const override { return points_; }
  const TriangleIndex* triangles() const override { return &index_; }

 private:
  TriangleIndex index_;
  std::vector<Vector3d> points_;
};

// The interface that nanoflann requires of a container.
struct PointContainer {
  std::vector<Vector3d> points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

class CloudSurface : public TruthSurface {
 public:
  explicit CloudSurface(std::vector<Vector3d> points)
      : container_{std::move(points)}, tree_(3, container_), discs_(container_.points.size()) {
    tree_.buildIndex();
  }

  SurfacePoint Closest(const Vector3d& p_G) const override {
    std::array<std::uint32_t, kNumCandidates> indices{};
    std::array<double, kNumCandidates> squared{};
    const auto found = tree_.knnSearch(p_G.data(), kNumCandidates, indices.data(), squared.data());
    SurfacePoint best;
    best.distance = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < found; ++i) {
      const SurfacePoint candidate = OnDisc(indices[i], p_G);
      if (candidate.distance < best.distance) best = candidate;
    }
    return best;
  }
  const std::vector<Vector3d>& points() const override { return container_.points; }

 private:
  struct Disc {
    Vector3d n = Vector3d::Zero();  // zero: no plane here
    double radius = -1;             // negative: not computed yet
  };
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointContainer>,
                                          PointContainer,
                                          3,
                                          std::uint32_t>;

  SurfacePoint OnDisc(std::uint32_t index, const Vector3d& p_G) const {
    const Vector3d& centre = container_.points[index];
    const Disc& disc = GetDisc(index);
    SurfacePoint result;
    result.n = disc.n;
    result.p = centre;
    if (!disc.n.isZero()) {
      const Vector3d r = p_G - centre;
      const Vector3d lateral = r - disc.n.dot(r) * disc.n;
      const double length = lateral.norm();
      result.p += length > disc.radius ? Vector3d(disc.radius / length * lateral) : lateral;
    }
    result.distance = (p_G - result.p).norm();
    return result;
  }

  const Disc& GetDisc(std::uint32_t index) const {
    Disc& disc = discs_[index];
    if (disc.radius < 0) disc = FitDisc(container_.points[index]);
    return disc;
  }

  Disc FitDisc(const Vector3d& centre) const {
    std::array<std::uint32_t, kNumNeighbours> indices{};
    std::array<double, kNumNeighbours> squared{};
    const std::size_t found =
        tree_.knnSearch(centre.data(), kNumNeighbours, indices.data(), squared.data());
    Disc disc;
    disc.radius = 0;
    if (found < kRadiusNeighbour + 1) return disc;
    Vector3d mean = Vector3d::Zero();
    for (std::size_t i = 0; i < found; ++i)
      mean += container_.points[indices[i]] / static_cast<double>(found);
    Matrix3d scatter = Matrix3d::Zero();
    for (std::size_t i = 0; i < found; ++i) {
      const Vector3d r = container_.points[indices[i]] - mean;
      scatter += r * r.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter);
    const Vector3d& values = eigen.eigenvalues();  // ascending
    if (!(values[0] <= kMaxFlatness * values[1]) || values[1] < 1e-3 * values[2]) return disc;
    disc.n = eigen.eigenvectors().col(0);
    disc.radius = std::sqrt(squared[kRadiusNeighbour]);
    return disc;
  }

  PointContainer container_;
  Tree tree_;
  mutable std::vector<Disc> discs_;  // fitted on first use: most points of a scan are never asked
};

}  // namespace

std::unique_ptr<TruthSurface> MakeTruthSurface(TriangleMesh truth) {
  FACET_CHECK(!truth.vertices.empty()) << "a truth without points";
  if (!truth.faces.empty()) return std::make_unique<MeshSurface>(truth);
  return std::make_unique<CloudSurface>(std::move(truth.vertices));
}

}  // namespace facet
