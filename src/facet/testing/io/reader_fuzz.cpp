// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/io/reader_fuzz.h"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "facet/io/asl_files.h"
#include "facet/io/basalt_calibration.h"
#include "facet/io/calibration_file.h"
#include "facet/io/config_file.h"
#include "facet/io/errors.h"
#include "facet/io/image_reader.h"
#include "facet/io/json_file.h"
#include "facet/io/kitti_raw.h"
#include "facet/io/planes_file.h"
#include "facet/io/ply_reader.h"
#include "facet/io/states_file.h"
#include "facet/io/trajectory_file.h"
#include "facet/testing/io/test_images.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using Path = std::filesystem::path;

const char* const kConfig =
    "# a comment\npipeline: SP\nfrontend:\n  max_tracks: 200\n  tracker: {max_iterations: "
    "12}\nmesh.map.voxel_m: 0.05\n";
const char* const kImageList =
    "#timestamp "
    "[ns],filename\n1403636579763555584,1403636579763555584.png\n1403636579813555456,"
    "\r\n1403636579863555584\n";
const char* const kImu =
    "#timestamp "
    "[ns],w_x,w_y,w_z,a_x,a_y,a_z\n1403636579758555392,-0.099,0.147,0.028,8.17,-0.37,-2.4\n"
    "1403636579763555584,-0.1,1.47e-1,0.028,8.1,-0.38,-2.5\n1403636579768555520,0,0,0,9.81,0,nan\n";
const char* const kTum =
    "1403636579.763555584 1 2 3 0 0 0 1\n1403636579.813555456 1.5 2 3 0 0.6 0 0.8\n";
const char* const kEurocTruth =
    "#timestamp, p, q, v, bw, "
    "ba\n1403636580838555648,4.6,-1.7,0.7,0.5,0.5,-0.5,0.5,0.1,0.2,0.3,0,0,0,0,0,0\n"
    "1403636580843555328,4.6,-1.7,0.7,1,0,0,0\n";
const char* const kStates =
    "timestamp_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,"
    "sigma_px,sigma_py,sigma_pz,sigma_rx,sigma_ry,sigma_rz,status\n"
    "1403636580838555648,1,2,3,1,0,0,0,0.1,0.2,0.3,1e-3,1e-3,1e-3,0.01,0.01,0.01,ok\n"
    "1403636580888555648,,,,,,,,,,,,,,,,,lost\n";
const char* const kPlanes =
    "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first_seen_ns,last_seen_ns,landmarks,area_m2\n"
    "3,0,0,1,0.5,1,2,0.5,horizontal,,1,2,40,2.5\n";
const char* const kTruePlanes =
    "plane,nx,ny,nz,d,area,seen,label\n0,0,0,1,0,20,18.5,floor\n1,0,0.6,0.8,1,2,1,slope\n";
const char* const kPly =
    "ply\nformat ascii 1.0\ncomment hand made\nelement vertex 4\nproperty double x\nproperty "
    "double y\n"
    "property double z\nproperty uchar red\nelement face 1\nproperty list uchar int "
    "vertex_index\nend_header\n"
    "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0.25 9\n4 0 1 2 3\n";
const char* const kBinaryPlyHeader =
    "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
    "y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
constexpr const char* kBasalt =
    R"({"value0": {"T_imu_cam": [
{"px": 0.04, "py": -0.07, "pz": 0.01, "qx": 0.6, "qy": 0, "qz": 0, "qw": 0.8},
{"px": 0.15, "py": -0.07, "pz": 0.01, "qx": 0.6, "qy": 0, "qz": 0, "qw": 0.8}],
"intrinsics": [
{"camera_type": "ds", "intrinsics": {"fx": 158, "fy": 158, "cx": 255, "cy": 257, "xi": -0.1, "alpha": 0.6}},
{"camera_type": "pinhole-radtan8", "intrinsics": {"fx": 400, "fy": 400, "cx": 320, "cy": 240, "k1": 0.1,
"k2": 0, "p1": 0, "p2": 0, "k3": 0, "k4": 0, "k5": 0, "k6": 0}}],
"resolution": [[512, 512], [640, 480]], "imu_update_rate": 200.0, "accel_noise_std": [0.01, 0.01, 0.01],
"gyro_noise_std": [0.0002, 0.0002, 0.0002], "accel_bias_std": [0.001, 0.001, 0.001],
"gyro_bias_std": [0.0001, 0.0001, 0.0001], "cam_time_offset_ns": 0}})";
const char* const kJson =
    R"({"ate_m": 1.5e-3, "names": ["a", "\u00e4", null, true], "inner": {"x": -1}})";
