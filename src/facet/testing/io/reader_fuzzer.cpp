// SPDX-License-Identifier: BSD-2-Clause
// The readers under libFuzzer: the first byte chooses the reader, the rest is its file. With
// --only=NAME,NAME it chooses among these readers of FuzzedReaders, with '_' for the blanks in
// their names: libFuzzer's -merge starts itself without quotes (clang and FACET_FUZZER=ON;
// scripts/test_long.sh).
#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "facet/testing/fuzz_corpus.h"
#include "facet/testing/io/reader_fuzz.h"
#include "facet/testing/io/test_sequence.h"

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::vector<facet::FuzzedReader>& Readers() {
  static std::vector<facet::FuzzedReader> readers = facet::FuzzedReaders();
  return readers;
}

void KeepOnly(const std::string& names) {
  std::vector<facet::FuzzedReader> kept;
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) {
    std::replace(name.begin(), name.end(), '_', ' ');
    const auto reader = std::ranges::find(Readers(), name, &facet::FuzzedReader::name);
    if (reader == Readers().end())
      facet::testing::AbortOnProblem("--only: there is no reader '" + name + "'");
    kept.push_back(*reader);
  }
  if (!kept.empty()) Readers() = kept;
}

void Append(std::vector<facet::testing::FuzzInput>& seeds,
            std::size_t reader,
            const auto& content) {
  facet::testing::FuzzInput& seed = seeds.emplace_back();
  seed.push_back(static_cast<std::uint8_t>(reader));
  seed.insert(seed.end(), content.begin(), content.end());
}

std::vector<facet::testing::FuzzInput> Seeds() {
  std::vector<facet::testing::FuzzInput> seeds;
  for (std::size_t r = 0; r < Readers().size(); ++r) {
    for (const std::string& content : Readers()[r].seeds)
      Append(seeds, r, content);
    for (const auto& input : facet::testing::SavedFuzzInputs("readers", Readers()[r].name))
      Append(seeds, r, input);
  }
  return seeds;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments) {
  KeepOnly(facet::testing::ArgumentValue(*num_arguments, *arguments, "only"));
  facet::testing::WriteSeedsIfAsked(*num_arguments, *arguments, Seeds());
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const facet::TempFolder folder;
  if (size == 0) return 0;
  const facet::FuzzedReader& reader = Readers()[data[0] % Readers().size()];
  facet::ReadsOrComplains(
      reader, folder.path(), std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  return 0;
}
