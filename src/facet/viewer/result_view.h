// SPDX-License-Identifier: BSD-2-Clause
// A result folder as the viewer shows it.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "facet/eval/ground_truth.h"
#include "facet/io/result_writer.h"
#include "facet/viewer/camera_images.h"
#include "facet/viewer/view_board.h"
#include "facet/viewer/view_server.h"

namespace facet {

/// The files of a result folder that every result has, and its meshes as GLB; also of one that is
/// not written yet. `source`: 0 or 1.
std::vector<ViewDownload> PlainDownloads(const std::filesystem::path& folder, int source);

/// The messages of one or two results, and the files of theirs that clients may save. With a
/// ground truth (may be null) the true trajectory is shown beside, and how far the surfaces are
/// from the true ones.
class ResultView {
 public:
  /// Throws InputError where a folder is no result, or a file of it is damaged.
  /// `camera`: JSON about the left camera (DescribeCamera); empty: not known, or that of `images`.
  /// `images`: those of the recording, which the page shows at their moments; may be null.
  ResultView(const std::vector<std::filesystem::path>& results,
             GroundTruth* truth,
             const std::string& camera = "",
             std::shared_ptr<const CameraImages> images = nullptr);

  void PostTo(ViewBoard& board) const;
  std::vector<ViewDownload> Downloads() const { return downloads_; }

 private:
  struct Message {
    std::string slot, bytes;
  };
  void AddResult(const std::filesystem::path& folder,
                 int source,
                 GroundTruth* truth,
                 nlohmann::ordered_json& description);
  void AddImages(const std::filesystem::path& folder,
                 int source,
                 std::span<const FrameRecord> frames,
                 nlohmann::ordered_json& description);
  void AddMeshes(const std::filesystem::path& folder,
                 int source,
                 nlohmann::ordered_json& description);

  std::shared_ptr<const CameraImages> images_;
  std::vector<Message> messages_;
  std::vector<ViewDownload> downloads_;
};

}  // namespace facet
