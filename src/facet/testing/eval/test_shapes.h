// SPDX-License-Identifier: BSD-2-Clause
// For tests: simple surfaces and a camera to look at them.
#pragma once

#include "facet/camera/stereo_rig.h"
#include "facet/eval/mesh_sampling.h"

namespace facet {

// A grid of cells x cells squares in the plane z = height over [0, side]^2, shifted in x.
inline TriangleMesh Square(double side, double height, int cells, double x0 = 0) {
  TriangleMesh mesh;
  for (int r = 0; r <= cells; ++r) {
    for (int c = 0; c <= cells; ++c)
      mesh.vertices.emplace_back(x0 + side * c / cells, side * r / cells, height);
  }
  for (int r = 0; r < cells; ++r) {
    for (int c = 0; c < cells; ++c) {
      const int i = r * (cells + 1) + c;
      mesh.faces.push_back({i, i + 1, i + cells + 1});
      mesh.faces.push_back({i + 1, i + cells + 2, i + cells + 1});
    }
  }
  return mesh;
}

inline TriangleMesh CloudOf(const TriangleMesh& mesh, double points_per_m2) {
  TriangleMesh cloud;
  cloud.vertices = Positions(SampleMesh(mesh, points_per_m2, 5'000'000, 99));
  return cloud;
}

inline StereoRig RigLookingAlongX() {
  CameraIntrinsics k;
  k.width = 752;
  k.height = 480;
  k.fx = k.fy = 458;
  k.cx = 376;
  k.cy = 240;
  StereoRig rig;
  rig.cameras = {CameraModel(k), CameraModel(k)};
  const Matrix3d R_BC = (Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
  rig.T_BC = {SE3(Quaterniond(R_BC), {0, 0, 0}), SE3(Quaterniond(R_BC), {0, -0.1, 0})};
  return rig;
}

}  // namespace facet
