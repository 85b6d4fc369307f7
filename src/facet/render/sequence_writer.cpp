// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/sequence_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "facet/io/calibration_yaml.h"
#include "facet/io/errors.h"
#include "facet/io/lens_yaml.h"
#include "facet/io/ply_writer.h"
#include "facet/io/text_file.h"
#include "facet/io/yaml_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// Text of a number with all its digits.
std::string Digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.12g", value);
  return text.data();
}

std::string Join(const std::vector<double>& values) {
  std::string text;
  for (const double value : values)
    text += (text.empty() ? "" : ",") + Digits(value);
  return text;
}

std::string Columns(const Vector3d& v) {
  return Join({v.x(), v.y(), v.z()});
}

std::string FormatTransform(const SE3& T) {
  const Matrix3d R = T.R();
  std::string text = "T_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      text += Digits(R(row, column)) + ", ";
    text += Digits(T.p(row)) + ",\n         ";
  }
  return text + "0.0, 0.0, 0.0, 1.0]\n";
}

/// Only where there is one, as in EuRoC's own files.
std::string FormatTimeOffset(Duration time_offset) {
  if (time_offset == Duration{}) return "";
  return "timeshift_cam_imu: " + Digits(ToSeconds(time_offset)) + " # t_imu = t_cam + shift [s]\n";
}

/// Only where a lens does anything beside its model.
std::string FormatLensModes(const LensModeVector& modes) {
  if (modes.isZero(0)) return "";
  return "lens_modes: [" + Join({modes.begin(), modes.end()}) + "] # beside the model [px]\n";
}

std::string FormatCamera(const StereoRig& rig, std::size_t camera, double rate_hz) {
  const CameraIntrinsics& k = rig.cameras[camera].intrinsics();
  const LensInFile lens = LensForFile(k);
  const bool is_radtan = lens.distortion_model == "radtan";
  return "%YAML:1.0\nsensor_type: camera\ncomment: simulated by facet simulate\n\n" +
         FormatTransform(rig.T_BC[camera]) + "\nrate_hz: " + Digits(rate_hz) + "\nresolution: [" +
         std::to_string(k.width) + ", " + std::to_string(k.height) +
         "]\ncamera_model: " + lens.camera_model + "\nintrinsics: [" + Join(lens.intrinsics) +
         "] #" + (lens.camera_model == "pinhole" ? "fu, fv, cu, cv" : "as Kalibr has them") +
         "\ndistortion_model: " + (is_radtan ? "radial-tangential" : lens.distortion_model) +
         "\ndistortion_coefficients: [" + Join(lens.coefficients) + "]\n" +
         FormatLensModes(rig.lens_modes[camera]) + FormatTimeOffset(rig.time_offset);
}

/// Only where there is one that a calibration may have: a gross fault of the gyroscope is none.
std::string FormatGyroScale(const Vector3d& scale) {
  if (scale.isZero(0) || !(scale.cwiseAbs().maxCoeff() < kMaxGyroScale)) return "";
  return "gyro_scale: [" + Columns(scale) + "] # the share that each axis reads too much\n";
}

std::string FormatImu(const ImuNoise& noise, const Vector3d& gyro_scale) {
  return "%YAML:1.0\nsensor_type: imu\ncomment: simulated by facet simulate\n\n" +
         FormatTransform(SE3()) + "rate_hz: " + Digits(noise.rate_hz) +
         "\n\ngyroscope_noise_density: " + Digits(noise.gyro_noise) +
         "     # [ rad / s / sqrt(Hz) ]\ngyroscope_random_walk: " + Digits(noise.gyro_walk) +
         "       # [ rad / s^2 / sqrt(Hz) ]\naccelerometer_noise_density: " +
         Digits(noise.accel_noise) +
         "  # [ m / s^2 / sqrt(Hz) ]\naccelerometer_random_walk: " + Digits(noise.accel_walk) +
         "    # [ m / s^3 / sqrt(Hz) ]\n" + FormatGyroScale(gyro_scale);
}

/// A csv file that is written line by line.
class CsvFile {
 public:
  CsvFile(fs::path file, const char* header) : file_(std::move(file)), stream_(file_) {
    stream_ << header << '\n';
  }
  std::ofstream& stream() { return stream_; }
  void Close() {
    stream_.close();
    if (!stream_)
      throw OutputError(file_.string() + ": cannot be written (disk full, permissions?)");
  }

