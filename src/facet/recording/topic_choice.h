// SPDX-License-Identifier: BSD-2-Clause
// Which topics of a bag are the two cameras and the IMU.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/recording/message_source.h"

namespace facet {

/// Names that the user gives; empty ones are found by type and name.
struct TopicNames {
  std::string left, right;
  std::string imu;          ///< gyroscope and accelerometer in one message
  std::string gyro, accel;  ///< or each on its own topic
};

/// From "left=/a", "right=/b", ...; throws ConfigError for anything else.
TopicNames ParseTopics(const std::vector<std::string>& texts);

/// Indices of topics. Either `imu`, or `gyro` and `accel`.
struct TopicChoice {
  std::size_t left = 0, right = 0;
  std::optional<std::size_t> imu, gyro, accel;
  std::optional<std::size_t> left_info, right_info;         ///< camera_info beside the images
  std::size_t rates() const { return imu ? *imu : *gyro; }  ///< the topic with angular rates
};

/// Images: the only two topics with images, or the only two whose names differ as left and right
/// do (left/right, cam0/cam1, infra1/infra2, ...); raw images before the same ones compressed. IMU:
/// the only topic of that type, or one with gyro and one with accel in its name.
///
/// Throws ConfigError with a listing of what there is and what to type where that leaves a choice,
/// and for a name that is not in the bag; InputError where the bag lacks a camera or the IMU.
/// `place` is for the messages.
TopicChoice ChooseTopics(const std::vector<Topic>& topics,
                         const TopicNames& names,
                         const std::string& place);

}  // namespace facet
