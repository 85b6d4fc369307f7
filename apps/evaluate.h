// SPDX-License-Identifier: BSD-2-Clause
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds `facet evaluate`. The command throws InputError, ConfigError or OutputError.
void AddEvaluateCommand(CLI::App& app);

}  // namespace facet
