// SPDX-License-Identifier: BSD-2-Clause
// Ctrl-C, a polite kill and a terminal that is closed end a command in good order.
#pragma once

namespace facet {

/// From now on the first SIGINT, SIGTERM or SIGHUP is only noted; the second one of its kind kills
/// the program. A SIGHUP that was ignored (nohup) stays so.
void CatchInterrupts();

/// As if one of the signals had come.
void Interrupt();

/// Whether one came since then.
bool WasInterrupted();

}  // namespace facet
