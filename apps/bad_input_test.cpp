// SPDX-License-Identifier: BSD-2-Clause
// Runs the built program on damaged recordings: it must end with the right exit code and one line
// on stderr that names the file and the reason.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "facet/testing/folders.h"
#include "facet/testing/io/program_run.h"

namespace facet {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const char* const kProgram = FACET_PROGRAM;

class BadInputTest : public ::testing::Test {
 protected:
  BadInputTest() { WriteTestSequence(Sequence()); }
  std::filesystem::path Sequence() const { return folder_ / "seq"; }
  std::filesystem::path Mav0() const { return Sequence() / "mav0"; }
  std::filesystem::path Csv(const std::string& sensor) const {
    return Mav0() / sensor / "data.csv";
  }
  std::filesystem::path Out() const { return folder_ / "out"; }

  ProgramRun Run(const std::string& more = "") const {
    return RunFacet("run " + Sequence().string() + " --quiet --out " + Out().string() + " " + more);
  }

  /// The run fails with one line that holds all texts, and leaves nothing behind.
  void ExpectFailure(int exit_code, const std::string& text, const std::string& more = "") const {
    const ProgramRun run = Run(more);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_THAT(run.err, AllOf(::testing::StartsWith("facet: error: "), HasSubstr(text)));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(std::filesystem::exists(Out()));
    EXPECT_EQ(NumEntries(), std::filesystem::exists(Sequence()) ? 1 : 0);
  }

  /// Beside the sequence; hidden ones count.
  std::ptrdiff_t NumEntries() const {
    const auto entries = std::filesystem::directory_iterator(folder_.path());
    return std::distance(begin(entries), end(entries));
  }

  TempFolder folder_;
};

TEST_F(BadInputTest, MissingFolder) {
  std::filesystem::remove_all(Sequence());
  ExpectFailure(3, "seq: no such folder");
}

TEST_F(BadInputTest, FolderThatIsNoSequence) {
  std::filesystem::rename(Mav0(), Sequence() / "images");
  ExpectFailure(3, "holds neither mav0/ nor cam0/");
}

TEST_F(BadInputTest, MissingFile) {
  std::filesystem::remove(Csv("cam1"));
  ExpectFailure(3, "cam1/data.csv: no such file");
}

TEST_F(BadInputTest, MissingImages) {
  std::filesystem::remove_all(Mav0() / "cam0" / "data");
  ExpectFailure(3, "cam0/data.csv");
}

TEST_F(BadInputTest, EmptyCsv) {
  WriteText(Csv("imu0"), "");
  ExpectFailure(3, "imu0/data.csv: holds no data");
}

TEST_F(BadInputTest, UnsortedStamps) {
  EditLines(Csv("cam0"),
            [](std::vector<std::string>& lines) { std::reverse(lines.begin() + 1, lines.end()); });
  ExpectFailure(3, "cam0/data.csv:3: 11 of 12 lines have a stamp that runs backwards");
}

TEST_F(BadInputTest, DuplicateStamps) {
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 2; i < lines.size(); ++i)
      lines[i] = lines[1];
  });
  ExpectFailure(3, "imu0/data.csv:3: 150 of 151 lines have a duplicate stamp");
}

TEST_F(BadInputTest, StampsInSeconds) {
  EditLines(Csv("cam0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i].insert(10, 1, '.');
  });
  ExpectFailure(3, "look like seconds");
}

TEST_F(BadInputTest, WrongImageSize) {
  ReplaceInFile(Mav0() / "cam0" / "sensor.yaml", "[160, 120]", "[320, 240]");
  ExpectFailure(3, "160 x 120 pixels, the calibration of cam0 has 320 x 240");
}

TEST_F(BadInputTest, TruncatedImages) {
  for (const auto& image : std::filesystem::directory_iterator(Mav0() / "cam0" / "data")) {
    Truncate(image, 500);
  }
  ExpectFailure(3, ".pgm: truncated PGM");
}

TEST_F(BadInputTest, UnknownImageFormat) {
  for (const auto& image : std::filesystem::directory_iterator(Mav0() / "cam1" / "data")) {
    WriteText(image, "BM this is a bitmap");
  }
  ExpectFailure(3, "not a PNG, JPEG, WebP or PGM image");
}

TEST_F(BadInputTest, ImuNotFinite) {
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i] = lines[i].substr(0, 19) + ",0,0,nan,0,0,inf";
  });
  ExpectFailure(3, "imu0/data.csv:2: 151 of 151 lines have values that are not finite");
}

