// SPDX-License-Identifier: BSD-2-Clause
// For fuzzing: a simulated recording that bytes spoil, frame by frame, through the estimator.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace facet::testing {

/// Runs the estimator over as many frames as the bytes ask for, each clean or spoilt. Returns which
/// promise was broken, or an empty text. Exceptions are let through: nothing may throw.
std::string FuzzEstimator(std::span<const std::uint8_t> bytes);

/// Bytes to begin with: a clean run, and runs with one kind of damage in the middle.
std::vector<std::vector<std::uint8_t>> EstimatorFuzzSeeds();

}  // namespace facet::testing
