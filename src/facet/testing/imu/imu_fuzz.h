// SPDX-License-Identifier: BSD-2-Clause
// For fuzzing: a stream of IMU samples that bytes make up, through the buffer, its screen and the
// integration.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace facet::testing {

/// Feeds the samples, cuts intervals out of them and integrates these. Returns which promise was
/// broken, or an empty text. Exceptions are let through: nothing may throw.
std::string FuzzImu(std::span<const std::uint8_t> bytes);

/// Bytes to begin with: a quiet stream, and streams with one kind of damage.
std::vector<std::vector<std::uint8_t>> ImuFuzzSeeds();

}  // namespace facet::testing
