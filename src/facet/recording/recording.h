// SPDX-License-Identifier: BSD-2-Clause
// A stereo-inertial recording as a stream, whatever kind of files it lies in. OpenRecording
// (open_recording.h) finds out which kind that is.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/imu/imu_types.h"
#include "facet/io/calibration_file.h"
#include "facet/io/stamp_counts.h"
#include "facet/messages/encoded_image.h"

namespace facet {

/// One left image and the right image of the same moment, not decoded yet.
struct RecordedFrame {
  Timestamp t;                                ///< of the left image, camera clock
  Timestamp t_right;                          ///< of the right image, if there is one
  std::shared_ptr<const EncodedImage> left;   ///< never null
  std::shared_ptr<const EncodedImage> right;  ///< null: a mono frame
  bool HasRight() const { return right != nullptr; }
};

/// The stamps of IMU samples are those of the IMU's clock: t_imu = t_camera + rig.time_offset.
using RecordingEvent = std::variant<ImuSample, RecordedFrame>;

/// Reads IMU samples and stereo pairs in the order in which they are needed, and keeps no more of
/// the recording in memory than this order takes. Not thread-safe.
///
/// Stamps of IMU samples and stamps of frames each rise strictly. The first frame has both images.
/// A frame comes after the IMU samples up to its stamp (plus the time offset) and one more, unless
/// the IMU has none there.
class Recording {
 public:
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  virtual ~Recording() = default;

  /// Without folder and extension, for example MH_01_easy.
  virtual const std::string& name() const = 0;

  /// From the files that were given, or else from the recording; null if neither has one.
  virtual const Calibration* calibration() const = 0;

  /// The next IMU sample or frame, empty at the end. Throws InputError with file and place where
  /// the recording is damaged; what came before is good.
  virtual std::optional<RecordingEvent> Next() = 0;

  /// Back to the first event.
  virtual void Rewind() = 0;

  /// How many frames there are from one stamp to another, both included: exact for folders, about
  /// right for bags.
  virtual int NumFrames(Timestamp from, Timestamp to) const = 0;

  /// What is odd about the recording, but does not keep it from being used. More may be found while
  /// it is read.
  virtual std::vector<std::string> Warnings() const = 0;

  /// What was left out so far because of its stamp: images of both cameras, IMU samples.
  virtual StampCounts ImagesLeftOut() const = 0;
  virtual StampCounts ImuLeftOut() const = 0;

 protected:
  Recording() = default;
};

}  // namespace facet
