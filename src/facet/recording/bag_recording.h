// SPDX-License-Identifier: BSD-2-Clause
// The messages of a bag as a stream of IMU samples and stereo pairs.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>

#include "facet/io/stray_stamps.h"
#include "facet/recording/bag_opening.h"
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
/// Single stamps far away from those around them are left out (io/stray_stamps.h). In memory are
/// what waits for its partner, at most two seconds or 256 MB, and what the source keeps.
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
  StampCounts ImagesLeftOut() const override { return pairer_.left_out(); }
  StampCounts ImuLeftOut() const override { return imu_.left_out(); }

 private:
  struct StampedImage {
    Timestamp t, received;
    std::shared_ptr<const EncodedImage> image;
    std::size_t num_bytes = 0;
  };

  void FindCalibrationOf(const BagOpening& opening, const BagOptions& options);
  void RequireReadablePair();
  std::string PlaceOf(const Message& message) const;
  Timestamp StampOf(const Message& message, Timestamp header) const;
  void Take(const Message& message);
  void TakeImage(const Message& message, int camera);
  void TakeImuMessage(const Message& message);
  void PassImage(int camera, const StampedImage& image);
  void PassReading(std::size_t topic, const ImuSample& reading);
  void End();
  bool IsSettled(const RecordedFrame& frame) const;
  std::optional<RecordingEvent> TakeImu();

  std::unique_ptr<MessageSource> source_;
  std::filesystem::path path_;
  std::string name_;
  TopicChoice choice_;
  BagStamps stamps_;
  std::optional<Calibration> calibration_;
  std::vector<std::string> warnings_;
  int sample_bits_ = 16;
  std::array<StrayStamps<StampedImage>, 2> images_{StrayStamps<StampedImage>(kImagesToConfirm),
                                                   StrayStamps<StampedImage>(kImagesToConfirm)};
  std::map<std::size_t, StrayStamps<ImuSample>> readings_;  ///< by topic
  int num_stray_images_ = 0, num_stray_imu_ = 0;
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