const char* const kKittiCameras =
    "calib_time: 09-Jan-2012 13:57:47\nS_00: 1392 512\nK_00: 984.2439 0 690 0 980.8141 233.1966 0 "
    "0 "
    "1\nD_00: -3.728755e-01 2.037299e-01 2.219027e-03 1.383707e-03 -7.233722e-02\n"
    "R_00: 1 0 0 0 1 0 0 0 1\nT_00: 0 0 0\nS_01: 1392 512\n"
    "K_01: 989.5267 0 702 0 987.8481 245.59 0 0 1\nD_01: -0.36 0.18 0.001 -0.0006 0\n"
    "R_01: 1 0 0 0 1 0 0 0 1\nT_01: -0.5370 0.0048 -0.0122\n";
const char* const kKittiTimes = "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:25.974389445\n";
const char* const kCamchain =
    "cam0:\n  camera_model: pinhole\n  intrinsics: [460, 459.5, 367, 248]\n  distortion_model: "
    "radtan\n"
    "  distortion_coeffs: [-0.28, 0.07, 0.0001, 0.00002]\n  resolution: [752, 480]\n  rostopic: "
    "/cam0/image_raw\n"
    "  T_cam_imu:\n  - [0, 1, 0, 0.06]\n  - [-1, 0, 0, 0.02]\n  - [0, 0, 1, 0.01]\n  - [0, 0, 0, "
    "1]\n"
    "  timeshift_cam_imu: 0.002\ncam1:\n  camera_model: pinhole\n  intrinsics: [457, 456, 379, "
    "255]\n"
    "  distortion_model: equidistant\n  distortion_coeffs: [0.003, 0.0007, 0, 0]\n  resolution: "
    "[752, 480]\n"
    "  T_cn_cnm1:\n  - [1, 0, 0, -0.11]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n";

std::string BinaryPly() {
  std::string text = kBinaryPlyHeader;
  text.append(3 * 3 * sizeof(float), '\0');
  text += '\3';
  for (const char vertex : {'\0', '\1', '\2'})
    text += std::string(1, vertex) + std::string(3, '\0');
  return text;
}

std::vector<std::string> ImageSeeds() {
  TestImage grey{5, 4, 1, {}}, colour{5, 4, 3, {}};
  for (int i = 0; i < 5 * 4 * 3; ++i) {
    colour.samples.push_back(static_cast<std::uint16_t>(4 * i));
    if (i < 5 * 4) grey.samples.push_back(static_cast<std::uint16_t>(12 * i));
  }
  return {"P5\n5 4\n255\n" + std::string(20, 'g'),
          "P2\n2 2\n# comment\n15\n0 7 15 3\n",
          EncodePng(grey),
          EncodePng(colour, {.interlaced = true}),
          EncodePng(colour, {.depth = 16}),
          EncodePng(grey, {.palette = true}),
          EncodeJpeg(grey, 80),
          EncodeJpeg(colour, 90),
          EncodeWebpLossless(colour)};
}

