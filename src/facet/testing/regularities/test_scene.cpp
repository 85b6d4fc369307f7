// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/regularities/test_scene.h"

#include <algorithm>
#include <cmath>

#include "facet/geometry/so3.h"

namespace facet::testing {

namespace {

constexpr int kIdsPerPatch = 10000;
constexpr double kFocal_px = 467;
constexpr double kSigmaDirection = 1.5e-3;  // what is assumed with that focal length

Vector3d WithNoise(const Vector3d& p_W, const TestView& view, Rng& rng) {
  const Vector3d ray = (p_W - view.camera_W).normalized();
  const double across = view.pixel_noise * kSigmaDirection * (p_W - view.camera_W).norm();
  const Vector3d noise = across * rng.Normal3();
  return p_W + noise - noise.dot(ray) * ray + view.sigma_depth_m * rng.Normal() * ray;
}

void AddFace(std::array<int, 3> face, const Vector3d& camera_W, SearchMesh& mesh) {
  const Vector3d& a = mesh.vertices[face[0]];
  const Vector3d n = (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
  if (n.dot(camera_W - a) < 0) std::swap(face[1], face[2]);
  mesh.faces.push_back(face);
}

// A grid whose inner vertices are moved a little, so that no row of them lines up.
void AddPatch(const Patch& patch, const TestView& view, Rng& rng, SearchMesh& out) {
  const int rows = std::max(1, static_cast<int>(2 * patch.half_a_W.norm() / patch.step_m));
  const int columns = std::max(1, static_cast<int>(2 * patch.half_b_W.norm() / patch.step_m));
  const int first = static_cast<int>(out.vertices.size());
  Rng jitter(7);  // the same corners in every view
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      const bool is_inner = i > 0 && i < rows && j > 0 && j < columns;
      const double da = jitter.Uniform(-0.25, 0.25), db = jitter.Uniform(-0.25, 0.25);
      const double a = 2 * (i + (is_inner ? da : 0)) / rows - 1;
      const double b = 2 * (j + (is_inner ? db : 0)) / columns - 1;
      const Vector3d p = patch.centre_W + a * patch.half_a_W + b * patch.half_b_W;
      out.vertices.push_back(WithNoise(p, view, rng));
    }
  }
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const int k = first + i * (columns + 1) + j, above = k + columns + 1;
      AddFace({k, k + 1, above}, view.camera_W, out);
      AddFace({k + 1, above + 1, above}, view.camera_W, out);
    }
  }
}

}  // namespace

Patch MakeWall(const Vector3d& centre_W, double azimuth, double width_m, double height_m) {
  const Vector3d along(-std::sin(azimuth), std::cos(azimuth), 0);
  return {centre_W, 0.5 * width_m * along, 0.5 * height_m * Vector3d::UnitZ()};
}

Patch MakeFloor(const Vector3d& centre_W, double size_x_m, double size_y_m) {
  return {centre_W, 0.5 * size_x_m * Vector3d::UnitX(), 0.5 * size_y_m * Vector3d::UnitY()};
}

Patch Turned(Patch patch, const Vector3d& axis_W, double angle) {
  const Eigen::AngleAxisd turn(angle, axis_W.normalized());
  patch.half_a_W = turn * patch.half_a_W;
  patch.half_b_W = turn * patch.half_b_W;
  return patch;
}

SearchMesh MakeMesh(const std::vector<Patch>& patches, const TestView& view) {
  SearchMesh out;
  out.t = Timestamp{0} + FromSeconds(view.time_s);
  out.T_WC.p = view.camera_W;
  out.focal_px = kFocal_px;
  out.baseline_m = view.baseline_m;
  Rng rng(view.seed);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const std::size_t first = out.vertices.size();
    AddPatch(patches[k], view, rng, out);
    const int own_id = patches[k].first_id;
    const int first_id = own_id >= 0 ? own_id : kIdsPerPatch * static_cast<int>(k);
    for (std::size_t i = first; i < out.vertices.size(); ++i)
      out.vertex_ids.push_back(LandmarkId{first_id + static_cast<int>(i - first)});
  }
  out.sigma_depth_m.assign(out.vertices.size(), view.sigma_depth_m);
  out.may_vote.assign(out.faces.size(), 1);
  out.in_view.assign(out.faces.size(), 1);
  return out;
}

SurfaceFaces MakeFaces(const std::vector<Patch>& patches, const TestView& view) {
  SurfaceFaces faces;
  FillSurfaceFaces(MakeMesh(patches, view), faces);
  return faces;
}

LandmarkCount CountOf(int num, int first_id) {
  const PlaneId plane{0};
  std::vector<LandmarkEstimate> landmarks(static_cast<std::size_t>(num));
  for (LandmarkEstimate& landmark : landmarks) {
    landmark.id = LandmarkId{first_id++};
    landmark.planes[0] = plane;
  }
  LandmarkCount count;
  count.Update(landmarks, plane);
  return count;
}

std::vector<int> AllOf(const SurfaceFaces& faces) {
  std::vector<int> out(faces.faces.size());
  for (std::size_t f = 0; f < out.size(); ++f)
    out[f] = static_cast<int>(f);
  return out;
}

void BelievingEstimator::Apply(const PlaneAssignments& assignments) {
  for (const NewPlane& plane : assignments.created) {
    planes[plane.id] = plane.plane_W;
    anchors_[plane.id] = plane.centroid_W;
  }
  for (const PlaneAttachment& join : assignments.attached) {
    auto& list = memberships[join.landmark];
    if (list.size() < 3 && std::find(list.begin(), list.end(), join.plane) == list.end())
      list.push_back(join.plane);
  }
  for (const auto& [landmark, plane] : assignments.detached)
    std::erase(memberships[landmark], plane);
  for (const PlaneId plane : assignments.retired) {
    planes.erase(plane);
    for (auto& [landmark, list] : memberships)
      std::erase(list, plane);
  }
}

MapSnapshot BelievingEstimator::Snapshot(const SearchMesh& mesh) const {
  MapSnapshot out;
  out.latest.t = mesh.t;
  out.latest.T_WB = mesh.T_WC;
  for (std::size_t i = 0; i < mesh.vertex_ids.size(); ++i) {
    LandmarkEstimate landmark;
    landmark.id = mesh.vertex_ids[i];
    landmark.p_W = mesh.vertices[i];
    landmark.num_observations = 10;
    landmark.sigma_depth_m = mesh.sigma_depth_m[i];
    const auto list = memberships.find(landmark.id);
    if (list != memberships.end())
      std::copy(list->second.begin(), list->second.end(), landmark.planes.begin());
    out.landmarks.push_back(landmark);
  }
  for (const auto& [id, plane] : planes) {
    PlaneEstimate estimate;
    estimate.id = id;
    estimate.plane_W = plane;
    estimate.anchor_W = anchors_.at(id);
    estimate.is_persistent = planes_are_settled;
    const Matrix<3, 2> B = TangentBasis(plane.n);
    estimate.covariance.diagonal().head<3>().setConstant(1e-6);
    estimate.covariance.diagonal().segment<3>(3).setConstant(sigma_p_m * sigma_p_m);
    estimate.covariance.block<3, 3>(6, 6) = sigma_normal * sigma_normal * B * B.transpose();
    estimate.covariance(9, 9) = sigma_offset_m * sigma_offset_m;
    out.planes.push_back(estimate);
  }
  return out;
}

}  // namespace facet::testing
