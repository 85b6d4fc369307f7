// SPDX-License-Identifier: BSD-2-Clause
#include "interrupts.h"

#include <csignal>

namespace facet {
namespace {

volatile std::sig_atomic_t interrupted = 0;

}  // namespace

void CatchInterrupts() {
  interrupted = 0;
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction before {};
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

void Interrupt() {
  interrupted = 1;
}

bool WasInterrupted() {
  return interrupted != 0;
}

}  // namespace facet
