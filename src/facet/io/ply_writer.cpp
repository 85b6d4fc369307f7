// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/ply_writer.h"

#include <array>
#include <bit>
#include <fstream>

#include "facet/base/check.h"
#include "facet/io/errors.h"

namespace facet {

void WritePlyPoints(const std::filesystem::path& file, std::span<const Vector3d> points) {
  static_assert(std::endian::native == std::endian::little,
                "floats are written as they lie in memory");
  std::ofstream stream(file, std::ios::binary);
  stream << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Vector3d& p : points) {
    const std::array<float, 3> xyz = {
        static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    stream.write(reinterpret_cast<const char*>(xyz.data()), sizeof(xyz));
  }
  stream.flush();
  if (!stream) throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
}

namespace {

template <class T>
void Put(std::ostream& stream, T value) {
  stream.write(reinterpret_cast<const char*>(&value), sizeof(value));
}

void PutVector(std::ostream& stream, const Vector3d& v) {
  for (int i = 0; i < 3; ++i)
    Put(stream, static_cast<float>(v[i]));
}

}  // namespace

void WritePlyMesh(const std::filesystem::path& file, const TriangleMesh& mesh) {
  const std::size_t n = mesh.vertices.size();
  FACET_CHECK(mesh.normals.empty() || mesh.normals.size() == n) << mesh.normals.size();
  FACET_CHECK(mesh.colours.empty() || mesh.colours.size() == n) << mesh.colours.size();
  FACET_CHECK(mesh.sigma_m.empty() || mesh.sigma_m.size() == n) << mesh.sigma_m.size();
  FACET_CHECK(mesh.plane_ids.empty() || mesh.plane_ids.size() == mesh.faces.size())
      << mesh.plane_ids.size();
  std::ofstream stream(file, std::ios::binary);
  stream << "ply\nformat binary_little_endian 1.0\nelement vertex " << n
         << "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx"
            "\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green"
            "\nproperty uchar blue"
         << (mesh.sigma_m.empty() ? "" : "\nproperty float sigma_m") << "\nelement face "
         << mesh.faces.size()
         << "\nproperty list uchar int vertex_indices\nproperty int plane_id\nend_header\n";
  constexpr std::array<std::uint8_t, 3> kGrey = {160, 160, 160};
  for (std::size_t i = 0; i < n; ++i) {
    PutVector(stream, mesh.vertices[i]);
    PutVector(stream, mesh.normals.empty() ? Vector3d(0, 0, 1) : mesh.normals[i]);
    Put(stream, mesh.colours.empty() ? kGrey : mesh.colours[i]);
    if (!mesh.sigma_m.empty()) Put(stream, mesh.sigma_m[i]);
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    Put(stream, std::uint8_t{3});
    for (int index : mesh.faces[f])
      Put(stream, std::int32_t{index});
    Put(stream, std::int32_t{mesh.plane_ids.empty() ? -1 : mesh.plane_ids[f]});
  }
  stream.flush();
  if (!stream) throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
}

}  // namespace facet
