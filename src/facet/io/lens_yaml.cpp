// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/lens_yaml.h"

#include <algorithm>

#include "facet/io/errors.h"

namespace facet {
namespace {

// Of one kind of projection in Kalibr's files: how many of its parameters come before fu.
struct Projection {
  const char* name;
  DistortionModel model;
  std::size_t num_before;
  const char* intrinsics;
};

constexpr Projection kProjections[] = {
    {"pinhole", DistortionModel::kNone, 0, "[fu, fv, cu, cv]"},
    {"omni", DistortionModel::kUnified, 1, "[xi, fu, fv, cu, cv]"},
    {"ds", DistortionModel::kDoubleSphere, 2, "[xi, alpha, fu, fv, cu, cv]"},
    {"eucm", DistortionModel::kExtendedUnified, 2, "[alpha, beta, fu, fv, cu, cv]"},
};

const char* CoefficientsKey(const YAML::Node& camera) {
  return YamlFile::Has(camera, "distortion_coeffs") ? "distortion_coeffs"
                                                    : "distortion_coefficients";
}

bool IsAnyOf(const std::string& name, std::initializer_list<const char*> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// kNone where there is no distortion.
DistortionModel ParseDistortion(const YamlFile& yaml, const YAML::Node& camera) {
  if (!YamlFile::Has(camera, "distortion_model")) {
    const char* key = CoefficientsKey(camera);
    if (YamlFile::Has(camera, key)) {
      for (const double coefficient : yaml.Numbers(camera[key])) {
        if (coefficient != 0)
          yaml.Fail(camera[key],
                    "there are distortion coefficients but no 'distortion_model' "
                    "(radial-tangential, equidistant, fov, none)");
      }
    }
    return DistortionModel::kNone;
  }
  const std::string name = yaml.RequireText(camera, "distortion_model");
  if (IsAnyOf(name, {"radial-tangential", "radtan", "plumb_bob", "rational_polynomial"}))
    return DistortionModel::kRadialTangential;
  if (IsAnyOf(name, {"equidistant", "kannala_brandt", "equi"}))
    return DistortionModel::kEquidistant;
  if (name == "fov") return DistortionModel::kFieldOfView;
  if (name == "none") return DistortionModel::kNone;
  yaml.Fail(camera["distortion_model"],
            "distortion model '" + name +
                "' is not supported (radial-tangential, equidistant, fov, none)");
}

void ReadCoefficients(const YamlFile& yaml, const YAML::Node& camera, CameraIntrinsics& k) {
  const YAML::Node node = yaml.Require(camera, CoefficientsKey(camera));
  const std::vector<double> values = yaml.Numbers(node);
  if (k.distortion == DistortionModel::kRadialTangential) {
    if (!SetOpenCvCoefficients(values, k)) {
      yaml.Fail(node,
                std::to_string(values.size()) +
                    " distortion coefficients; 4, 5 or 8 are expected, and zeros behind them");
    }
    return;
  }
  const std::size_t num = NumCoefficients(k.distortion);
  if (values.size() != num) {
    yaml.Fail(node,
              std::to_string(values.size()) + " distortion coefficients, " + std::to_string(num) +
                  (num == 1 ? " is expected" : " are expected"));
  }
  std::copy(values.begin(), values.end(), k.coefficients.begin());
}

const Projection& ReadProjection(const YamlFile& yaml, const YAML::Node& camera) {
  const YAML::Node node = yaml.Require(camera, "camera_model");
  const std::string name = yaml.RequireText(camera, "camera_model");
  for (const Projection& projection : kProjections) {
    if (name == projection.name) return projection;
  }
  yaml.Fail(node, "camera model '" + name + "' is not supported (pinhole, omni, ds, eucm)");
}

// Of omni, ds and eucm: what lies before fu, and the lens behind the sphere.
void ReadSphere(const YamlFile& yaml,
                const YAML::Node& camera,
                const Projection& projection,
                const std::vector<double>& intrinsics,
                CameraIntrinsics& k) {
  const DistortionModel behind = ParseDistortion(yaml, camera);
  k.distortion = projection.model;
  if (projection.model != DistortionModel::kUnified) {
    if (behind != DistortionModel::kNone)
      yaml.Fail(camera["distortion_model"],
                std::string("a camera model '") + projection.name + "' has no distortion besides");
    std::copy_n(intrinsics.begin(), 2, k.coefficients.begin());
    return;
  }
  if (behind == DistortionModel::kRadialTangential) {
    CameraIntrinsics plain;
    plain.distortion = behind;
    ReadCoefficients(yaml, camera, plain);
    if (plain.distortion != DistortionModel::kRadialTangential)
      yaml.Fail(camera[CoefficientsKey(camera)], "a camera model 'omni' has 4 coefficients");
    k.coefficients = plain.coefficients;
  } else if (behind != DistortionModel::kNone) {
    yaml.Fail(camera["distortion_model"], "a camera model 'omni' goes with radtan or none");
  }
  k.coefficients[4] = intrinsics[0];
}

}  // namespace

bool SetOpenCvCoefficients(const std::vector<double>& c, CameraIntrinsics& k) {
  constexpr std::size_t kRational = 8;
  if (c.size() != 4 && c.size() != 5 && c.size() != 8 && c.size() != 12 && c.size() != 14)
    return false;
  const auto is_zero = [](double value) { return value == 0; };
  const auto from = [&](std::size_t i) {
    return c.begin() + static_cast<std::ptrdiff_t>(std::min(i, c.size()));
  };
  if (!std::all_of(from(kRational), c.end(), is_zero)) return false;
  const bool is_plain = std::all_of(from(4), c.end(), is_zero);
  k.distortion = is_plain ? DistortionModel::kRadialTangential : DistortionModel::kRational;
  k.coefficients = {};
  std::copy(c.begin(), from(is_plain ? 4 : kRational), k.coefficients.begin());
  return true;
}

LensInFile LensForFile(const CameraIntrinsics& k) {
  LensInFile lens{"pinhole", "none", {k.fx, k.fy, k.cx, k.cy}, {}};
  const auto& c = k.coefficients;
  const auto before = [&](std::initializer_list<double> values) {
    lens.intrinsics.insert(lens.intrinsics.begin(), values);
  };
  lens.coefficients.assign(c.begin(),
                           c.begin() + static_cast<std::ptrdiff_t>(NumCoefficients(k.distortion)));
  switch (k.distortion) {
    case DistortionModel::kNone:
      lens.coefficients.assign(4, 0.0);
      break;
    case DistortionModel::kRadialTangential:
    case DistortionModel::kRational:
      lens.distortion_model = "radtan";
      break;
    case DistortionModel::kEquidistant:
      lens.distortion_model = "equidistant";
      break;
    case DistortionModel::kFieldOfView:
      lens.distortion_model = "fov";
      break;
    case DistortionModel::kDoubleSphere:
    case DistortionModel::kExtendedUnified:
      lens.camera_model = k.distortion == DistortionModel::kDoubleSphere ? "ds" : "eucm";
      before({c[0], c[1]});
      lens.coefficients.clear();
      break;
    case DistortionModel::kUnified:
      lens.camera_model = "omni";
      lens.distortion_model = "radtan";
      before({c[4]});
      lens.coefficients.pop_back();
      break;
  }
  return lens;
}

CameraModel ReadLens(const YamlFile& yaml, const YAML::Node& camera, CameraIntrinsics k) {
  const Projection& projection = ReadProjection(yaml, camera);
  const YAML::Node intrinsics = yaml.Require(camera, "intrinsics");
  const std::vector<double> f = yaml.Numbers(intrinsics);
  if (f.size() != 4 + projection.num_before)
    yaml.Fail(intrinsics, std::string("'intrinsics' must be ") + projection.intrinsics);
  const double* const focal = f.data() + projection.num_before;
  k.fx = focal[0], k.fy = focal[1], k.cx = focal[2], k.cy = focal[3];

  const std::string pinhole_problem = CameraModel::WhatIsWrong(k);
  if (!pinhole_problem.empty()) yaml.Fail(intrinsics, "unusable camera: " + pinhole_problem);
  YAML::Node blamed = intrinsics;
  if (projection.model != DistortionModel::kNone) {
    ReadSphere(yaml, camera, projection, f, k);
  } else {
    k.distortion = ParseDistortion(yaml, camera);
    if (k.distortion != DistortionModel::kNone) {
      ReadCoefficients(yaml, camera, k);
      blamed = camera[CoefficientsKey(camera)];
    }
  }
  const std::string problem = CameraModel::WhatIsWrong(k);
  if (!problem.empty()) yaml.Fail(blamed, "unusable camera: " + problem);
  return CameraModel(k);
}

}  // namespace facet
