// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/vertex_sigmas.h"

#include <cstdio>
#include <string>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"
#include "facet/io/text_file.h"

namespace facet {
namespace {

// Who reads a folder of meshes expects nothing else there.
std::filesystem::path FileOf(std::filesystem::path mesh_file) {
  const std::filesystem::path folder = mesh_file.parent_path();
  if (folder.filename() == "meshes")
    mesh_file = folder.parent_path() / kSigmaFolder / mesh_file.filename();
  return mesh_file.replace_extension(".sigma");
}

}  // namespace

void WriteVertexSigmas(const std::filesystem::path& mesh_file, std::span<const float> sigma_m) {
  if (sigma_m.empty()) return;
  std::string text = "sigma_m\n";
  for (const float sigma : sigma_m) {
    char line[32];
    std::snprintf(line, sizeof line, "%.9g\n", static_cast<double>(sigma));
    text += line;
  }
  const std::filesystem::path file = FileOf(mesh_file);
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (error)
    throw OutputError(file.parent_path().string() + ": cannot be made: " + error.message());
  WriteTextFile(file, text);
}

void ReadVertexSigmas(const std::filesystem::path& mesh_file, TriangleMesh& mesh) {
  mesh.sigma_m.clear();
  const std::filesystem::path file = FileOf(mesh_file);
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return;
  CsvReader rows(file);
  while (rows.Next()) {
    const auto sigma_m = ParseDouble(rows.fields().front());
    if (!sigma_m || !(*sigma_m >= 0)) throw InputError(rows.Where() + ": no 1-sigma");
    mesh.sigma_m.push_back(static_cast<float>(*sigma_m));
  }
  if (mesh.sigma_m.size() != mesh.vertices.size())
    throw InputError(file.string() + ": it has " + std::to_string(mesh.sigma_m.size()) +
                     " values for " + std::to_string(mesh.vertices.size()) + " vertices");
}

}  // namespace facet
