// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <vector>

#include "facet/pipeline/vio_options.h"

namespace facet {

/// The built-in values, changed by a file (may be empty) and then by `key.path=value` texts. Throws
/// ConfigError.
VioOptions LoadOptions(const std::string& file, const std::vector<std::string>& overrides);

/// Every parameter as YAML, with its meaning.
std::string FormatOptions(VioOptions options);

}  // namespace facet
