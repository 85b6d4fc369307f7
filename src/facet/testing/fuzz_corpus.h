// SPDX-License-Identifier: BSD-2-Clause
// For fuzzing: inputs that are kept in testdata/fuzz, and small changes of them for tests that run
// without a fuzzer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "facet/base/random.h"

namespace facet::testing {

using FuzzInput = std::vector<std::uint8_t>;

/// The inputs of the file of that name in testdata/fuzz, one a line in hexadecimal digits; lines
/// that begin with '#' are comments. Throws std::runtime_error where the file is missing or holds
/// anything else. scripts/keep_fuzz_inputs.py writes such files.
std::vector<FuzzInput> SavedFuzzInputs(const std::string& name);

/// The same of a file that serves several readers: each line has a reader's name, a tabulator and
/// an input; those of this reader.
std::vector<FuzzInput> SavedFuzzInputs(const std::string& name, const std::string& reader);

/// As a line of such a file.
std::string ToHex(const FuzzInput& input);

/// How many runs a test without a fuzzer takes: FACET_FUZZ_RUNS, or this many. CHECKs that it is a
/// positive number.
int NumFuzzRuns(int usual);

/// A few bytes changed, left out, repeated or added.
FuzzInput Damaged(FuzzInput input, Rng& rng);

/// For LLVMFuzzerInitialize. With the argument --write-seeds=FOLDER writes the inputs into that
/// folder, which must exist, one a file, and ends the program.
void WriteSeedsIfAsked(int num_arguments,
                       const char* const* arguments,
                       const std::vector<FuzzInput>& inputs);

/// The value of the argument --NAME=VALUE; empty if it is not there.
std::string ArgumentValue(int num_arguments, const char* const* arguments, const std::string& name);

/// For LLVMFuzzerTestOneInput. Ends the program as a crash if there is a problem.
void AbortOnProblem(const std::string& problem);

}  // namespace facet::testing
