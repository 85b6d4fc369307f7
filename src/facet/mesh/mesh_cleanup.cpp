// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/mesh_cleanup.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace facet {
namespace {

/// For each vertex the first one in the same place.
std::vector<int> FirstInPlace(const std::vector<Vector3d>& vertices) {
  std::vector<int> order(vertices.size()), first(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    const Vector3d &a = vertices[i], &b = vertices[j];
    if (a.x() != b.x()) return a.x() < b.x();
    if (a.y() != b.y()) return a.y() < b.y();
    if (a.z() != b.z()) return a.z() < b.z();
    return i < j;
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool is_same = k > 0 && vertices[order[k]] == vertices[order[k - 1]];
    first[order[k]] = is_same ? first[order[k - 1]] : order[k];
  }
  return first;
}

bool HasArea(const TriangleMesh& mesh, const std::array<int, 3>& face) {
  const Vector3d& a = mesh.vertices[face[0]];
  return !(mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a).isZero(0);
}

/// One per face: whether an earlier one has the same corners.
std::vector<char> FindRepeated(const std::vector<std::array<int, 3>>& faces) {
  std::vector<std::array<int, 4>> keys;
  keys.reserve(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::array<int, 3> c = faces[f];
    std::sort(c.begin(), c.end());
    keys.push_back({c[0], c[1], c[2], static_cast<int>(f)});
  }
  std::sort(keys.begin(), keys.end());
  std::vector<char> is_repeated(faces.size(), 0);
  for (std::size_t k = 1; k < keys.size(); ++k) {
    if (std::equal(keys[k].begin(), keys[k].begin() + 3, keys[k - 1].begin()))
      is_repeated[keys[k][3]] = 1;
  }
  return is_repeated;
}

void DropUnusedVertices(TriangleMesh& mesh) {
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (const std::array<int, 3>& face : mesh.faces) {
    for (const int corner : face)
      new_index[corner] = 0;
  }
  int count = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (new_index[i] < 0) continue;
    new_index[i] = count;
    mesh.vertices[count] = mesh.vertices[i];
    mesh.colours[count++] = mesh.colours[i];
  }
  mesh.vertices.resize(static_cast<std::size_t>(count));
  mesh.colours.resize(static_cast<std::size_t>(count));
  for (std::array<int, 3>& face : mesh.faces) {
    for (int& corner : face)
      corner = new_index[corner];
  }
}

}  // namespace

void CleanUp(TriangleMesh& mesh) {
  const std::vector<int> first = FirstInPlace(mesh.vertices);
  for (std::array<int, 3>& face : mesh.faces) {
    for (int& corner : face)
      corner = first[corner];
  }
  const std::vector<char> is_repeated = FindRepeated(mesh.faces);
  std::size_t count = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (is_repeated[f] != 0 || !HasArea(mesh, mesh.faces[f])) continue;
    mesh.faces[count] = mesh.faces[f];
    mesh.plane_ids[count++] = mesh.plane_ids[f];
  }
  mesh.faces.resize(count);
  mesh.plane_ids.resize(count);
  DropUnusedVertices(mesh);
}

}  // namespace facet
