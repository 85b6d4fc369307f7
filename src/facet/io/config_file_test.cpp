// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/config_file.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct InnerOptions {
  int levels = 4;
  double sigma = 0.1;
  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("levels", levels, Range{1, 8}, "pyramid levels");
    v.Field("sigma", sigma, Range{1e-9, 10}, "noise [px]");
  }
};

struct OuterOptions {
  bool enabled = true;
  int max_features = 160;
  double unlimited = 1e-300;
  std::string name = "plain";
  std::string simd = "auto";
  InnerOptions klt;
  double after = 2;
  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, {}, "on or off");
    v.Field("max_features", max_features, {1, 5000}, "tracks");
    v.Field("unlimited", unlimited, "any number");
    v.Field("name", name, Range{}, "any text");
    v.Choice("simd", simd, {"auto", "avx2"}, "instruction set");
    v.Group("klt", klt);
    v.Field("after", after, {0, std::numeric_limits<double>::infinity()}, "behind a group");
  }
};

OuterOptions Apply(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  TempFolder folder;
  WriteText(folder / "c.yaml", yaml);
  OuterOptions options;
  const auto fields = ListFields(options);
  ApplyConfig(ReadConfigFile(folder / "c.yaml"), fields);
  for (const std::string& text : overrides)
    ApplyConfig({{ParseOverride(text)}}, fields);
  return options;
}

