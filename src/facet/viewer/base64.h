// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <string>
#include <string_view>

namespace facet {

/// RFC 4648, with padding.
std::string Base64(std::string_view bytes);

}  // namespace facet
