// SPDX-License-Identifier: BSD-2-Clause
// A picture of a result without a display: what the viewer's page shows, for documents and demos.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <opencv2/core.hpp>

#include "facet/base/types.h"

namespace facet {

struct PictureOptions {
  std::string view = "outside";          ///< outside: from above one side; top: from above
  std::string colour = "plane";          ///< plane, normal, height, image
  std::string mesh = "map";              ///< map or horizon
  std::optional<Vector3d> from_W, to_W;  ///< both: the view from one point to the other
  int width = 1600, height = 1000;
  bool is_dark = false;
  bool has_trajectory = true, has_labels = true;
  bool has_back_sides = false;  ///< else one looks through surfaces from behind
};

/// RGB. Throws InputError where the folder is no result or has no such mesh.
cv::Mat DrawResult(const std::filesystem::path& result, const PictureOptions& options);

}  // namespace facet
