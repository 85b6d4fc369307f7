// SPDX-License-Identifier: BSD-2-Clause
// Finds out what kind of recording a path is, and opens it.
#pragma once

#include <filesystem>
#include <memory>

#include "facet/recording/message_source.h"
#include "facet/recording/recording.h"
#include "facet/recording/topic_choice.h"

namespace facet {

struct RecordingOptions {
  CalibrationFiles calibration;
  TopicNames topics;  ///< of a bag
  /// Whether a recording without a calibration is refused.
  bool needs_calibration = true;
};

/// The layouts of folders with image files.
enum class FolderKind {
  kAsl,    ///< ASL, EuRoC, TUM-VI (asl_dataset.h)
  kKitti,  ///< kitti_raw.h
  kPlain,  ///< plain_folder.h
  kOther,
};
FolderKind KindOfFolder(const std::filesystem::path& path);

/// `path` is a folder with images in one of these layouts, a ROS 1 bag, an MCAP file, a ROS 2
/// database (.db3), or a folder with several of these files: a ROS 2 bag with metadata.yaml, or the
/// parts of one recording in the order of their names. Files are told by their content, not by
/// their extension.
///
/// Throws InputError, naming what was expected, for anything else and for what cannot be used;
/// ConfigError where a choice of topics is needed, or is given for a folder that has none.
std::unique_ptr<Recording> OpenRecording(const std::filesystem::path& path,
                                         const RecordingOptions& options = {});

/// The messages of a bag, split or not; null for a recording that is no bag.
std::unique_ptr<MessageSource> OpenMessages(const std::filesystem::path& path);

}  // namespace facet
