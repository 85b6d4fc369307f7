// SPDX-License-Identifier: BSD-2-Clause
// The messages of a bag as a stream of IMU samples and stereo pairs.
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "facet/recording/imu_joiner.h"
#include "facet/recording/message_source.h"
#include "facet/recording/recording.h"
#include "facet/recording/sensor_messages.h"
#include "facet/recording/stereo_pairer.h"
#include "facet/recording/topic_choice.h"

namespace facet {

struct BagOptions {
  CalibrationFiles calibration;
  TopicNames topics;
  bool needs_calibration = true;
};

/// Stamps are those of the message headers (those of the recorder only where headers have none).
/// In memory are what waits for its partner, at most two seconds or 256 MB, and what the source
/// keeps.
class BagRecording : public Recording {
 public:
  /// `path` is what the user gave: the calibration is looked for beside it if the recording carries
  /// none. Reads the first seconds. Throws InputError where the bag cannot be used (topics missing,
  /// no calibration though one is needed, no stereo pair or none that can be decoded, images of
  /// another size than the calibration's, stamps of cameras and IMU from different clocks),
  /// ConfigError where topics must be chosen.
  BagRecording(std::unique_ptr<MessageSource> source,
               const std::filesystem::path& path,
               const BagOptions& options);

  const std::string& name() const override { return name_; }
  const Calibration* calibration() const override {
    return calibration_ ? &*calibration_ : nullptr;
  }
  std::optional<RecordingEvent> Next() override;
  void Rewind() override;
  int NumFrames(Timestamp from, Timestamp to) const override;
  std::vector<std::string> Warnings() const override;

  const TopicChoice& choice() const { return choice_; }
  /// Why there is no calibration in the messages; empty if there is one.
  const std::string& calibration_problem() const { return calibration_problem_; }

 private:
  enum class Role { kLeft, kRight, kImu, kGyro, kAccel };
  struct Opening;

  void ReadOpening(Opening& opening);
  void LookAt(const Message& message, Opening& opening);
  void FindCalibrationOf(const Opening& opening, const BagOptions& options);
  void FindMissingStamps(const Opening& opening);
  void FindSampleBits(const Opening& opening);
  void JudgeDelays(const Opening& opening);
  void RequireReadablePair();
  std::string PlaceOf(const Message& message) const;
  ImageMessage ReadImage(const Message& message) const;
  Timestamp StampOf(const Message& message, Timestamp header) const;
  void Take(const Message& message);
  bool IsSettled(const RecordedFrame& frame) const;
  std::optional<RecordingEvent> TakeImu();

  std::unique_ptr<MessageSource> source_;
  std::filesystem::path path_;
  std::string name_;
  TopicChoice choice_;
  std::map<std::size_t, Role> roles_;
  std::map<std::size_t, bool> has_no_stamps_;
  std::optional<Calibration> calibration_;
  std::string calibration_problem_;
  std::vector<std::string> warnings_;
  Duration tolerance_;  ///< between the stamps of a pair
  int sample_bits_ = 16;
  Timestamp first_left_;
  ImuJoiner imu_;
  StereoPairer pairer_;
  std::optional<Timestamp> last_imu_;  ///< the newest one that was handed out
  Timestamp received_, frame_ready_;   ///< recorder's clock: newest message, since a frame waits
  bool is_ended_ = false, is_frame_waiting_ = false;
  std::string damage_;  ///< where reading ended too early; reported behind what came before
  int num_damaged_ = 0;
  std::string first_damaged_;
};

}  // namespace facet
