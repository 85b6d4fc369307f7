// SPDX-License-Identifier: BSD-2-Clause
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds `facet simulate`; the program's arguments are written beside the sequence. The command
/// throws InputError, ConfigError, OutputError or RunEndedError.
void AddSimulateCommand(CLI::App& app, int argc, char** argv);

}  // namespace facet
