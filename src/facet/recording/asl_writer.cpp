// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/asl_writer.h"

#include <cstdio>
#include <system_error>

#include "facet/io/calibration_writer.h"
#include "facet/io/errors.h"
#include "facet/io/png_writer.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

void CreateFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw OutputError(folder.string() + ": cannot be created: " + error.message());
}

/// The folders for images and lists, created.
fs::path PreparedMav0(const fs::path& folder) {
  const fs::path mav0 = folder / "mav0";
  for (const char* sensor : {"cam0/data", "cam1/data", "imu0"})
    CreateFolder(mav0 / sensor);
  return mav0;
}

std::string SampleLine(const ImuSample& sample) {
  char text[240];
  const Vector3d &w = sample.gyro, &a = sample.accel;
  // 17 digits give the same double back.
  std::snprintf(text,
                sizeof(text),
                "%lld,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g",
                static_cast<long long>(sample.t.ns),
                w.x(),
                w.y(),
                w.z(),
                a.x(),
                a.y(),
                a.z());
  return text;
}

std::string ImuYaml(const ImuNoise& noise) {
  char text[240];
  std::snprintf(
      text,
      sizeof(text),
      "gyroscope_noise_density: %.9g\ngyroscope_random_walk: %.9g\n"
      "accelerometer_noise_density: %.9g\naccelerometer_random_walk: %.9g\nupdate_rate: %.9g\n",
      noise.gyro_noise,
      noise.gyro_walk,
      noise.accel_noise,
      noise.accel_walk,
      noise.rate_hz);
  return text;
}

}  // namespace

StagedFile::StagedFile(const fs::path& file) : file_(file), stream_(Partial(), std::ios::binary) {}

void StagedFile::Commit() {
  stream_.close();
  std::error_code error;
  if (stream_) fs::rename(Partial(), file_, error);
  if (!stream_ || error)
    throw OutputError(file_.string() + ": cannot be written; is the disk full?");
}

AslWriter::AslWriter(const fs::path& folder, const Calibration* calibration)
    : mav0_(PreparedMav0(folder)),
      lists_{StagedFile(mav0_ / "cam0" / "data.csv"), StagedFile(mav0_ / "cam1" / "data.csv")},
      imu_(mav0_ / "imu0" / "data.csv") {
  for (StagedFile& list : lists_)
    list.Line("#timestamp [ns],filename");
  imu_.Line("#timestamp [ns],w_x,w_y,w_z [rad/s],a_x,a_y,a_z [m/s^2]");
  if (calibration == nullptr) return;
  WriteCalibration(folder / "camchain-imucam.yaml", calibration->rig);
  StagedFile imu(folder / "imu.yaml");
  imu.Line(ImuYaml(calibration->imu_noise));
  imu.Commit();
}

void AslWriter::Add(const ImuSample& sample) {
  imu_.Line(SampleLine(sample));
}

void AslWriter::Add(const RecordedFrame& frame) {
  AddImage(0, frame.t, *frame.left);
  if (frame.HasRight()) AddImage(1, frame.t_right, *frame.right);
}

void AslWriter::AddImage(std::size_t camera, Timestamp t, const EncodedImage& image) {
  const std::string name = std::to_string(t.ns) + ".png";
  const fs::path file = mav0_ / ("cam" + std::to_string(camera)) / "data" / name;
  std::error_code error;
  if (fs::exists(file, error)) {
    ++num_kept_;
  } else {
    try {
      image.Decode({}, reader_, grey_);
    } catch (const InputError&) {
      ++num_unusable_;
      return;
    }
    const fs::path partial = file.string() + ".partial";
    WritePng(partial, grey_);
    fs::rename(partial, file, error);
    if (error) throw OutputError(file.string() + ": cannot be written: " + error.message());
  }
  lists_[camera].Line(std::to_string(t.ns) + "," + name);
}

void AslWriter::Commit() {
  for (StagedFile& list : lists_)
    list.Commit();
  imu_.Commit();
}

}  // namespace facet
