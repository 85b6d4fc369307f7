// SPDX-License-Identifier: BSD-2-Clause
#include "facet/faults/recording_copy.h"

#include <fstream>
#include <string>
#include <system_error>

#include "facet/io/asl_dataset.h"
#include "facet/io/calibration_file.h"
#include "facet/io/errors.h"
#include "facet/io/image_reader.h"
#include "facet/io/png_writer.h"
#include "facet/render/calibration_draw.h"
#include "facet/render/sequence_writer.h"

namespace facet {

namespace fs = std::filesystem;

namespace {

fs::path CameraFolder(const fs::path& mav0, std::size_t camera) {
  return mav0 / ("cam" + std::to_string(camera));
}

// What is there already may be a link into the source, which must not be written through.
void MakeRoom(const fs::path& file) {
  std::error_code error;
  fs::remove(file, error);
  if (error) throw OutputError(file.string() + ": " + error.message());
}

void LinkOrCopy(const fs::path& from, const fs::path& to) {
  MakeRoom(to);
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (!error) return;
  fs::copy_file(from, to, error);
  if (error) throw OutputError(to.string() + ": " + error.message());
}

void CopyFolder(const fs::path& from, const fs::path& to) {
  if (!fs::is_directory(from)) return;
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    const fs::path target = to / fs::relative(entry.path(), from);
    std::error_code error;
    fs::create_directories(target.parent_path(), error);
    if (error) throw OutputError(target.string() + ": " + error.message());
    // What is large is never written again; calibration files may be.
    if (!entry.is_regular_file()) continue;
    if (entry.path().extension() == ".ply") {
      LinkOrCopy(entry.path(), target);
    } else {
      fs::copy_file(entry.path(), target, fs::copy_options::overwrite_existing, error);
    }
    if (error) throw OutputError(target.string() + ": " + error.message());
  }
}

StereoRig ExactRig(const fs::path& sequence, const StereoRig& recorded) {
  if (!fs::is_regular_file(sequence / "truth" / "cam0" / "sensor.yaml")) return recorded;
  return FindCalibration({}, {sequence / "truth", {}}).rig;
}

void WriteImages(const std::vector<RecordedImage>& images, const fs::path& camera) {
  std::ofstream list(camera / "data.csv");
  list << "#timestamp [ns],filename\n";
  ImageReader reader;
  for (const RecordedImage& image : images) {
    const std::string extension = image.edits.empty() ? image.file.extension().string() : ".png";
    const std::string name = std::to_string(image.t.ns) + extension;
    list << image.t.ns << ',' << name << '\n';
    if (image.edits.empty()) {
      LinkOrCopy(image.file, camera / "data" / name);
      continue;
    }
    cv::Mat pixels;
    reader.Read(image.file, pixels);
    for (const ImageEdit& edit : image.edits)
      edit(pixels);
    MakeRoom(camera / "data" / name);
    WritePng(camera / "data" / name, pixels);
  }
  list.close();
  if (!list) throw OutputError((camera / "data.csv").string() + ": cannot be written");
}

}  // namespace

void AddImuErrors(const ImuErrors& errors, RecordingCopy& recording) {
  AddImuErrors(errors, recording.imu);
  recording.exact_rig.gyro_scale = GyroScaleWith(errors, recording.exact_rig.gyro_scale);
  const ImuErrors before = recording.imu_errors.value_or(ImuErrors());
  recording.imu_errors = {errors.of_gyro * before.of_gyro, errors.of_accel * before.of_accel};
}

RecordingCopy ReadRecording(const fs::path& sequence) {
  const AslDataset dataset(sequence);
  const fs::path mav0 = FindMav0(sequence);
  RecordingCopy recording;
  recording.source = mav0.parent_path();
  recording.rig = dataset.rig();
  recording.exact_rig = ExactRig(recording.source, recording.rig);
  recording.imu_noise = dataset.imu_noise();
  recording.imu = dataset.imu();
  recording.imu_errors = ReadImuErrors(recording.source);
  for (const FrameEntry& frame : dataset.frames()) {
    recording.images[0].push_back({frame.t, CameraFolder(mav0, 0) / "data" / frame.left, {}});
    if (frame.HasRight())
      recording.images[1].push_back({frame.t, CameraFolder(mav0, 1) / "data" / frame.right, {}});
  }
  return recording;
}

void WriteRecording(const RecordingCopy& recording, const fs::path& folder) {
  const auto& left = recording.images[0];
  const double span_s = left.size() < 2 ? 0 : ToSeconds(left.back().t - left.front().t);
  const double rate_hz = span_s > 0 ? static_cast<double>(left.size() - 1) / span_s : 20;
  CopyFolder(recording.source / "truth", folder / "truth");
  for (const char* truth : {"state_groundtruth_estimate0", "mocap0", "vicon0", "pointcloud0"})
    CopyFolder(recording.source / "mav0" / truth, folder / "mav0" / truth);
  WriteCalibration(folder, recording.rig, recording.exact_rig, recording.imu_noise, rate_hz);
  for (std::size_t camera = 0; camera < 2; ++camera)
    WriteImages(recording.images[camera], CameraFolder(folder / "mav0", camera));
  WriteImu(folder, recording.imu);
  if (recording.imu_errors) WriteImuErrors(folder, *recording.imu_errors);
}

}  // namespace facet
