// SPDX-License-Identifier: BSD-2-Clause
#include "facet/recording/decompression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/recording/test_bags.h"

namespace facet {
namespace {

class DecompressionTest : public ::testing::TestWithParam<Compression> {
 protected:
  std::string Run(const std::string& compressed, std::uint64_t size) {
    const std::vector<std::uint8_t> data(compressed.begin(), compressed.end());
    const auto out = Decompress(GetParam(), data, size, buffer_);
    return {out.begin(), out.end()};
  }
  std::vector<std::uint8_t> buffer_;
};

TEST_P(DecompressionTest, GivesWhatWasCompressed) {
  std::string text;
  for (long i = 0; i < 60000; ++i)
    text += std::to_string(i * i);
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, text.size()}) {
    EXPECT_EQ(Run(Compressed(GetParam(), text.substr(0, size)), size), text.substr(0, size));
  }
  const std::string same(3 << 20, 'x');  // grows to a thousand times its size
  EXPECT_EQ(Run(Compressed(GetParam(), same), same.size()), same);
}

TEST_P(DecompressionTest, OtherSizesThanAnnouncedAreErrors) {
  const std::string text(1000, 'x');
  const std::string compressed = Compressed(GetParam(), text);
  EXPECT_THROW(Run(compressed, 999), InputError);
  EXPECT_THROW(Run(compressed, 1001), InputError);
  EXPECT_THROW(Run(compressed, 0), InputError);
  EXPECT_THROW(Run(compressed.substr(0, compressed.size() / 2), 1000), InputError);
  EXPECT_THROW(Run("no such data at all", 1000), InputError);
  EXPECT_THROW(Run("", 1000), InputError);
}

TEST_P(DecompressionTest, AnAbsurdSizeTakesNoMemory) {
  for (const std::uint64_t size : {1ULL << 30, 1ULL << 50})
    EXPECT_THROW(Run(Compressed(GetParam(), std::string(1000, 'x')), size), InputError);
  EXPECT_LE(buffer_.size(), 1u << 20);
}

INSTANTIATE_TEST_SUITE_P(Kinds,
                         DecompressionTest,
                         ::testing::Values(Compression::kLz4,
                                           Compression::kBz2,
                                           Compression::kZstd));

}  // namespace
}  // namespace facet
