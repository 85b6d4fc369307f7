// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/planes_file.h"

#include <cmath>
#include <fstream>
#include <initializer_list>
#include <sstream>
#include <string_view>
#include <tuple>

#include "facet/io/csv_reader.h"
#include "facet/io/errors.h"

namespace facet {
namespace {

constexpr double kMaxNormError = 0.01;
// Runs have some hundreds. All estimated planes are compared with all true ones.
constexpr std::size_t kMaxPlanes = 20'000;

void RequireFewer(const CsvReader& row, std::size_t num_planes) {
  if (num_planes < kMaxPlanes) return;
  throw InputError(row.Where() + ": more than " + std::to_string(kMaxPlanes) +
                   " planes, which no run or scene has; is this another file, or repeated?");
}

double Number(const CsvReader& row, std::size_t column, const char* name) {
  if (column >= row.fields().size()) {
    throw InputError(row.Where() + ": " + std::to_string(row.fields().size()) +
                     " columns; column " + std::to_string(column + 1) + " (" + name +
                     ") is missing");
  }
  const auto value = ParseDouble(row.fields()[column]);
  if (!value || !std::isfinite(*value)) {
    throw InputError(row.Where() + ": column " + std::to_string(column + 1) + " (" + name +
                     ") is '" + std::string(row.fields()[column]) +
                     "', a finite number is expected");
  }
  return *value;
}

std::int64_t IdOf(const CsvReader& row) {
  const std::string_view text = row.fields().empty() ? std::string_view() : row.fields()[0];
  if (const auto id = ParseInteger(text)) return *id;
  throw InputError(row.Where() + ": column 1 (id) is '" + std::string(text) +
                   "', an integer is expected");
}

std::string Text(const CsvReader& row, std::size_t column) {
  return column < row.fields().size() ? std::string(row.fields()[column]) : "";
}

// Columns 2 to 5 of both files: a unit normal and the distance.
std::pair<Vector3d, double> NormalAndDistance(const CsvReader& row) {
  const Vector3d n(Number(row, 1, "nx"), Number(row, 2, "ny"), Number(row, 3, "nz"));
  const double norm = n.norm();
  if (std::abs(norm - 1) > kMaxNormError) {
    throw InputError(row.Where() + ": the normal has norm " + std::to_string(norm) +
                     " instead of 1; columns 2 to 5 must be nx, ny, nz, d");
  }
  return {n / norm, Number(row, 4, "d") / norm};
}

// "x y z;x y z;...": empty if anything else.
std::vector<Vector3d> OutlineOf(const std::string& text) {
  std::vector<Vector3d> outline;
  std::istringstream corners(text);
  std::string corner;
  while (std::getline(corners, corner, ';')) {
    std::istringstream numbers(corner);
    Vector3d p;
    if (!(numbers >> p.x() >> p.y() >> p.z()) || !p.allFinite()) return {};
    outline.push_back(p);
  }
  return outline;
}

// Whether the first line names the columns of a list of true planes.
bool HasHeader(const std::filesystem::path& file, std::initializer_list<const char*> names) {
  std::ifstream stream(file);
  std::string header;
  std::getline(stream, header);
  std::size_t at = 0;
  for (const char* name : names) {
    at = header.find(name, at);
    if (at == std::string::npos) return false;
  }
  return true;
}

}  // namespace

std::vector<EstimatedPlane> ReadEstimatedPlanes(const std::filesystem::path& file) {
  std::vector<EstimatedPlane> planes;
  CsvReader row(file);
  while (row.Next()) {
    RequireFewer(row, planes.size());
    EstimatedPlane plane;
    plane.id = IdOf(row);
    std::tie(plane.n_W, plane.d_W) = NormalAndDistance(row);
    plane.centre_W = {Number(row, 5, "cx"), Number(row, 6, "cy"), Number(row, 7, "cz")};
    plane.orientation = Text(row, 8);
    plane.label = Text(row, 9);
    plane.area_m2 = Number(row, 13, "area_m2");
    plane.num_landmarks = static_cast<int>(ParseInteger(Text(row, 12)).value_or(0));
    plane.sigma_normal_rad = ParseDouble(Text(row, 14)).value_or(0);
    plane.sigma_d_m = ParseDouble(Text(row, 15)).value_or(0);
    plane.outline_W = OutlineOf(Text(row, 16));
    planes.push_back(std::move(plane));
  }
  if (planes.empty() && !HasHeader(file, {",nx", ",ny", ",nz", ",d"})) {
    throw InputError(file.string() +
                     ":1: neither a plane nor a header; columns 'id,nx,ny,nz,d,cx,cy,cz,...' are "
                     "expected, or no such file at all");
  }
  return planes;
}

std::vector<TruePlane> ReadTruePlanes(const std::filesystem::path& file) {
  std::vector<TruePlane> planes;
  CsvReader row(file);
  while (row.Next()) {
    RequireFewer(row, planes.size());
    TruePlane plane;
    std::tie(plane.n_G, plane.d_G) = NormalAndDistance(row);
    plane.area_m2 = Number(row, 5, "area");
    plane.seen_area_m2 = Number(row, 6, "seen area");
    plane.label = Text(row, 7);
    planes.push_back(std::move(plane));
  }
  // Without a row only the header tells a scene without planes from a file cut short.
  if (planes.empty() && !HasHeader(file, {",nx", ",ny", ",nz", ",d", ",area", ",seen area"})) {
    throw InputError(
        file.string() +
        ":1: the truth holds no plane and no header that says so; columns "
        "'plane,nx,ny,nz,d,area,seen area,label' are expected, or no such file at all");
  }
  return planes;
}

}  // namespace facet