 private:
  fs::path file_;
  std::ofstream stream_;
};

fs::path ImuErrorsFile(const fs::path& sequence) {
  return sequence / "truth" / "imu0" / "errors.yaml";
}

/// A row of planes.csv: one planar part, or all parts of a floor, ceiling or wall that lie in one
/// plane.
struct PlaneRow {
  const ScenePart* first = nullptr;
  double area_m2 = 0;
  PartSeen seen;
};

struct PlaneTable {
  std::vector<PlaneRow> rows;
  std::vector<std::int32_t> row_of_part;  // -1: not planar
};

bool IsSamePlane(const ScenePart& a, const ScenePart& b) {
  constexpr double kSame = 1e-6;
  const bool is_building = a.label == "floor" || a.label == "ceiling" || a.label == "wall";
  return is_building && a.label == b.label && (a.n_W - b.n_W).norm() < kSame &&
         std::abs(a.d_W - b.d_W) < kSame;
}

PlaneTable TabulatePlanes(const SceneMesh& mesh, const SurfaceTruth& truth) {
  PlaneTable table;
  for (std::size_t i = 0; i < mesh.parts.size(); ++i) {
    const ScenePart& part = mesh.parts[i];
    table.row_of_part.push_back(-1);
    if (!part.is_planar) continue;
    auto row = std::find_if(table.rows.begin(), table.rows.end(), [&](const PlaneRow& r) {
      return IsSamePlane(*r.first, part);
    });
    if (row == table.rows.end()) row = table.rows.insert(row, {&part, 0, {}});
    row->area_m2 += part.area_m2;
    row->seen.area_m2 += truth.parts[i].area_m2;
    row->seen.seconds = std::max(row->seen.seconds, truth.parts[i].seconds);
    table.row_of_part.back() = static_cast<std::int32_t>(row - table.rows.begin());
  }
  return table;
}

void WritePlanes(const fs::path& file, const PlaneTable& table) {
  CsvFile csv(file, "#plane,nx,ny,nz,d [m] (n.x = d),area [m^2],seen area [m^2],label,seen_s [s]");
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const PlaneRow& row = table.rows[i];
    csv.stream() << i << ',' << Columns(row.first->n_W) << ','
                 << Join({row.first->d_W, row.area_m2, row.seen.area_m2}) << ',' << row.first->label
                 << ',' << Digits(row.seen.seconds) << '\n';
  }
  csv.Close();
}

void WriteMesh(const fs::path& file, const SceneMesh& mesh, const PlaneTable& table) {
  std::ofstream stream(file, std::ios::binary);
  stream << "ply\nformat binary_little_endian 1.0\ncomment plane_id: row of planes.csv, -1 where "
            "the surface is curved\nelement vertex "
         << mesh.vertices.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
         << mesh.triangles.size()
         << "\nproperty list uchar int vertex_indices\nproperty int plane_id\nend_header\n";
  for (const SceneVertex& v : mesh.vertices)
    stream.write(reinterpret_cast<const char*>(v.p_W.data()), 3 * sizeof(float));
  for (const SceneTriangle& t : mesh.triangles) {
    stream.put(3);
    stream.write(reinterpret_cast<const char*>(t.vertices.data()), sizeof(t.vertices));
    stream.write(reinterpret_cast<const char*>(&table.row_of_part[t.part]), sizeof(std::int32_t));
  }
  stream.close();
  if (!stream) throw OutputError(file.string() + ": cannot be written (disk full, permissions?)");
}

}  // namespace

