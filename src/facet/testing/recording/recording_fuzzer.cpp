// SPDX-License-Identifier: BSD-2-Clause
// Bags under libFuzzer (clang and FACET_FUZZER=ON; scripts/test_long.sh).
#include <cstdint>
#include <string>

#include "facet/testing/fuzz_corpus.h"
#include "facet/testing/io/test_sequence.h"
#include "facet/testing/recording/recording_fuzz.h"

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments) {
  std::vector<facet::testing::FuzzInput> seeds = facet::testing::SavedFuzzInputs("recording");
  for (const std::string& seed : facet::RecordingSeeds())
    seeds.emplace_back(seed.begin(), seed.end());
  facet::testing::WriteSeedsIfAsked(*num_arguments, *arguments, seeds);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const facet::TempFolder folder;
  facet::ReadsRecordingOrComplains(folder.path(),
                                   std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
