// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

#include "facet/pipeline/vio_options.h"

namespace facet {

struct LoadedOptions {
  VioOptions options;
  std::vector<std::string> notices;  ///< of options of earlier versions, one line each
};

/// The built-in values, changed by a file (may be empty) and then by `key.path=value` texts. Throws
/// ConfigError.
LoadedOptions LoadOptions(const std::string& file, const std::vector<std::string>& overrides);

/// The parameters as YAML, with their meaning: all, or those that users turn.
std::string FormatOptions(VioOptions options, Audience audience = Audience::kExperts);

}  // namespace facet
