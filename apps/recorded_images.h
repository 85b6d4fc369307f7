// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "facet/viewer/camera_images.h"

namespace facet {

/// The left images of a recording of image files, which are read when they are asked for. Throws
/// InputError where it cannot be read, has no calibration, or is a bag, whose images lie too deep
/// to be looked at out of order.
std::shared_ptr<CameraImages> OpenRecordedImages(const std::filesystem::path& recording);

}  // namespace facet
