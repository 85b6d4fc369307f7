// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/ply_writer.h"

#include <array>
#include <bit>
#include <fstream>

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

}  // namespace facet
