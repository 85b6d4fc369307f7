// SPDX-License-Identifier: BSD-2-Clause
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds `facet config`. The command throws ConfigError or OutputError.
void AddConfigCommand(CLI::App& app);

}  // namespace facet
