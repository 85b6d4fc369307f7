// SPDX-License-Identifier: BSD-2-Clause
// Damaged files of every kind: readers take them or complain. FACET_FUZZ_RUNS sets how many for
// each kind; `make test-long` runs the same readers under libFuzzer, which looks for new paths
// through them.
#include "facet/testing/io/reader_fuzz.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/testing/folders.h"
#include "facet/testing/fuzz_corpus.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

std::size_t Place(const std::string& text, Rng& rng) {
  return static_cast<std::size_t>(rng.Index(static_cast<int>(text.size()) + 1));
}

// One small damage: what happens to files on disks, in editors and in scripts that write them.
void Damage(std::string& text, Rng& rng) {
  static const char* const kWords[] = {"nan",       "-1", "1e999", "99999999999999999999",
                                       "",          ",",  "\n",    ": ",
                                       "[",         "{",  "\"",    "\t",
                                       "\xff\xfe",  "0",  "-",     "#",
                                       "%YAML:1.0", "- ", "&a",    "*a"};
  const std::size_t at = Place(text, rng);
  const std::size_t length =
      std::min(text.size() - at, static_cast<std::size_t>(1 + rng.Index(16)));
  switch (rng.Index(6)) {
    case 0:
      if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << rng.Index(8)));
      break;
    case 1:
      text.resize(at);
      break;
    case 2:
      text.erase(at, length);
      break;
    case 3:
      text.insert(at, std::string(text, at, length));
      break;
    case 4:
      text.replace(at, length, kWords[rng.Index(std::size(kWords))]);
      break;
    default:
      text.insert(at, std::string(1, static_cast<char>(rng.Index(256))));
      break;
  }
}

TEST(ReaderFuzzTest, GoodFilesAreTaken) {
  for (const FuzzedReader& reader : FuzzedReaders()) {
    if (reader.name == "camera") continue;  // needs its second camera, too
    for (std::size_t i = 0; i < reader.seeds.size(); ++i) {
      const TempFolder folder;
      EXPECT_TRUE(ReadsOrComplains(reader, folder.path(), reader.seeds[i]))
          << reader.name << " " << i;
    }
  }
}

TEST(ReaderFuzzTest, SavedInputs) {
  std::size_t num_inputs = 0;
  for (const FuzzedReader& reader : FuzzedReaders()) {
    const TempFolder folder;
    for (const testing::FuzzInput& input : testing::SavedFuzzInputs("readers", reader.name)) {
      ++num_inputs;
      EXPECT_NO_THROW(
          ReadsOrComplains(reader, folder.path(), std::string(input.begin(), input.end())))
          << reader.name << ": " << testing::ToHex(input);
    }
  }
  std::ifstream file(testing::SourceFolder() / "testdata" / "fuzz" / "readers.txt");
  std::size_t num_lines = 0;
  for (std::string line; std::getline(file, line);)
    num_lines += line.empty() || line.front() == '#' ? 0 : 1;
  EXPECT_GT(num_inputs, 100U);
  EXPECT_EQ(num_inputs, num_lines) << "was a reader renamed?";
}

TEST(ReaderFuzzTest, DamagedFilesAreTakenOrComplainedAbout) {
  const int num_runs = testing::NumFuzzRuns(1000);
  for (const FuzzedReader& reader : FuzzedReaders()) {
    const TempFolder folder;
    int num_rejected = 0;
    Rng rng(1);
    for (int run = 0; run < num_runs; ++run) {
      std::string text = reader.seeds[static_cast<std::size_t>(run) % reader.seeds.size()];
      for (int i = rng.Index(4); i >= 0; --i)
        Damage(text, rng);
      EXPECT_NO_THROW(num_rejected += ReadsOrComplains(reader, folder.path(), text) ? 0 : 1)
          << reader.name << ", run " << run << ":\n"
          << text;
    }
    EXPECT_GT(num_rejected, num_runs / 20) << reader.name << ": was anything damaged?";
  }
}

}  // namespace
}  // namespace facet