std::string ErrorOf(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
  try {
    Apply(yaml, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ConfigFileTest, AppliesASubsetAndThenOverrides) {
  const OuterOptions o =
      Apply("%YAML:1.0\n# note\nenabled: false\nklt:\n  levels: 3\n  sigma: 2.5e-1\n",
            {"klt.levels=5", "name = two words", "unlimited=-.inf", "simd=avx2"});
  EXPECT_FALSE(o.enabled);
  EXPECT_EQ(o.klt.levels, 5);
  EXPECT_EQ(o.klt.sigma, 0.25);
  EXPECT_EQ(o.max_features, 160);
  EXPECT_EQ(o.name, "two words");
  EXPECT_EQ(o.simd, "avx2");
  EXPECT_TRUE(std::isinf(o.unlimited));
}

TEST(ConfigFileTest, EmptyFileChangesNothing) {
  EXPECT_EQ(Apply("").max_features, 160);
  EXPECT_EQ(Apply("# nothing\n").max_features, 160);
}

TEST(ConfigFileTest, WrittenFileReadsBackExactly) {
  OuterOptions options;
  options.klt.sigma = 0.1 + 0.2;
  options.unlimited = std::nextafter(1e22, 2e22);
  options.after = std::numeric_limits<double>::infinity();
  options.name = "a \"quoted\" \\ text: # with, [signs]";
  options.enabled = false;
  const std::string text = FormatConfig(ListFields(options));
  OuterOptions back = Apply(text);
  EXPECT_EQ(back.klt.sigma, options.klt.sigma);
  EXPECT_EQ(back.unlimited, options.unlimited);
  EXPECT_EQ(back.after, options.after);
  EXPECT_EQ(back.name, options.name);
  EXPECT_EQ(back.enabled, options.enabled);
  EXPECT_EQ(FormatConfig(ListFields(back)), text);
}

TEST(ConfigFileTest, WritesMeaningAndRange) {
  OuterOptions options;
  const std::string text = FormatConfig(ListFields(options));
  EXPECT_THAT(text, HasSubstr("enabled: true  # on or off\n"));
  EXPECT_THAT(text, HasSubstr("max_features: 160  # tracks [1 .. 5000]\n"));
  EXPECT_THAT(text, HasSubstr("simd: \"auto\"  # instruction set [auto | avx2]\n"));
  EXPECT_THAT(text, HasSubstr("klt:\n  levels: 4  # pyramid levels [1 .. 8]\n"));
  EXPECT_THAT(text, HasSubstr("\nafter: 2  # behind a group [>= 0]\n"));
}

TEST(ConfigFileTest, UnknownKeysAreErrorsWithASuggestion) {
  EXPECT_THAT(ErrorOf("enabled: true\nklt:\n  level: 3\n"),
              AllOf(HasSubstr("c.yaml:3: unknown key 'klt.level'"), HasSubstr("'klt.levels'?")));
  EXPECT_THAT(ErrorOf("sigma: 3\n"), HasSubstr("did you mean 'klt.sigma'?"));
  EXPECT_THAT(ErrorOf("klt: 3\n"), HasSubstr("it is a group"));
  EXPECT_THAT(ErrorOf("completely_different_thing: 3\n"), HasSubstr("facet config"));
  EXPECT_THAT(ErrorOf("", {"max_feature=3"}),
              AllOf(HasSubstr("--set: unknown key 'max_feature'"), HasSubstr("'max_features'?")));
}

TEST(ConfigFileTest, SuggestionsKnowRetiredKeys) {
  OuterOptions options;
  const RetiredOption retired[] = {{"klt.window_px", "4", ""}, {"max_points", "3", "max_features"}};
  const auto error_of = [&](const std::string& text) -> std::string {
    try {
      ApplyOverrides(std::vector{text}, ListFields(options), retired);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_of("klt.windw_px=4"),
              HasSubstr("did you mean 'klt.window_px', which is no option any more?"));
  EXPECT_THAT(error_of("max_point=4"),
              HasSubstr("did you mean 'max_points', which is now called 'max_features'?"));
  EXPECT_THAT(error_of("max_feature=4"), HasSubstr("did you mean 'max_features'?"));
}

TEST(ConfigFileTest, ValuesMustBeOfTheTypeAndInRange) {
  EXPECT_THAT(ErrorOf("\nmax_features: 0\n"),
              AllOf(HasSubstr("c.yaml:2: max_features = '0' is out of range, allowed: 1 .. 5000")));
  EXPECT_THAT(ErrorOf("max_features: 3.5\n"), HasSubstr("must be an integer, allowed: 1 .. 5000"));
  EXPECT_THAT(ErrorOf("max_features: many\n"), HasSubstr("must be an integer"));
  EXPECT_THAT(ErrorOf("max_features: 99999999999\n"), HasSubstr("out of range"));
  EXPECT_THAT(ErrorOf("enabled: maybe\n"), HasSubstr("must be true or false"));
  EXPECT_THAT(ErrorOf("klt: {sigma: nan}\n"), HasSubstr("must be a number"));
  EXPECT_THAT(ErrorOf("klt: {sigma: .nan}\n"), HasSubstr("must be a number"));
  EXPECT_THAT(ErrorOf("klt: {sigma: .inf}\n"), HasSubstr("out of range, allowed: 1e-09 .. 10"));
  EXPECT_THAT(ErrorOf("simd: avx512\n"), HasSubstr("not one of these, allowed: auto | avx2"));
  EXPECT_THAT(ErrorOf("after: -1\n"), HasSubstr("allowed: >= 0"));
}

TEST(ConfigFileTest, BadSyntaxNamesTheLine) {
  EXPECT_THAT(ErrorOf("enabled: true\n  bad: [\n"), HasSubstr("c.yaml:2: not valid YAML"));
  EXPECT_THAT(ErrorOf("just text\n"), HasSubstr("c.yaml:1:"));
  EXPECT_THAT(ErrorOf("enabled:\n"), HasSubstr("c.yaml:1: 'enabled' has no value"));
  EXPECT_THAT(ErrorOf("enabled: [true]\n"), HasSubstr("is a list"));
  EXPECT_THAT(ErrorOf("enabled: true\nenabled: false\n"),
              HasSubstr("c.yaml:2: 'enabled' appears twice"));
  EXPECT_THROW(ReadConfigFile("/nonexistent.yaml"), ConfigError);
  EXPECT_THROW(ParseOverride("no_equals_sign"), ConfigError);
  EXPECT_THROW(ParseOverride(" =3"), ConfigError);
}

}  // namespace
}  // namespace facet
