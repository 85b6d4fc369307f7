// SPDX-License-Identifier: BSD-2-Clause
#include "facet/messages/ros_calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "facet/io/calibration_yaml.h"
#include "facet/io/errors.h"
#include "facet/io/lens_yaml.h"

namespace facet {
namespace {

// Names of lenses in CameraInfo. ROS itself has the first three; the others are the names that
// Kalibr has for them.
struct LensName {
  const char* name;
  DistortionModel model;
};
constexpr LensName kLensNames[] = {
    {"plumb_bob", DistortionModel::kRadialTangential},
    {"rational_polynomial", DistortionModel::kRational},
    {"equidistant", DistortionModel::kEquidistant},
    {"fov", DistortionModel::kFieldOfView},
    {"ds", DistortionModel::kDoubleSphere},
    {"eucm", DistortionModel::kExtendedUnified},
    {"omni", DistortionModel::kUnified},
    // What drivers write, too.
    {"radtan", DistortionModel::kRadialTangential},
    {"radial-tangential", DistortionModel::kRadialTangential},
    {"fisheye", DistortionModel::kEquidistant},
};

bool IsZero(double d) {
  return d == 0;
}

/// The model and coefficients of a lens; false if they are none of ours.
bool ReadLens(const CameraInfoMessage& info, CameraIntrinsics& k) {
  const auto* lens = std::ranges::find_if(
      kLensNames, [&](const LensName& l) { return info.distortion_model == l.name; });
  if (lens == std::end(kLensNames)) return false;
  if (lens->model == DistortionModel::kRadialTangential ||
      lens->model == DistortionModel::kRational) {
    return SetOpenCvCoefficients(info.D, k);
  }
  const std::size_t num = NumCoefficients(lens->model);
  if (info.D.size() < num ||
      !std::all_of(info.D.begin() + static_cast<std::ptrdiff_t>(num), info.D.end(), IsZero))
    return false;
  k.distortion = lens->model;
  std::copy_n(info.D.begin(), num, k.coefficients.begin());
  return true;
}

/// A problem instead of intrinsics where the model is none of ours.
std::pair<CameraIntrinsics, std::string> IntrinsicsOf(const CameraInfoMessage& info) {
  constexpr std::uint32_t kMaxSide = 1 << 15;
  CameraIntrinsics k;
  k.width = static_cast<int>(std::min(info.width, kMaxSide));
  k.height = static_cast<int>(std::min(info.height, kMaxSide));
  k.fx = info.K[0];
  k.cx = info.K[2];
  k.fy = info.K[4];
  k.cy = info.K[5];
  if (std::ranges::all_of(info.D, IsZero)) return {k, CameraModel::WhatIsWrong(k)};
  if (!ReadLens(info, k)) {
    return {k,
            "the lens model '" + info.distortion_model + "' with " + std::to_string(info.D.size()) +
                " coefficients is not known"};
  }
  return {k, CameraModel::WhatIsWrong(k)};
}

/// CameraInfo belongs to the raw images. Rectified ones of the same camera have no distortion and
/// the matrix P, and are those of a camera that is turned by R; both are filled in only where the
/// camera was calibrated for rectification.
std::string Rectify(const CameraInfoMessage& info, CameraIntrinsics& k, SE3& T_BC) {
  const Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.R.data());
  if (info.P[0] == 0 || !R.isUnitary(1e-3) || R.determinant() < 0) {
    return "the images are rectified, but it says nothing about rectified images (R and P)";
  }
  k.fx = info.P[0];
  k.cx = info.P[2];
  k.fy = info.P[5];
  k.cy = info.P[6];
  k.distortion = DistortionModel::kNone;
  k.coefficients = {};
  T_BC = T_BC * SE3(Quaterniond(R).normalized().conjugate(), Vector3d::Zero());
  return CameraModel::WhatIsWrong(k);
}

/// Raw to rectified camera; none is given where nothing is turned.
std::optional<Matrix3d> RectifyingRotation(const CameraInfoMessage& info) {
  const Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.R.data());
  if (R.isZero()) return Matrix3d::Identity();
  if (!R.allFinite() || !R.isUnitary(1e-3) || R.determinant() < 0) return std::nullopt;
  return R;
}

bool IsTurned(const CameraInfoMessage& info) {
  const std::optional<Matrix3d> R = RectifyingRotation(info);
  return R && !R->isIdentity(1e-9);
}

}  // namespace

