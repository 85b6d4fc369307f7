// SPDX-License-Identifier: BSD-2-Clause
// Damaged bags of every kind: they are read or complained about. FACET_FUZZ_RUNS sets how many;
// `make test-long` runs the same under libFuzzer and the sanitizers.
#include "facet/testing/recording/recording_fuzz.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "facet/testing/fuzz_corpus.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

// The address sanitizer keeps what was freed for a while.
#if defined(__SANITIZE_ADDRESS__)  // GCC
#define FACET_HAS_QUARANTINE
#elif defined(__has_feature)  // clang
#if __has_feature(address_sanitizer)
#define FACET_HAS_QUARANTINE
#endif
#endif
#ifdef FACET_HAS_QUARANTINE
constexpr double kQuarantineMb = 256;
#else
constexpr double kQuarantineMb = 0;
#endif

double PeakMemoryMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// Numbers that are absurd as sizes and offsets go where such numbers may be.
void PlantNumber(std::string& bytes, Rng& rng) {
  static const std::uint64_t kNumbers[] = {
      0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 0x7FFFFFFFFFFFFFFF, 0xFFFFFFFFFFFFFFFF, 1ULL << 40};
  const std::uint64_t number = kNumbers[rng.Index(std::size(kNumbers))];
  const std::size_t size = rng.Index(2) == 0 ? 4 : 8;
  if (bytes.size() < size) return;
  const auto at = static_cast<std::size_t>(rng.Index(static_cast<int>(bytes.size() - size + 1)));
  bytes.replace(at, size, reinterpret_cast<const char*>(&number), size);
}

std::string Damage(const std::string& good, Rng& rng) {
  if (rng.Index(3) == 0) {
    std::string bytes = good;
    PlantNumber(bytes, rng);
    return bytes;
  }
  const testing::FuzzInput damaged =
      testing::Damaged(testing::FuzzInput(good.begin(), good.end()), rng);
  return {damaged.begin(), damaged.end()};
}

TEST(RecordingFuzzTest, GoodRecordingsAreRead) {
  const std::vector<std::string> seeds = RecordingSeeds();
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const TempFolder folder;
    EXPECT_TRUE(ReadsRecordingOrComplains(folder.path(), seeds[i])) << i;
  }
}

TEST(RecordingFuzzTest, SavedInputs) {
  const std::vector<testing::FuzzInput> inputs = testing::SavedFuzzInputs("recording");
  EXPECT_FALSE(inputs.empty());
  const TempFolder folder;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const std::string bytes(inputs[i].begin(), inputs[i].end());
    EXPECT_NO_THROW(ReadsRecordingOrComplains(folder.path(), bytes)) << "input " << i;
  }
}

TEST(RecordingFuzzTest, DamagedRecordingsAreReadOrComplainedAbout) {
  const int num_runs = testing::NumFuzzRuns(3000);
  const std::vector<std::string> seeds = RecordingSeeds();
  const TempFolder folder;
  const double before_mb = PeakMemoryMb();
  int num_rejected = 0;
  Rng rng(1);
  for (int run = 0; run < num_runs; ++run) {
    const std::size_t seed = static_cast<std::size_t>(run) % seeds.size();
    std::string bytes = seeds[seed];
    for (int i = rng.Index(3); i >= 0; --i)
      bytes = Damage(bytes, rng);
    EXPECT_NO_THROW(num_rejected += ReadsRecordingOrComplains(folder.path(), bytes) ? 0 : 1)
        << "seed " << seed << ", run " << run;
  }
  EXPECT_GT(num_rejected, num_runs / 10) << "was anything damaged?";
  // The files are some 10 kB.
  EXPECT_LT(PeakMemoryMb() - before_mb, 64 + kQuarantineMb);
}

TEST(RecordingFuzzTest, EveryTruncationIsReadOrComplainedAbout) {
  const TempFolder folder;
  for (const std::string& seed : RecordingSeeds()) {
    for (std::size_t size = 0; size < seed.size();
         size += std::max<std::size_t>(1, seed.size() / 60))
      EXPECT_NO_THROW(ReadsRecordingOrComplains(folder.path(), seed.substr(0, size))) << size;
  }
}

}  // namespace
}  // namespace facet
