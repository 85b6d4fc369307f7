// SPDX-License-Identifier: BSD-2-Clause
// `facet convert`: any recording as a folder in the ASL layout, or as an MCAP file.
#include "convert.h"

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>
#include <variant>

#include "interrupts.h"
#include "progress_bar.h"
#include "run.h"

#include "facet/io/errors.h"
#include "facet/recording/asl_writer.h"
#include "facet/recording/mcap_recording_writer.h"
#include "facet/recording/open_recording.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

bool IsMcap(const fs::path& out) {
  return out.extension() == ".mcap";
}

/// A conversion to the ASL layout may go on in its folder.
void RequireFreePlace(const ConvertArguments& arguments) {
  const fs::path out = arguments.out;
  std::error_code error;
  if (IsMcap(out)) {
    if (fs::exists(out, error)) throw ConfigError(out.string() + ": exists already");
    return;
  }
  const bool is_other =
      fs::exists(out, error) && !fs::is_empty(out, error) && !fs::exists(out / "mav0", error);
  if (is_other || fs::exists(out / "mav0/imu0/data.csv", error)) {
    throw ConfigError(out.string() + (is_other ? ": holds something else; choose another folder"
                                               : ": holds a complete recording already"));
  }
}

/// MCAP where the name says so, otherwise the ASL layout.
std::unique_ptr<RecordingWriter> OpenWriter(const ConvertArguments& arguments,
                                            const Calibration* calibration) {
  if (!IsMcap(arguments.out)) return std::make_unique<AslWriter>(arguments.out, calibration);
  const auto compression =
      arguments.compression == "none" ? Compression::kNone : Compression::kZstd;
  return std::make_unique<McapRecordingWriter>(arguments.out, compression, calibration);
}

/// For what has no place in messages.
void WarnOfWhatIsLost(const ConvertArguments& arguments, const Calibration* calibration) {
  if (!IsMcap(arguments.out) || calibration == nullptr) return;
  const StereoRig& rig = calibration->rig;
  const double offset_s = ToSeconds(rig.time_offset);
  if (offset_s != 0) {
    std::fprintf(stderr,
                 "facet: warning: the messages of an MCAP file have no place for the offset "
                 "between camera and IMU (%+.6f s); use the calibration with --calibration\n",
                 offset_s);
  }
  if (rig.HasLensModes() || !rig.gyro_scale.isZero(0) || rig.covariance) {
    std::fprintf(stderr,
                 "facet: warning: the messages of an MCAP file have no place for what a run has "
                 "estimated of lenses beside their models and of the gyroscope, nor for how well "
                 "it is known; use the calibration with --calibration\n");
  }
}

void EndIfInterrupted(const ConvertArguments& arguments) {
  if (!WasInterrupted()) return;
  throw RunEndedError(128 + SIGINT,
                      IsMcap(arguments.out) ? "interrupted; nothing was written"
                                            : "interrupted; the same command goes on from here");
}

}  // namespace

void ConvertCommand(const ConvertArguments& arguments) {
  RequireFreePlace(arguments);
  RecordingOptions options;
  options.calibration = {arguments.calibration, arguments.imu_calibration};
  options.topics = ParseTopics(arguments.topics);
  options.needs_calibration = false;
  const std::unique_ptr<Recording> recording = OpenRecording(arguments.recording, options);
  CatchInterrupts();
  const std::unique_ptr<RecordingWriter> writer = OpenWriter(arguments, recording->calibration());
  ProgressBar bar(!arguments.quiet);
  int num_frames = 0, num_expected = 0;
  std::string damage;
  try {
    while (const auto event = recording->Next()) {
      EndIfInterrupted(arguments);
      if (const auto* sample = std::get_if<ImuSample>(&*event)) {
        writer->Add(*sample);
        continue;
      }
      const auto& frame = std::get<RecordedFrame>(*event);
      if (num_frames == 0) num_expected = recording->NumFrames(frame.t, frame.t + FromSeconds(1e9));
      writer->Add(frame);
      bar.Update(++num_frames, std::max(num_frames, num_expected), "");
    }
  } catch (const InputError& error) {
    damage = error.what();
  }
  bar.Clear();
  writer->Commit();
  WarnOfWhatIsLost(arguments, recording->calibration());
  for (const std::string& warning : recording->Warnings())
    std::fprintf(stderr, "facet: warning: %s\n", warning.c_str());
  if (!damage.empty()) throw InputError(damage + "; what came before was converted");
  std::printf("%d frames (%d images were there already, %d cannot be decoded) -> %s\n",
              num_frames,
              writer->num_kept(),
              writer->num_unusable(),
              arguments.out.c_str());
}

}  // namespace facet