// Between the rectified cameras there is only the baseline: P of the right one is K [I | -b].
std::optional<SE3> RightToLeft(const std::array<CameraInfoMessage, 2>& cameras) {
  const auto& P = cameras[1].P;
  const double baseline_m = -P[3] / P[0];
  if (!std::isfinite(baseline_m) || baseline_m == 0) return std::nullopt;
  const Vector3d right_in_rectified(baseline_m, 0, 0);
  const auto R0 = RectifyingRotation(cameras[0]), R1 = RectifyingRotation(cameras[1]);
  if (!R0 || !R1) return std::nullopt;
  const Matrix3d R_C0C1 = R0->transpose() * *R1;
  return SE3(Quaterniond(R_C0C1).normalized(), R0->transpose() * right_in_rectified);
}

void SetLens(const CameraIntrinsics& k, CameraInfoMessage& info) {
  const DistortionModel model =
      k.distortion == DistortionModel::kNone ? DistortionModel::kRadialTangential : k.distortion;
  const auto num = static_cast<std::ptrdiff_t>(NumCoefficients(model));
  info.D.assign(k.coefficients.begin(), k.coefficients.begin() + num);
  if (model == DistortionModel::kRadialTangential) info.D.push_back(0);  // its third radial one
  info.distortion_model =
      std::ranges::find_if(kLensNames, [&](const LensName& l) { return l.model == model; })->name;
}

std::optional<SE3> FindTransform(const std::vector<FrameTransform>& transforms,
                                 const std::string& a,
                                 const std::string& b) {
  std::map<std::string, SE3> T_a_frame = {{a, SE3()}};
  std::vector<std::string> reached = {a};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const std::string frame = reached[i];
    const SE3 T = T_a_frame.at(frame);
    for (const FrameTransform& transform : transforms) {
      const bool is_down = transform.parent == frame;
      if (!is_down && transform.child != frame) continue;
      const std::string& other = is_down ? transform.child : transform.parent;
      if (T_a_frame.contains(other)) continue;
      T_a_frame[other] =
          T * (is_down ? transform.T_parent_child : transform.T_parent_child.Inverse());
      reached.push_back(other);
    }
  }
  const auto found = T_a_frame.find(b);
  if (found == T_a_frame.end()) return std::nullopt;
  return found->second;
}

RosCalibration CalibrationFromMessages(const RosCalibrationMessages& messages,
                                       const std::filesystem::path& imu_file) {
  RosCalibration result;
  Calibration calibration;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string side = i == 0 ? "left" : "right";
    if (!messages.cameras[i]) {
      result.problem = "no camera_info beside the " + side + " images";
      return result;
    }
    const CameraInfoMessage& info = *messages.cameras[i];
    const std::string& frame =
        info.header.frame.empty() ? messages.camera_frames[i] : info.header.frame;
    const auto T_BC = FindTransform(messages.transforms, messages.imu_frame, frame);
    if (!T_BC || frame.empty() || messages.imu_frame.empty()) {
      result.problem = "no static transform between the " + side + " camera (frame '" + frame +
                       "') and the IMU (frame '" + messages.imu_frame + "')";
      return result;
    }
    SE3& mounted = calibration.rig.T_BC[i];
    mounted = *T_BC;
    auto [intrinsics, wrong] = IntrinsicsOf(info);
    // Drivers that publish rectified images alone write their calibration as that of raw ones.
    const bool is_of_raw =
        intrinsics.distortion != DistortionModel::kNone || !wrong.empty() || IsTurned(info);
    if (messages.are_rectified[i] && is_of_raw) wrong = Rectify(info, intrinsics, mounted);
    if (!wrong.empty()) {
      result.problem = "camera_info of the " + side + " camera: " + wrong;
      return result;
    }
    calibration.rig.cameras[i] = CameraModel(intrinsics);
  }
  const double baseline_m = calibration.rig.baseline_m();
  if (!(baseline_m > 1e-3 && baseline_m < 10)) {
    result.problem =
        "the static transforms put the cameras " + std::to_string(baseline_m) + " m apart";
    return result;
  }
  calibration.source = "camera_info and tf_static of the recording, t_imu = t_cam +0.000000 s";
  if (imu_file.empty()) {
    calibration.warnings.emplace_back(
        "a bag has no noise densities of its IMU, those of an ADIS16448 are used; give the real "
        "ones with --imu-calibration");
  } else {
    calibration.imu_noise = ReadImuNoise(YamlFile(imu_file), calibration.warnings);
    calibration.source += ", IMU noise from " + imu_file.string();
  }
  result.calibration = calibration;
  return result;
}

}  // namespace facet
