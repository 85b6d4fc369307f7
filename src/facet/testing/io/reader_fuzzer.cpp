// SPDX-License-Identifier: BSD-2-Clause
// The readers under libFuzzer: the first byte chooses the reader, the rest is its file. With the
// one argument
// --write-seeds=FOLDER it writes the good files to begin with instead (clang and FACET_FUZZER=ON;
// scripts/test_long.sh).
#include <cstdint>
#include <cstdlib>
#include <string>

#include "facet/testing/io/reader_fuzz.h"
#include "facet/testing/io/test_sequence.h"

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments) {
  const std::string option = "--write-seeds=";
  for (int i = 1; i < *num_arguments; ++i) {
    const std::string argument = (*arguments)[i];
    if (!argument.starts_with(option)) continue;
    const std::filesystem::path folder = argument.substr(option.size());
    const std::vector<facet::FuzzedReader> readers = facet::FuzzedReaders();
    for (std::size_t r = 0; r < readers.size(); ++r) {
      for (std::size_t s = 0; s < readers[r].seeds.size(); ++s)
        facet::WriteText(folder / (std::to_string(r) + "-" + std::to_string(s)),
                         static_cast<char>(r) + readers[r].seeds[s]);
    }
    std::exit(0);  // NOLINT(concurrency-mt-unsafe)
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<facet::FuzzedReader> readers = facet::FuzzedReaders();
  static const facet::TempFolder folder;
  if (size == 0) return 0;
  const facet::FuzzedReader& reader = readers[data[0] % readers.size()];
  facet::ReadsOrComplains(
      reader, folder.path(), std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  return 0;
}
