// SPDX-License-Identifier: BSD-2-Clause
#include <cstdlib>
#include <fstream>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/geometry/so3.h"
#include "facet/io/errors.h"
#include "facet/report/comparison.h"
#include "facet/report/figures.h"
#include "facet/report/paper_tables.h"
#include "facet/report/report_page.h"
#include "facet/report/svg_plot.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<PosePair> NoisyPairs(double sigma_m, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<PosePair> pairs;
  for (int i = 0; i < 400; ++i) {
    const double t = 0.05 * i;
    const SE3 truth(ExpSO3({0, 0, 0.3 * t}), {3 * std::cos(t), 3 * std::sin(t), 0.2 * t});
    pairs.push_back({Timestamp{1'000'000'000 + FromSeconds(t).ns},
                     truth.Retract(0.01 * rng.Normal3(), sigma_m * rng.Normal3()),
                     truth});
  }
  return pairs;
}

// A run folder with everything that a report reads, judged against a truth file.
RunEvaluation MakeRun(const fs::path& folder, double sigma_m, const std::string& parameter) {
  std::vector<StampedPose> estimate, truth;
  for (const PosePair& pair : NoisyPairs(sigma_m, 3)) {
    estimate.push_back({pair.t, pair.T_WB});
    truth.push_back({pair.t, pair.T_GB});
  }
  fs::create_directories(folder);
  WriteTum(folder / "trajectory.tum", estimate);
  WriteTum(folder / "truth.tum", truth);
  WriteText(folder / "summary.json",
            R"({"frames": 410, "stages": {"track": {"mean_ms": 1.25}}, "text": "</script>"})");
  WriteText(folder / "config.yaml", "estimator:\n  depth: 3\n  width: " + parameter + "\n");
  std::string timing = "timestamp_ns,is_keyframe,optimize,planes,constraints\n";
  for (int i = 0; i < 50; ++i)
    timing +=
        std::to_string(i) + ",1," + std::to_string(i % 7) + "," + std::to_string(i / 10) + ",0\n";
  WriteText(folder / "timing.csv", timing);
  RunEvaluation evaluation = EvaluateRun(folder, LoadGroundTruth(folder / "truth.tum"), {});
  MeshError mesh;
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    mesh.picture_samples_G.push_back(rng.Normal3());
    mesh.picture_distances_m.push_back(0.3 * rng.Uniform());
  }
  mesh.aligned.accuracy = {0.0123, 0.01, 0.05, 0.02};
  evaluation.mesh = mesh;
  return evaluation;
}

Report MakeTestReport(const TempFolder& folder) {
  Report report;
  report.title = "A & B";
  ReportSection& section = report.sections.emplace_back();
  section.name = "sequence <1>";
  section.runs.push_back(MakeReportRun("S", MakeRun(folder / "S", 0.02, "7")));
  section.runs.push_back(MakeReportRun("SPR", MakeRun(folder / "SPR", 0.01, "9")));
  return report;
}

struct ShownNumber {
  std::string pointer, format, text;
  double factor = 1;
};