TEST_F(BadInputTest, NoOverlapOfCameraAndImu) {
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i][5] = '9';
  });
  ExpectFailure(3, "camera and IMU do not overlap in time");
}

TEST_F(BadInputTest, SingularCalibration) {
  ReplaceInFile(Mav0() / "cam1" / "sensor.yaml", "[0.0, -1.0, 0.0,", "[0.0, 0.0, 0.0,");
  ExpectFailure(3, "cam1/sensor.yaml:3: 'T_BS' is singular");
}

TEST_F(BadInputTest, MissingCalibration) {
  std::filesystem::remove(Mav0() / "cam0" / "sensor.yaml");
  ExpectFailure(3, "--calibration FILE");
}

TEST_F(BadInputTest, NoTextureCannotStart) {
  const std::string grey = "P5\n160 120\n255\n" + std::string(160 * 120, 'x');
  for (const char* camera : {"cam0", "cam1"}) {
    for (const auto& image : std::filesystem::directory_iterator(Mav0() / camera / "data")) {
      WriteText(image, grey);
    }
  }
  const ProgramRun run = Run();
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.err, HasSubstr("could not start"));
  EXPECT_THAT(run.err, HasSubstr("12 of 12 left images have no texture"));
  EXPECT_THAT(run.err, Not(HasSubstr("IMU")));
  EXPECT_TRUE(std::filesystem::exists(Out() / "summary.json"));
}

TEST_F(BadInputTest, BlackImagesAreCalledBlack) {
  const std::string black = "P5\n160 120\n255\n" + std::string(160 * 120, '\0');
  for (const auto& image : std::filesystem::directory_iterator(Mav0() / "cam0" / "data"))
    WriteText(image, black);
  const ProgramRun run = Run();
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.err, HasSubstr("12 of 12 left images are black"));
  EXPECT_THAT(run.err, AllOf(Not(HasSubstr("IMU")), Not(HasSubstr("repeat"))));
}

TEST_F(BadInputTest, TinyImagesAreCalledTiny) {
  for (const int side : {8, 32}) {
    std::filesystem::remove_all(Sequence());
    TestSequenceOptions options;
    options.width = options.height = side;
    WriteTestSequence(Sequence(), options);
    const ProgramRun run = Run();
    EXPECT_EQ(run.exit_code, 4);
    const std::string text = std::to_string(side);
    EXPECT_THAT(run.err, HasSubstr("the images have " + text + " x " + text + " pixels, too few"));
  }
}

TEST_F(BadInputTest, AnImmenseImageIsRefusedWithoutTheMemoryForIt) {
  for (const auto& image : std::filesystem::directory_iterator(Mav0() / "cam0" / "data"))
    WriteText(image, "P5\n8000 8000\n255\n" + std::string(1000, 'x'));
  ExpectFailure(3, "8000 x 8000 pixels, the calibration of cam0 has 160 x 120");
}

TEST_F(BadInputTest, UnknownKey) {
  WriteText(Sequence() / "my.yaml", "frontend:\n  max_feature: 100\n");
  ExpectFailure(
      2,
      "my.yaml:2: unknown key 'frontend.max_feature'; did you mean 'frontend.max_features'?",
      "--config " + (Sequence() / "my.yaml").string());
  ExpectFailure(2, "--set: unknown key 'nonsense'", "--set nonsense=1");
}

TEST_F(BadInputTest, ValueOutOfRange) {
  ExpectFailure(2,
                "frontend.max_features = '-3' is out of range, allowed: ",
                "--set frontend.max_features=-3");
  ExpectFailure(2, "must be an integer", "--set frontend.max_features=many");
  ExpectFailure(2, "allowed: auto | avx2 | sse2 | neon | scalar", "--set frontend.klt.simd=avx512");
  ExpectFailure(2, "key.path=value is expected", "--set frontend.max_features");
}

TEST_F(BadInputTest, OptionOfAnEarlierVersionThatHasAnotherValueThanItsDefault) {
  ExpectFailure(
      2,
      "--set: frontend.klt.max_iterations = '9': frontend.klt.max_iterations is no option "
      "any more, it is now fixed at 6; remove it",
      "--set frontend.klt.max_iterations=9");
}

