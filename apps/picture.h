// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

#include "facet/viewer/result_picture.h"

namespace facet {

/// What `facet picture` is told on the command line.
struct PictureArguments {
  std::string result, out;
  std::vector<double> from, to, size;
  PictureOptions options;
};

/// `facet picture`. Throws InputError, ConfigError or OutputError.
void PictureCommand(const PictureArguments& arguments);

}  // namespace facet