std::vector<ShownNumber> NumbersOf(const std::string& html) {
  static const std::regex kCell(
      R"re(<td data-pointer="([^"]*)" data-format="([^"]*)" data-factor="([^"]*)">([^<]*)</td>)re");
  std::vector<ShownNumber> numbers;
  for (std::sregex_iterator i(html.begin(), html.end(), kCell), end; i != end; ++i)
    numbers.push_back({(*i)[1], (*i)[2], (*i)[4], std::stod((*i)[3])});
  return numbers;
}

void ExpectNumbersEqual(const std::string& html, const ordered_json& document) {
  for (const ShownNumber& shown : NumbersOf(html)) {
    SCOPED_TRACE(shown.pointer);
    const ordered_json::json_pointer place(shown.pointer);
    ASSERT_TRUE(document.contains(place));
    EXPECT_EQ(FormatNumber(shown.format, shown.factor * document[place].get<double>()), shown.text);
  }
}

TEST(ReportTest, EveryNumberEqualsTheJson) {
  const TempFolder folder;
  const Report report = MakeTestReport(folder);
  WriteReport(folder / "report", report);
  const std::string html = ReadText(folder / "report" / "report.html");
  const auto document = ordered_json::parse(ReadText(folder / "report" / "report.json"));
  EXPECT_GT(NumbersOf(html).size(), 60u);
  ExpectNumbersEqual(html, document);
  // Where a run's own file has the number, the report has the same.
  EXPECT_EQ(document["sections"][0]["runs"][0]["evaluation"]["ate"]["rmse_m"],
            report.sections[0].runs[0].evaluation.causal.ate_m.rmse);
  // No cell shows a number that is not tied to the document (parameters are texts of their files).
  static const std::regex kBare(R"(<td>[-+0-9.]+</td>)");
  const std::string before_parameters = html.substr(0, html.find("Parameters that differ"));
  EXPECT_FALSE(std::regex_search(before_parameters, kBare));
  // The page carries the document itself.
  const std::size_t begin = html.find("id=\"report-data\">") + 17;
  const std::string embedded = html.substr(begin, html.find("</script>", begin) - begin);
  EXPECT_EQ(ordered_json::parse(embedded), document);
}

TEST(ReportTest, NeedsNothingElseAndEscapesTexts) {
  const TempFolder folder;
  const std::string html = ReportHtml(MakeTestReport(folder));
  for (const char* outside : {"src=", "<link", "@import", "url("})
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  EXPECT_THAT(html, HasSubstr("A &amp; B"));
  EXPECT_THAT(html, HasSubstr("sequence &lt;1&gt;"));
  EXPECT_EQ(html.find("</script>"), html.rfind("</script>"));
}

TEST(ReportTest, TheSceneIsAPageInThePage) {
  const TempFolder folder;
  Report report = MakeTestReport(folder);
  EXPECT_THAT(ReportHtml(report), Not(HasSubstr("<iframe")));
  report.sections[0].scene_page = "<p class=\"a\">1 & 2</p>";
  EXPECT_THAT(ReportHtml(report),
              HasSubstr("srcdoc=\"&lt;p class=&quot;a&quot;&gt;1 &amp; 2&lt;/p&gt;\""));
}

TEST(ReportTest, ShowsWhatTheCameraSaw) {
  const TempFolder folder;
  Report report = MakeTestReport(folder);
  EXPECT_THAT(ReportHtml(report), Not(HasSubstr("left camera")));
  report.sections[0].images.push_back({"camera_0", "S after 2.5 s", "3 faces", "<svg>x</svg>"});
  EXPECT_THAT(ReportHtml(report),
              HasSubstr("<figure><h3>S after 2.5 s</h3>\n<svg>x</svg><figcaption>3 faces"));
}

TEST(ReportTest, HasTheFiguresThatThereAreDataFor) {
  const TempFolder folder;
  const Report report = MakeTestReport(folder);
  WriteReport(folder / "report", report);
  for (const char* name : {"trajectory_top",
                           "trajectory_side",
                           "error_over_time",
                           "rpe_translation",
                           "rpe_rotation",
                           "mesh_top_S",
                           "mesh_oblique_SPR",
                           "optimize_time",
                           "planes",
                           "stages"}) {
    const fs::path svg = folder / "report" / (std::string(name) + ".svg");
    EXPECT_TRUE(fs::exists(svg)) << svg;
    EXPECT_THAT(ReadText(svg), Not(HasSubstr("nan")));
  }
  EXPECT_FALSE(fs::exists(folder / "report" / "constraints.svg"));  // all zero
  EXPECT_FALSE(fs::exists(folder / "report" / "map_top_S.svg"));
  const std::string html = ReadText(folder / "report" / "report.html");
  EXPECT_THAT(html, HasSubstr("estimator.width"));
  EXPECT_THAT(html, Not(HasSubstr("estimator.depth")));
}

TEST(ReportTest, TrajectoryOfAnotherSystemHasNoTiming) {
  const TempFolder folder;
  MakeRun(folder / "S", 0.02, "7");
  const GroundTruth truth = LoadGroundTruth(folder / "S" / "truth.tum");
  Report report;
  report.sections.emplace_back().runs.push_back(
      MakeReportRun("other", EvaluateRun(folder / "S" / "trajectory.tum", truth, {})));
  for (const ReportFigure& figure : MakeFigures(report.sections[0].runs)) {
    EXPECT_NE(figure.name, "stages");
    EXPECT_NE(figure.name, "optimize_time");
  }
  EXPECT_THAT(ReportHtml(report), HasSubstr("ATE RMSE"));
}

TEST(ReportTest, FolderThatCannotBeCreated) {
  const TempFolder folder;
  WriteText(folder / "file", "x");
  EXPECT_THROW(WriteReport(folder / "file", MakeTestReport(folder)), ConfigError);
}

// ----------------------------------------------------------------------------------- comparison

ComparedRun MakeComparedRun(double start_s, double sigma_m, std::uint64_t seed) {
  ComparedRun run;
  run.start_s = start_s;
  run.has_result = true;
  run.pairs = NoisyPairs(sigma_m, seed);
  const TrajectoryAlignment alignment = AlignPairs(run.pairs, AlignmentKind::kSE3);
  const ErrorStatistics ate = Summarize(AbsoluteErrors(run.pairs, alignment));
  run.evaluation = {{"ate", {{"rmse_m", ate.rmse}, {"median_m", ate.median}}}, {"coverage", 0.98}};
  return run;
}

ComparedSequence MakeComparedSequence(const std::string& name) {
  ComparedSequence sequence;
  sequence.name = name;
  sequence.combinations = {{"S", {}}, {"SPR", {}}, {"SP", {}}};
  for (int k = 0; k < 9; ++k) {
    sequence.combinations[0].runs.push_back(MakeComparedRun(0.1 * k, 0.02, 10 + k));
    sequence.combinations[1].runs.push_back(MakeComparedRun(0.1 * k, 0.01, 50 + k));
    ComparedRun failed;
    failed.start_s = 0.1 * k;
    failed.message = "--pipeline SP: is not built yet";
    sequence.combinations[2].runs.push_back(failed);
  }
  return sequence;
}

TEST(ComparisonTest, SeesHalfTheErrorAndSaysWhatFailed) {
  const auto json =
      CompareToJson({MakeComparedSequence("V1_01_easy"), MakeComparedSequence("mine")});
  ASSERT_EQ(json["sequences"][0]["paired"].size(), 1u);
  const ordered_json& paired = json["sequences"][0]["paired"][0];
  EXPECT_EQ(paired["other"], "SPR");
  EXPECT_NEAR(paired["median_ratio"].get<double>(), 0.5, 0.03);
  EXPECT_EQ(paired["verdict"], "real");
  EXPECT_EQ(json["pooled"][0]["pairs"], 18);
  EXPECT_EQ(json["sequences"][0]["combinations"][2]["starts_done"], 0);
  std::string text;
  for (const Table& table : ComparisonTables(json))
    text += ToText(table);
  EXPECT_THAT(text, HasSubstr("--pipeline SP: is not built yet"));
}

TEST(ComparisonTest, OneLinePerRunForOtherPrograms) {
  ComparedSequence sequence = MakeComparedSequence("mine");
  sequence.combinations[0].runs[3].message = "map.ply: an empty mesh";
  const auto json = CompareToJson({sequence});
  const auto lines = Lines(RunsCsv(json));
  ASSERT_EQ(lines.size(), 28u);
  EXPECT_THAT(lines[0], ::testing::StartsWith("sequence,combination,start_s,done,ate_rmse_m,"));
  EXPECT_THAT(lines[2], ::testing::StartsWith("mine,S,0.1,1,0.03"));
  EXPECT_THAT(lines[27], ::testing::StartsWith("mine,SP,0.8,0,,,"));
  EXPECT_THAT(ToText(ComparisonTables(json).back()), HasSubstr("judged in part only"));
}

TEST(ComparisonTest, PaperBesideOurs) {
  const auto json = CompareToJson({MakeComparedSequence("V1_01_easy")});
  const std::vector<Table> tables = ComparisonTables(json);
  const std::string one = ToMarkdown(tables[0]), two = ToMarkdown(tables[1]);
  EXPECT_THAT(one, HasSubstr("| 5.6 | 6.4 | 6.2 | 7.7 | 5.3 | 5.7 |"));
  EXPECT_THAT(two, HasSubstr("| V1_01_easy | 9 | 34 | 10 | 7 | 7 | 6 |"));
  const auto other = ComparisonTables(CompareToJson({MakeComparedSequence("mine")}));
  EXPECT_THAT(ToMarkdown(other[0]), Not(HasSubstr("paper")));
}

TEST(ComparisonTest, NumbersOfThePageEqualTheJson) {
  Report report;
  report.comparison = CompareToJson({MakeComparedSequence("V1_01_easy")});
  const std::string html = ReportHtml(report);
  EXPECT_GT(NumbersOf(html).size(), 12u);
  ExpectNumbersEqual(html, ReportDocument(report));
}

TEST(PaperTablesTest, SequencesByLongAndShortName) {
  EXPECT_EQ(PaperRows().size(), 11u);
  ASSERT_TRUE(FindPaperRow("V2_02_medium"));
  EXPECT_EQ(FindPaperRow("V2_02"), FindPaperRow("V2_02_medium"));
  EXPECT_EQ(*FindPaperRow("V2_02")->rmse_cm[2], 10.3);
  EXPECT_FALSE(FindPaperRow("V1_03_difficult")->median_cm[0]);
  EXPECT_FALSE(FindPaperRow("rendered_room"));
}

TEST(SvgPlotTest, BoxesAndIntervals) {
  std::vector<double> values;
  for (int i = 0; i <= 100; ++i)
    values.push_back(i);
  const BoxSummary box = SummarizeBox(values);
  EXPECT_DOUBLE_EQ(box.p5, 5);
  EXPECT_DOUBLE_EQ(box.q1, 25);
  EXPECT_DOUBLE_EQ(box.median, 50);
  EXPECT_DOUBLE_EQ(box.p95, 95);
  EXPECT_DOUBLE_EQ(Cover(values, 0).high, 100);
  EXPECT_DOUBLE_EQ(Cover({}, 0).high, 1);
  EXPECT_LT(Cover({3, 3}).low, 3);
}

TEST(SvgPlotTest, ValuesThatAreNotFiniteAreLeftOut) {
  PlotLayout layout;
  SvgPlot plot(layout);
  const double nan = std::nan("");
  plot.AddLine({{0, 0}, {0.5, nan}, {1, 1}}, "#000000");
  plot.AddPoints({{nan, 0}, {0.5, 0.5}}, {"#111111", "#222222"}, 1);
  EXPECT_THAT(plot.ToString(), Not(HasSubstr("nan")));
  EXPECT_EQ(DistanceColour(-1), DistanceColour(0));
  EXPECT_NE(DistanceColour(0), DistanceColour(1));
}

TEST(SvgPlotTest, LegendStaysAboveTheFrameInAsManyRowsAsItNeeds) {
  SvgPlot one(PlotLayout{});
  one.AddLegend("S", "#000000");
  EXPECT_THAT(one.ToString(), HasSubstr("viewBox=\"0 0"));
  SvgPlot many(PlotLayout{});
  for (int i = 0; i < 9; ++i)
    many.AddLegend("a configuration with a long name", "#000000");
  EXPECT_THAT(many.ToString(), HasSubstr("viewBox=\"0 -"));
  EXPECT_THAT(many.ToString(), Not(HasSubstr("viewBox=\"0 -0")));
}

TEST(SvgPlotTest, CountsHaveWholeTicks) {
  PlotLayout layout;
  layout.y_label = "planes";
  EXPECT_THAT(SvgPlot(layout).ToString(), HasSubstr(">0.4<"));
  layout.y_counts = true;
  layout.x_categories = {"a"};
  EXPECT_THAT(SvgPlot(layout).ToString(), Not(HasSubstr(">0.4<")));
}

TEST(TableTest, CsvAndMarkdownQuote) {
  Table table;
  table.header = {"a,b", "c|d"};
  table.rows = {{{"x\"y", "", "", 1}, {"z", "", "", 1}}};
  EXPECT_THAT(ToCsv(table), HasSubstr("\"a,b\",c|d\n\"x\"\"y\",z\n"));
  EXPECT_THAT(ToMarkdown(table), HasSubstr("c\\|d"));
}

}  // namespace
}  // namespace facet
