// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/relative_error_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace facet {
namespace {

using nlohmann::ordered_json;
using ::testing::HasSubstr;

// Errors of `scale` times 1 % and 0.1 deg per metre.
ordered_json Rpe(double scale, const std::vector<double>& lengths_m) {
  ordered_json rpe = ordered_json::array();
  for (const double length_m : lengths_m) {
    rpe.push_back({{"length_m", length_m},
                   {"translation_median_m", scale * 0.01 * length_m},
                   {"rotation_median_deg", scale * 0.1 * length_m}});
  }
  return rpe;
}

ordered_json Combination(const std::string& name, ordered_json rpe) {
  return {{"name", name}, {"ate_median_m", 0.01}, {"ate_rmse_m", 0.02}, {"rpe", std::move(rpe)}};
}

TEST(RelativeErrorTablesTest, MedianOverTheStartsLengthByLength) {
  const std::vector<ordered_json> runs = {
      {{"rpe", Rpe(1, {1, 5})}}, {{"rpe", Rpe(4, {1})}}, {{"rpe", Rpe(2, {1, 5})}}, {{"ate", 3}}};
  const ordered_json rpe = MedianRelativeErrors(runs);
  ASSERT_EQ(rpe.size(), 2u);
  EXPECT_DOUBLE_EQ(rpe[0]["translation_median_m"].get<double>(), 0.02);
  EXPECT_EQ(rpe[0]["runs"], 3);
  EXPECT_DOUBLE_EQ(rpe[1]["rotation_median_deg"].get<double>(), 0.75);
  EXPECT_TRUE(MedianRelativeErrors({}).empty());
}

TEST(RelativeErrorTablesTest, GainsWithinEachConfiguration) {
  ordered_json better = Rpe(0.8, {1, 5});  // at 5 m half the error
  better[1]["translation_median_m"] = 0.025;
  const ordered_json combinations = {Combination("S-a", Rpe(2, {1, 5})),
                                     Combination("SP-a", Rpe(1, {1, 5, 10})),
                                     Combination("SPR-a", better),
                                     Combination("SPR-b", Rpe(1, {1})),
                                     {{"name", "SP-b"}}};
  const ordered_json gains = RelativeErrorGains(combinations);
  ASSERT_EQ(gains.size(), 2u);  // of b there is no SP with a result
  EXPECT_EQ(gains[0]["other"], "SPR-a");
  EXPECT_EQ(gains[0]["reference"], "SP-a");
  EXPECT_NEAR(gains[0]["translation_mean"].get<double>(), 0.35, 1e-12);
  EXPECT_NEAR(gains[0]["translation_best"].get<double>(), 0.5, 1e-12);
  EXPECT_NEAR(gains[0]["rotation_mean"].get<double>(), 0.2, 1e-12);
  EXPECT_EQ(gains[0]["lengths"], 2);
  EXPECT_EQ(gains[1]["reference"], "S-a");
  EXPECT_NEAR(gains[1]["rotation_mean"].get<double>(), 0.6, 1e-12);
}

TEST(RelativeErrorTablesTest, PaperBesideOurs) {
  ordered_json combinations = {Combination("SP", Rpe(1, {1, 5})),
                               Combination("SPR", Rpe(0.75, {1}))};
  ordered_json comparison;
  comparison["sequences"] = {
      {{"name", "V2_02_medium"}, {"combinations", combinations}, {"paired", {}}}};
  comparison["sequences"][0]["rpe_gains"] = RelativeErrorGains(combinations);
  const std::vector<Table> tables = RelativeErrorTables(comparison);
  ASSERT_EQ(tables.size(), 2u);
  const std::string errors = ToMarkdown(tables[0]), gains = ToMarkdown(tables[1]);
  EXPECT_THAT(errors,
              HasSubstr("| V2_02_medium | SP | 1.00 | 2.00 | 1.00 | 5.00 | 0.100 | 0.500 |"));
  EXPECT_THAT(errors, HasSubstr("| V2_02_medium | SPR | 1.00 | 2.00 | 0.75 | - | 0.075 | - |"));
  EXPECT_THAT(gains, HasSubstr("| V2_02_medium | SPR / SP | +25.0 | +25.0 | +25.0 | +25.0 | 1 |"));
  EXPECT_THAT(gains, HasSubstr("| V2_02 (paper) | SPR / SP | +20 | +50 | +15 | +30 | - |"));
}

TEST(RelativeErrorTablesTest, NothingWithoutRelativeErrors) {
  const ordered_json comparison = {
      {"sequences", {{{"name", "a"}, {"combinations", {{{"name", "S"}}}}}}}};
  EXPECT_TRUE(RelativeErrorTables(comparison).empty());
}

}  // namespace
}  // namespace facet
