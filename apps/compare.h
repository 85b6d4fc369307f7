// SPDX-License-Identifier: BSD-2-Clause
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds `facet compare`. The command throws InputError, ConfigError, OutputError or RunEndedError.
void AddCompareCommand(CLI::App& app);

}  // namespace facet