void WriteCalibration(const fs::path& sequence,
                      const StereoRig& measured,
                      const StereoRig& exact,
                      const ImuNoise& noise,
                      double frame_rate_hz) {
  const fs::path mav0 = sequence / "mav0";
  std::error_code error;
  for (const char* folder : {"mav0/cam0/data",
                             "mav0/cam1/data",
                             "mav0/imu0",
                             "mav0/state_groundtruth_estimate0",
                             "mav0/pointcloud0",
                             "truth/cam0",
                             "truth/cam1",
                             "truth/imu0"}) {
    fs::create_directories(sequence / folder, error);
    if (error) throw OutputError((sequence / folder).string() + ": " + error.message());
  }
  WriteTextFile(mav0 / "body.yaml", "%YAML:1.0\ncomment: simulated by facet simulate\n");
  for (const auto& [root, rig] :
       {std::pair(mav0, &measured), std::pair(sequence / "truth", &exact)}) {
    for (std::size_t c = 0; c < 2; ++c) {
      WriteTextFile(root / ("cam" + std::to_string(c)) / "sensor.yaml",
                    FormatCamera(*rig, c, frame_rate_hz));
    }
    WriteTextFile(root / "imu0" / "sensor.yaml", FormatImu(noise, rig->gyro_scale));
  }
  WriteTextFile(mav0 / "state_groundtruth_estimate0" / "sensor.yaml",
                "%YAML:1.0\nsensor_type: visual-inertial\ncomment: exact, from facet simulate\n\n" +
                    FormatTransform(SE3()));
}

void WriteImuErrors(const fs::path& sequence, const ImuErrors& errors) {
  const auto rows = [](const Matrix3d& M) {
    return "[" + Columns(M.row(0)) + "," + Columns(M.row(1)) + "," + Columns(M.row(2)) + "]\n";
  };
  WriteTextFile(
      ImuErrorsFile(sequence),
      "%YAML:1.0\n# The sensors read these 3 x 3 matrices times what they would without them.\n"
      "of_gyro: " +
          rows(errors.of_gyro) + "of_accel: " + rows(errors.of_accel));
}

std::optional<ImuErrors> ReadImuErrors(const fs::path& sequence) {
  if (!fs::is_regular_file(ImuErrorsFile(sequence))) return std::nullopt;
  const YamlFile yaml(ImuErrorsFile(sequence));
  const auto matrix = [&](const char* key) -> Matrix3d {
    const YAML::Node node = yaml.Require(yaml.root(), key);
    const std::vector<double> values = yaml.Numbers(node);
    if (values.size() != 9) yaml.Fail(node, "a matrix has nine numbers, row by row");
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  };
  return ImuErrors{matrix("of_gyro"), matrix("of_accel")};
}

fs::path ImageFile(const fs::path& sequence, int camera, Timestamp t) {
  return sequence / "mav0" / ("cam" + std::to_string(camera)) / "data" /
         (std::to_string(t.ns) + ".png");
}

void WriteImageLists(const fs::path& sequence, std::span<const Timestamp> stamps) {
  for (const char* camera : {"cam0", "cam1"}) {
    CsvFile csv(sequence / "mav0" / camera / "data.csv", "#timestamp [ns],filename");
    for (const Timestamp t : stamps)
      csv.stream() << t.ns << ',' << t.ns << ".png\n";
    csv.Close();
  }
}

void WriteImu(const fs::path& sequence, std::span<const ImuSample> samples) {
  CsvFile csv(sequence / "mav0" / "imu0" / "data.csv",
              "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
              "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]");
  for (const ImuSample& s : samples)
    csv.stream() << s.t.ns << ',' << Columns(s.gyro) << ',' << Columns(s.accel) << '\n';
  csv.Close();
}

void WriteStates(const fs::path& sequence, std::span<const NavState> states) {
  CsvFile csv(sequence / "mav0" / "state_groundtruth_estimate0" / "data.csv",
              "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
              "q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], "
              "b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], "
              "b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]");
  for (const NavState& s : states) {
    const Quaterniond& q = s.T_WB.q;
    csv.stream() << s.t.ns << ',' << Columns(s.T_WB.p) << ',' << Join({q.w(), q.x(), q.y(), q.z()})
                 << ',' << Columns(s.v_WB) << ',' << Columns(s.bias.b_g) << ','
                 << Columns(s.bias.b_a) << '\n';
  }
  csv.Close();
}

void WriteSurfaces(const fs::path& sequence, const SceneMesh& mesh, const SurfaceTruth& truth) {
  const PlaneTable table = TabulatePlanes(mesh, truth);
  WriteMesh(sequence / "truth" / "mesh.ply", mesh, table);
  WritePlanes(sequence / "truth" / "planes.csv", table);
  WritePlyPoints(sequence / "mav0" / "pointcloud0" / "data.ply", truth.points_W);
}

}  // namespace facet
