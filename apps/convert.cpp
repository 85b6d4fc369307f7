// SPDX-License-Identifier: BSD-2-Clause
// `facet convert`: any recording as a folder in the ASL layout.
#include "convert.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>
#include <variant>

#include "progress_bar.h"

#include "facet/io/calibration_writer.h"
#include "facet/io/errors.h"
#include "facet/io/png_writer.h"
#include "facet/recording/open_recording.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

void CreateFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw OutputError(folder.string() + ": cannot be created: " + error.message());
}

/// A text file that appears under its name when it is complete.
class StagedFile {
 public:
  explicit StagedFile(const fs::path& file) : file_(file), stream_(Partial(), std::ios::binary) {}
  void Line(const std::string& line) { stream_ << line << '\n'; }
  void Commit() {
    stream_.close();
    std::error_code error;
    if (stream_) fs::rename(Partial(), file_, error);
    if (!stream_ || error)
      throw OutputError(file_.string() + ": cannot be written; is the disk full?");
  }

 private:
  fs::path Partial() const { return file_.string() + ".partial"; }
  fs::path file_;
  std::ofstream stream_;
};

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

/// Writes frames and samples below mav0.
class AslWriter {
 public:
  explicit AslWriter(const fs::path& mav0)
      : mav0_(Prepared(mav0)),
        lists_{StagedFile(mav0 / "cam0" / "data.csv"), StagedFile(mav0 / "cam1" / "data.csv")},
        imu_(mav0 / "imu0" / "data.csv") {
    for (StagedFile& list : lists_)
      list.Line("#timestamp [ns],filename");
    imu_.Line("#timestamp [ns],w_x,w_y,w_z [rad/s],a_x,a_y,a_z [m/s^2]");
  }

  void Add(const ImuSample& sample) { imu_.Line(SampleLine(sample)); }

  /// An image that cannot be decoded is left out.
  void Add(const RecordedFrame& frame) {
    AddImage(0, frame.t, *frame.left);
    if (frame.HasRight()) AddImage(1, frame.t, *frame.right);
  }

  void Commit() {
    for (StagedFile& list : lists_)
      list.Commit();
    imu_.Commit();
  }

  int num_kept() const { return num_kept_; }
  int num_unusable() const { return num_unusable_; }

 private:
  static const fs::path& Prepared(const fs::path& mav0) {
    for (const char* folder : {"cam0/data", "cam1/data", "imu0"})
      CreateFolder(mav0 / folder);
    return mav0;
  }

  void AddImage(int camera, Timestamp t, const EncodedImage& image) {
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

  fs::path mav0_;
  StagedFile lists_[2];
  StagedFile imu_;
  ImageReader reader_;
  cv::Mat grey_;
  int num_kept_ = 0, num_unusable_ = 0;
};

void WriteCalibrationFiles(const fs::path& folder, const Recording& recording) {
  if (recording.calibration() == nullptr) return;
  WriteCalibration(folder / "camchain-imucam.yaml", recording.calibration()->rig);
  StagedFile imu(folder / "imu.yaml");
  imu.Line(ImuYaml(recording.calibration()->imu_noise));
  imu.Commit();
}

void RequireOwnFolder(const fs::path& out) {
  std::error_code error;
  const bool is_other =
      fs::exists(out, error) && !fs::is_empty(out, error) && !fs::exists(out / "mav0", error);
  if (is_other || fs::exists(out / "mav0/imu0/data.csv", error)) {
    throw ConfigError(out.string() + (is_other ? ": holds something else; choose another folder"
                                               : ": holds a complete recording already"));
  }
}

}  // namespace

void ConvertCommand(const ConvertArguments& arguments) {
  const fs::path out = arguments.out;
  RequireOwnFolder(out);
  RecordingOptions options;
  options.calibration = {arguments.calibration, arguments.imu_calibration};
  options.topics = ParseTopics(arguments.topics);
  options.needs_calibration = false;
  const std::unique_ptr<Recording> recording = OpenRecording(arguments.recording, options);
  AslWriter writer(out / "mav0");
  WriteCalibrationFiles(out, *recording);
  ProgressBar bar(!arguments.quiet);
  int num_frames = 0, num_expected = 0;
  std::string damage;
  try {
    while (const auto event = recording->Next()) {
      if (const auto* sample = std::get_if<ImuSample>(&*event)) {
        writer.Add(*sample);
        continue;
      }
      const auto& frame = std::get<RecordedFrame>(*event);
      if (num_frames == 0) num_expected = recording->NumFrames(frame.t, frame.t + FromSeconds(1e9));
      writer.Add(frame);
      bar.Update(++num_frames, std::max(num_frames, num_expected), "");
    }
  } catch (const InputError& error) {
    damage = error.what();
  }
  bar.Clear();
  writer.Commit();
  for (const std::string& warning : recording->Warnings())
    std::fprintf(stderr, "facet: warning: %s\n", warning.c_str());
  if (!damage.empty()) throw InputError(damage + "; what came before was converted");
  std::printf("%d frames (%d images were there already, %d cannot be decoded) -> %s\n",
              num_frames,
              writer.num_kept(),
              writer.num_unusable(),
              out.c_str());
}

}  // namespace facet
