// SPDX-License-Identifier: BSD-2-Clause
// The viewer's page with its data inside: one text that needs no server.
#pragma once

#include <string>

#include "facet/viewer/result_view.h"

namespace facet {

/// HTML with scripts, style and all messages; downloads and meshes of other moments are not in it.
std::string StandalonePage(const ResultView& view);

}  // namespace facet
