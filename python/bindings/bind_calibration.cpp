// SPDX-License-Identifier: BSD-2-Clause
#include <filesystem>

#include "arrays.h"
#include "bindings.h"
#include "poses.h"
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "facet/facet.h"

namespace facet::python {
namespace {

using api::Calibration;
using api::Camera;

constexpr std::array<const char*, 8> kDistortionNames = {"none",
                                                         "radtan",
                                                         "equidistant",
                                                         "rational",
                                                         "fov",
                                                         "double_sphere",
                                                         "extended_unified",
                                                         "unified"};

Camera::Distortion DistortionFromText(const std::string& text) {
  std::string known;
  for (std::size_t i = 0; i < kDistortionNames.size(); ++i) {
    if (text == kDistortionNames[i]) return static_cast<Camera::Distortion>(i);
    known += std::string(i == 0 ? "" : ", ") + kDistortionNames[i];
  }
  throw py::value_error("distortion: '" + text + "' is unknown; known: " + known);
}

void SetCoefficients(Camera& camera, const std::vector<double>& coefficients) {
  if (coefficients.size() > camera.coefficients.size())
    throw py::value_error("coefficients: a lens has up to 8 of them");
  camera.coefficients.fill(0);
  std::copy(coefficients.begin(), coefficients.end(), camera.coefficients.begin());
}

Camera MakeCamera(int width,
                  int height,
                  double fx,
                  double fy,
                  double cx,
                  double cy,
                  const py::object& T_BC,
                  const std::string& distortion,
                  const std::vector<double>& coefficients) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = cx;
  camera.cy = cy;
  camera.distortion = DistortionFromText(distortion);
  SetCoefficients(camera, coefficients);
  camera.T_BC = PoseFromMatrix(T_BC, "T_BC");
  return camera;
}

void BindCamera(py::module_& module) {
  py::class_<Camera>(module, "Camera", "A camera with a lens; lengths in pixels.")
      .def(py::init(&MakeCamera),
           py::arg("width"),
           py::arg("height"),
           py::arg("fx"),
           py::arg("fy"),
           py::arg("cx"),
           py::arg("cy"),
           py::arg("T_BC"),
           py::arg("distortion") = "none",
           py::arg("coefficients") = std::vector<double>(),
           "`T_BC`: 4 x 4, camera to body (the IMU). `distortion`: none, radtan, equidistant, "
           "rational, fov, double_sphere, extended_unified or unified, with the coefficients in "
           "the order of facet/facet.h.")
      .def_readwrite("width", &Camera::width)
      .def_readwrite("height", &Camera::height)
      .def_readwrite("fx", &Camera::fx)
      .def_readwrite("fy", &Camera::fy)
      .def_readwrite("cx", &Camera::cx)
      .def_readwrite("cy", &Camera::cy)
      .def_property(
          "T_BC",
          [](const Camera& camera) { return PoseMatrix(camera.T_BC); },
          [](Camera& camera, const py::object& T_BC) {
            camera.T_BC = PoseFromMatrix(T_BC, "T_BC");
          },
          "Camera to body, 4 x 4.")
      .def_property(
          "distortion",
          [](const Camera& camera) {
            return kDistortionNames.at(static_cast<std::size_t>(camera.distortion));
          },
          [](Camera& camera, const std::string& name) {
            camera.distortion = DistortionFromText(name);
          })
      .def_property(
          "coefficients",
          [](const Camera& camera) { return ToArray(camera.coefficients); },
          &SetCoefficients,
          "Eight numbers, zero behind those that the model has.")
      .def_property(
          "lens_modes",
          [](const Camera& camera) { return ToArray(camera.lens_modes); },
          [](Camera& camera, const py::object& modes) {
            camera.lens_modes = ToNumbers<10>(modes, "lens_modes");
          },
          "What the lens does beside its model, as a former run estimated it [px].")
      .def("__repr__", [](const Camera& camera) {
        return "<facet.Camera " + std::to_string(camera.width) + " x " +
               std::to_string(camera.height) + ", " +
               kDistortionNames.at(static_cast<std::size_t>(camera.distortion)) + ">";
      });
}

}  // namespace

void BindCalibration(py::module_& module) {
  BindCamera(module);
  py::class_<Calibration>(
      module,
      "Calibration",
      "Two cameras on an IMU; t_imu = t_camera + time_offset_s. Noise densities "
      "as on a datasheet: rad/s/sqrt(Hz), rad/s^2/sqrt(Hz), m/s^2/sqrt(Hz), "
      "m/s^3/sqrt(Hz).")
      .def(py::init([](const Camera& left, const Camera& right) {
             Calibration calibration;
             calibration.left = left;
             calibration.right = right;
             return calibration;
           }),
           py::arg("left"),
           py::arg("right"))
      .def_readwrite("left", &Calibration::left)
      .def_readwrite("right", &Calibration::right)
      .def_readwrite("time_offset_s", &Calibration::time_offset_s)
      .def_readwrite("gyro_noise", &Calibration::gyro_noise)
      .def_readwrite("gyro_walk", &Calibration::gyro_walk)
      .def_readwrite("accel_noise", &Calibration::accel_noise)
      .def_readwrite("accel_walk", &Calibration::accel_walk)
      .def_property(
          "gyro_scale",
          [](const Calibration& calibration) { return ToArray(calibration.gyro_scale); },
          [](Calibration& calibration, const py::object& scale) {
            calibration.gyro_scale = ToNumbers<3>(scale, "gyro_scale");
          },
          "By what share the gyroscope reads too much on each axis.")
      .def_property_readonly(
          "has_covariance",
          [](const Calibration& calibration) { return !calibration.covariance.empty(); },
          "Whether a former run said how well it is known.");
  module.def(
      "read_calibration",
      [](const std::filesystem::path& cameras, const std::filesystem::path& imu) {
        return api::ReadCalibration(cameras.string(), imu.string());
      },
      py::arg("cameras"),
      py::arg("imu") = "",
      "From Kalibr's camchain.yaml, calibration.yaml of a result, or a folder that holds mav0/ "
      "(EuRoC); `imu`: Kalibr's imu.yaml or EuRoC's sensor.yaml. Raises facet.Error with file and "
      "line.");
}

}  // namespace facet::python
