// SPDX-License-Identifier: BSD-2-Clause
#include "facet/testing/folders.h"

namespace facet::testing {

std::filesystem::path SourceFolder() {
  return FACET_SOURCE_DIR;
}

std::filesystem::path BuildFolder() {
  return FACET_BINARY_DIR;
}

}  // namespace facet::testing