TEST_F(BadInputTest, SavedConfigurationOfAnEarlierVersionIsReadWithNotices) {
  const ProgramRun run =
      RunFacet("config --all --config " +
               (testing::SourceFolder() / "testdata" / "saved_config_0.1.yaml").string());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("facet: note: "));
  EXPECT_THAT(run.err, HasSubstr("frontend.klt.max_iterations is now fixed at 6"));
}

TEST_F(BadInputTest, WrongUsage) {
  ExpectFailure(2, "--start", "--start yesterday");
  ExpectFailure(2, "the sequence lasts 0.6 s", "--start 100");
  ExpectFailure(2, "--duration", "--duration 0");
  ExpectFailure(2, "--nonsense", "--nonsense");
  ExpectFailure(2, "--publish=70000: a port", "--publish=70000");
  ExpectFailure(2, "is a folder", "--record " + folder_.path().string());
  EXPECT_EQ(RunFacet("").exit_code, 2);
  EXPECT_EQ(RunFacet("run").exit_code, 2);
  const ProgramRun unknown = RunFacet("fly there");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("unknown command 'fly'"));
}

TEST_F(BadInputTest, ShortWordsForNumbersOutOfRange) {
  ExpectFailure(2, "--start: '-1' is not a number of at least 0; see", "--start -1");
  ExpectFailure(2, "--duration: '1e400' is not a positive number; see", "--duration 1e400");
  ExpectFailure(2, "--threads: Value 0 not in range 1 to 64; see", "--threads 0");
}

/// CLI11's own checks of signs print the largest number there is.
TEST(ProgramTest, SignsOfNumbersAreCheckedInOnePlace) {
  const std::filesystem::path apps = std::filesystem::path(testing::SourceFolder()) / "apps";
  for (const auto& file : std::filesystem::directory_iterator(apps)) {
    if (file.path().extension() != ".cpp" || file.path().stem() == "bad_input_test") continue;
    EXPECT_THAT(ReadText(file.path()),
                AllOf(Not(HasSubstr("CLI::Positive")), Not(HasSubstr("CLI::NonNegative"))))
        << file.path();
  }
}

TEST_F(BadInputTest, UnwritableOutput) {
  const ProgramRun in_proc =
      RunFacet("run " + Sequence().string() + " --quiet --out /proc/nowhere/run");
  EXPECT_EQ(in_proc.exit_code, 2);
  EXPECT_THAT(in_proc.err, HasSubstr("--out /proc/nowhere/run: cannot be created"));
  const ProgramRun occupied =
      RunFacet("run " + Sequence().string() + " --quiet --out " + Mav0().string());
  EXPECT_EQ(occupied.exit_code, 2);
  EXPECT_THAT(occupied.err, HasSubstr("is not a result of Facet"));
  EXPECT_TRUE(std::filesystem::exists(Csv("cam0")));
}

TEST_F(BadInputTest, FullDisk) {
  // No file may grow beyond 4 KiB: what a full disk looks like to the program.
  const ProgramRun run = RunShell("(ulimit -f 4; " + std::string(kProgram) + " run " +
                                  Sequence().string() + " --quiet --out " + Out().string() + ")");
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.err, HasSubstr("cannot be written (disk full"));
  EXPECT_FALSE(std::filesystem::exists(Out()));
}

TEST_F(BadInputTest, FullDiskLeavesTheEarlierResult) {
  WriteText(Out() / "summary.json", "earlier");
  const std::string command = "(ulimit -f 4; " + std::string(kProgram) + " run " +
                              Sequence().string() + " --quiet --out " + Out().string();
  EXPECT_EQ(RunShell(command + ")").exit_code, 5);
  EXPECT_EQ(RunShell(command + " --mesh-every 1 --mesh-format glb)").exit_code, 5);
  EXPECT_EQ(ReadText(Out() / "summary.json"), "earlier");
  EXPECT_EQ(NumEntries(), 2) << "something was left behind";
}

TEST_F(BadInputTest, ATableThatCannotBePrinted) {
  const ProgramRun run = RunShell("(" + std::string(kProgram) + " config > /dev/full)");
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.err, HasSubstr("standard output cannot be written"));
}

TEST_F(BadInputTest, ReadOnlyFolder) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const std::filesystem::path shut = folder_ / "shut";
  std::filesystem::create_directory(shut);
  std::filesystem::permissions(
      shut, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const ProgramRun run =
      RunFacet("run " + Sequence().string() + " --quiet --out " + (shut / "run").string());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("cannot be created: Permission denied"));
  std::filesystem::permissions(shut, std::filesystem::perms::owner_all);
}

