// SPDX-License-Identifier: BSD-2-Clause
// `facet picture`: a result as an image file, without a display.
#include "picture.h"

#include "facet/io/errors.h"
#include "facet/io/png_writer.h"

namespace facet {
namespace {

Vector3d PointOf(const std::vector<double>& numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace

void PictureCommand(const PictureArguments& arguments) {
  PictureOptions options = arguments.options;
  if (arguments.from.empty() != arguments.to.empty())
    throw ConfigError("--from and --to: one needs the other");
  if (!arguments.from.empty()) {
    options.from_W = PointOf(arguments.from);
    options.to_W = PointOf(arguments.to);
    constexpr double kFarthest_m = 1e7;
    for (const Vector3d& p : {*options.from_W, *options.to_W}) {
      if (!p.allFinite() || !(p.cwiseAbs().maxCoeff() <= kFarthest_m))
        throw ConfigError("--from and --to: numbers up to 1e7 m are expected");
    }
    if (*options.from_W == *options.to_W) throw ConfigError("--from and --to: are the same point");
  }
  if (!arguments.size.empty()) {
    options.width = static_cast<int>(arguments.size[0]);
    options.height = static_cast<int>(arguments.size[1]);
  }
  WritePng(arguments.out, DrawResult(arguments.result, options));
}

}  // namespace facet
