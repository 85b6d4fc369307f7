// SPDX-License-Identifier: BSD-2-Clause
// What the first seconds of a bag show, before it is read as a stream.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "facet/messages/ros_calibration.h"
#include "facet/recording/message_source.h"
#include "facet/recording/topic_choice.h"

namespace facet {

struct BagOpening {
  struct Stamps {
    Timestamp header, received;
  };
  std::vector<Stamps> left, right, imu;  ///< none empty; of the gyroscope where it is alone
  RosCalibrationMessages calibration;
  std::uint16_t largest_sample = 0;  ///< of ten images with 16 bits; 0: they have 8
};

/// Reads from the beginning to three seconds behind the first left image; damage behind the first
/// messages ends it earlier. `place` is for messages. Throws InputError where a topic has no usable
/// message.
BagOpening ReadBagOpening(MessageSource& source,
                          const TopicChoice& choice,
                          const std::string& place);

/// How the stamps of a bag are to be understood.
struct BagStamps {
  std::set<std::size_t> topics_without;  ///< whose headers have none: the recorder's serve
  Duration tolerance;                    ///< between the stamps of a pair
  Timestamp first_left;
  std::vector<std::string> warnings;
};

/// Throws InputError where cameras and IMU have different clocks.
BagStamps JudgeStamps(const BagOpening& opening,
                      const TopicChoice& choice,
                      const std::vector<Topic>& topics,
                      const std::string& place);

}  // namespace facet