/// A drive in which the file is one of many; those that are missing are written.
void ReadKittiDrive(const Path& drive) {
  std::string oxts;
  for (int i = 0; i < 30; ++i)
    oxts += std::to_string(i) + ".5 ";
  const std::pair<const char*, std::string> files[] = {
      {"calib_cam_to_cam.txt", kKittiCameras},
      {"calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.08 -0.27\n"},
      {"calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n"},
      {"image_00/timestamps.txt", kKittiTimes},
      {"image_01/timestamps.txt", kKittiTimes},
      {"oxts/timestamps.txt", kKittiTimes},
      {"oxts/data/0000000000.txt", oxts},
      {"oxts/data/0000000001.txt", oxts}};
  for (const auto& [name, content] : files) {
    if (!std::filesystem::exists(drive / name)) WriteText(drive / name, content);
  }
  ReadKittiRaw(drive);
}

}  // namespace

std::vector<FuzzedReader> FuzzedReaders() {
  const auto read_list = [](const Path& file) {
    std::vector<std::string> warnings;
    StampCounts left_out;
    ReadImageList(file, warnings, left_out);
  };
  const auto read_imu = [](const Path& file) {
    std::vector<std::string> warnings;
    StampCounts left_out;
    ReadImuFile(file, warnings, left_out);
  };
  const auto read_image = [](const Path& file) {
    cv::Mat image;
    ImageReader reader;
    reader.Read(file, image);
    reader.LargestSample(file);
    reader.ReadOfSize(file, cv::Size(), image, 12);
  };
  const auto read_json = [](const Path& file) {
    if (ReadJsonFile(file).is_null()) throw InputError("not JSON");
  };
  const auto read_camera = [](const Path& file) {
    ReadEurocCalibration(file.parent_path().parent_path(), {});
  };
  return {
      {"config", "config.yaml", {kConfig}, [](const Path& file) { ReadConfigFile(file); }},
      {"camera", "cam0/sensor.yaml", {TestCameraYaml(0)}, read_camera},
      {"kalibr",
       "camchain.yaml",
       {kCamchain},
       [](const Path& file) { ReadKalibrCalibration(file, {}); }},
      {"image list", "data.csv", {kImageList}, read_list},
      {"imu", "data.csv", {kImu}, read_imu},
      {"trajectory", "a.tum", {kTum, kEurocTruth}, [](const Path& file) { ReadTrajectory(file); }},
      {"states", "states.csv", {kStates}, [](const Path& file) { ReadStates(file); }},
      {"truth", "data.csv", {kEurocTruth}, [](const Path& file) { ReadTrueStates(file); }},
      {"planes", "planes.csv", {kPlanes}, [](const Path& file) { ReadEstimatedPlanes(file); }},
      {"true planes", "planes.csv", {kTruePlanes}, [](const Path& file) { ReadTruePlanes(file); }},
      {"ply", "a.ply", {kPly, BinaryPly()}, [](const Path& file) { ReadPly(file); }},
      {"kitti calibration",
       "kitti_a/calib_cam_to_cam.txt",
       {kKittiCameras},
       [](const Path& file) { ReadKittiDrive(file.parent_path()); }},
      {"kitti times",
       "kitti_b/oxts/timestamps.txt",
       {kKittiTimes},
       [](const Path& file) { ReadKittiDrive(file.parent_path().parent_path()); }},
      {"kitti oxts",
       "kitti_c/oxts/data/0000000001.txt",
       {std::string(
           "49.0 8.4 112 0.03 0.02 -1.2 -3 4 5 6 0.1 -0.1 0.2 9.8 0 0 9.8 0.01 -0.02 0.3 7\n")},
       [](const Path& file) { ReadKittiDrive(file.parent_path().parent_path().parent_path()); }},
      {"json", "a.json", {kJson}, read_json},
      {"basalt",
       "calibration.json",
       {kBasalt},
       [](const Path& file) { ReadBasaltCalibration(file, {}); }},
      {"image", "a.png", ImageSeeds(), read_image},
  };
}

bool ReadsOrComplains(const FuzzedReader& reader,
                      const std::filesystem::path& folder,
                      const std::string& content) {
  WriteText(folder / reader.file_name, content);
  try {
    reader.read(folder / reader.file_name);
    return true;
  } catch (const InputError&) {
    return false;
  } catch (const ConfigError&) {
    return false;
  }
}

}  // namespace facet
