// SPDX-License-Identifier: BSD-2-Clause
// The files of viewer/dist as the build put them into the program (cmake/embed_page.cmake).
#pragma once

#include <span>
#include <string_view>

namespace facet {

struct PageAsset {
  std::string_view path;  ///< "/" for the page itself
  std::string_view type;  ///< for the header Content-Type
  std::string_view bytes;
};

std::span<const PageAsset> PageAssets();

}  // namespace facet