class InterruptedRunTest : public BadInputTest {
 protected:
  /// Twenty seconds at recorded speed; the signal comes once the folder is being written.
  ProgramRun RunAndSend(const std::string& signal) const {
    std::filesystem::remove_all(Sequence());
    TestSequenceOptions options;
    options.num_frames = 400;
    WriteTestSequence(Sequence(), options);
    return RunShell("(" + std::string(kProgram) + " run " + Sequence().string() +
                    " --quiet --realtime --out " + Out().string() + " & while ! ls -d " +
                    folder_.path().string() +
                    "/.out.partial-* >/dev/null 2>&1; do sleep 0.05; done; sleep 1; kill -" +
                    signal + " $!; wait $!)");
  }
};

TEST_F(InterruptedRunTest, InterruptedRunsWriteWhatTheyHave) {
  const ProgramRun run = RunAndSend("INT");
  EXPECT_EQ(run.exit_code, 130) << run.err;
  EXPECT_THAT(run.err, HasSubstr("stopped after"));
  EXPECT_THAT(ReadText(Out() / "summary.json"), HasSubstr("stopped after"));
  EXPECT_EQ(NumEntries(), 2);
}

// What a run that is killed leaves is looked at by scripts/kill_runs.py.
TEST_F(InterruptedRunTest, TheNextRunKeepsWhatAKilledOneLeft) {
  EXPECT_EQ(RunAndSend("KILL").exit_code, 128 + SIGKILL);
  EXPECT_FALSE(std::filesystem::exists(Out()));
  EXPECT_EQ(NumEntries(), 3) << "the sequence, the partial result, and the place for the whole";
  EXPECT_THAT(ReadText(folder_ / "out.partial" / "summary.json"),
              HasSubstr("\"interrupted\": true"));
  const ProgramRun next = Run("--duration 0.5");
  EXPECT_THAT(next.err, HasSubstr("out.interrupted"));
  EXPECT_TRUE(std::filesystem::exists(Out() / "summary.json"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out.interrupted" / "states.csv"));
  EXPECT_EQ(NumEntries(), 3) << "the sequence, what is left of the killed run, and the result";
}

TEST_F(BadInputTest, SmallDamageIsSurvivedAndReported) {
  EditLines(Csv("imu0"), [](std::vector<std::string>& lines) {
    lines[50] = lines[50].substr(0, 19) + ",nan,0,0,0,0,0";
  });
  Truncate(Mav0() / "cam0" / "data" / (std::to_string(FrameStamp({}, 5)) + ".pgm"), 500);
  Truncate(Mav0() / "cam1" / "data" / (std::to_string(FrameStamp({}, 7)) + ".pgm"), 500);
  const ProgramRun run = Run();
  EXPECT_THAT(run.exit_code, ::testing::AnyOf(0, 4)) << run.err;
  const std::string summary = ReadText(Out() / "summary.json");
  EXPECT_THAT(summary,
              AllOf(HasSubstr("not finite"),
                    HasSubstr("their frames were skipped"),
                    HasSubstr("left image only")));
  EXPECT_THAT(summary, HasSubstr("\"damaged_frames\": 1"));
}

TEST(ProgramTest, HelpAndVersion) {
  const ProgramRun version = RunFacet("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, ::testing::MatchesRegex("facet [0-9.]+\n"));
  const ProgramRun help = RunFacet("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("run"), HasSubstr("evaluate"), HasSubstr("config")));
  EXPECT_THAT(RunFacet("run --help").out, HasSubstr("--imu-history"));
}

std::string EurocConfig() {
  return testing::SourceFolder() / "config" / "euroc.yaml";
}

TEST(ProgramTest, ConfigFileHoldsTheBuiltInValues) {
  EXPECT_EQ(RunFacet("config --all").out, ReadText(EurocConfig()))
      << "write it again: build/facet config --all > config/euroc.yaml";
  const std::string file = EurocConfig();
  const ProgramRun again = RunFacet("config --all --config " + file);
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out, ReadText(file));
}

TEST(ProgramTest, DoesNotLinkTheWorld) {
  const ProgramRun run = RunShell(std::string("ldd ") + kProgram);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("libopencv_core"),
                    Not(HasSubstr("gdal")),
                    Not(HasSubstr("poppler")),
                    Not(HasSubstr("imgcodecs"))));
}

}  // namespace
}  // namespace facet
