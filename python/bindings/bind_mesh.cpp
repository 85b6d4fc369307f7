// SPDX-License-Identifier: BSD-2-Clause
#include <filesystem>

#include "arrays.h"
#include "bindings.h"
#include <pybind11/stl/filesystem.h>

#include "facet/facet.h"
#include "facet/io/ply_reader.h"
#include "facet/io/ply_writer.h"

namespace facet::python {
namespace {

using api::Mesh;

std::unique_ptr<Mesh> ReadMesh(const std::filesystem::path& file) {
  const TriangleMesh read = ReadPly(file);
  auto mesh = std::make_unique<Mesh>();
  mesh->vertices.reserve(read.vertices.size());
  for (const Vector3d& p : read.vertices)
    mesh->vertices.push_back({{p.x(), p.y(), p.z()}});
  mesh->faces = read.faces;
  mesh->plane_ids.assign(read.plane_ids.begin(), read.plane_ids.end());
  mesh->plane_ids.resize(read.faces.size(), -1);
  return mesh;
}

void WriteMesh(const Mesh& mesh, const std::filesystem::path& file) {
  TriangleMesh written;
  for (const api::Vec3& p : mesh.vertices)
    written.vertices.emplace_back(p[0], p[1], p[2]);
  written.faces = mesh.faces;
  for (const std::int64_t id : mesh.plane_ids)
    written.plane_ids.push_back(static_cast<int>(id));
  WritePlyMesh(file, written);
}

}  // namespace

void BindMesh(py::module_& module) {
  using Release = py::call_guard<py::gil_scoped_release>;
  py::class_<Mesh>(module,
                   "Mesh",
                   "Triangles in W, counter-clockwise seen from where the surface was seen. The "
                   "arrays are views of its buffers, which live as long as any of them.")
      .def_property_readonly(
          "vertices",
          [](const py::object& self) { return RowsView(self.cast<Mesh&>().vertices, self); },
          "N x 3 float64 [m].")
      .def_property_readonly(
          "faces",
          [](const py::object& self) { return RowsView(self.cast<Mesh&>().faces, self); },
          "M x 3 int32, indices of vertices.")
      .def_property_readonly(
          "plane_ids",
          [](const py::object& self) { return View(self.cast<Mesh&>().plane_ids, self); },
          "M int64, -1: on no plane.")
      .def("write",
           &WriteMesh,
           py::arg("file"),
           Release(),
           "As binary PLY with plane_id per face, without normals and colours.")
      .def("__len__", [](const Mesh& mesh) { return mesh.faces.size(); })
      .def("__repr__", [](const Mesh& mesh) {
        return "<facet.Mesh " + std::to_string(mesh.vertices.size()) + " vertices, " +
               std::to_string(mesh.faces.size()) + " faces>";
      });
  module.def("read_mesh",
             &ReadMesh,
             py::arg("file"),
             Release(),
             "A PLY file: mesh.ply or map.ply of a result, or one of another program.");
}

}  // namespace facet::python
