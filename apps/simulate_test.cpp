// SPDX-License-Identifier: BSD-2-Clause
// Runs `facet simulate` with everything that can be wrong: right exit code, one line on stderr that
// says what to do, and nothing left behind.
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;

struct ProgramRun {
  int exit_code = -1;
  std::string err;
};

ProgramRun RunShell(const std::string& command) {
  const TempFolder folder;
  const std::string redirected =
      command + " >/dev/null 2>" + (folder / "err").string() + " </dev/null";
  // The command consists of constants and temporary folders of this test.
  const int status = std::system(redirected.c_str());  // NOLINT(concurrency-mt-unsafe)
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          ReadText(folder / "err")};
}

class SimulateTest : public ::testing::Test {
 protected:
  std::string Command(const std::string& arguments) const {
    return std::string(FACET_PROGRAM) + " simulate --quiet --out " +
           (out_.path() / "sequence").string() + " " + arguments;
  }

  void ExpectFailure(int exit_code, const std::string& text, const std::string& arguments) const {
    Expect(RunShell(Command(arguments)), exit_code, text);
  }

  void Expect(const ProgramRun& run, int exit_code, const std::string& text) const {
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_THAT(run.err, ::testing::StartsWith("facet: error: "));
    EXPECT_THAT(run.err, HasSubstr(text));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_TRUE(std::filesystem::is_empty(out_.path())) << "something was left behind";
  }

  /// Writes a scene file and returns the option that names it.
  std::string Scene(const std::string& text) const {
    WriteText(in_ / "scene.yaml", text);
    return "--scene " + (in_ / "scene.yaml").string();
  }

  TempFolder in_, out_;
};

TEST_F(SimulateTest, UnknownNamesListTheKnownOnes) {
  ExpectFailure(
      2, "known: room, corridor, clutter, office, hall, facade, or a scene file", "--scene attic");
  ExpectFailure(2, "known: gentle, fast, aggressive, hover, hand-held, walk", "--trajectory loop");
  ExpectFailure(2, "unknown key 'image.blur'", "--set image.blur=1");
  ExpectFailure(2, "out of range", "--set image.rays_per_pixel=0");
}

TEST_F(SimulateTest, WrongUsage) {
  ExpectFailure(2, "--threads", "--threads 0");
  ExpectFailure(2, "only room has", "--scene corridor --set near_things_m=0.5");
  ExpectFailure(2, "only goes with a recorded --trajectory", "--imu imu.csv");
  const ProgramRun run = RunShell(std::string(FACET_PROGRAM) + " simulate");
  Expect(run, 2, "--out DIR is required");
}

TEST_F(SimulateTest, ShortWordsForNumbersOutOfRange) {
  ExpectFailure(2, "--start: '-1' is not a number of at least 0; see", "--start -1");
  ExpectFailure(2, "--duration: '0' is not a positive number; see", "--duration 0");
  ExpectFailure(2, "--duration: '1e999' is not a positive number; see", "--duration 1e999");
  ExpectFailure(2, "--seed: '-1' is not a number of at least 0; see", "--seed -1");
  ExpectFailure(2, "--noise-seeds: Value 0 not in range 1 to 100; see", "--noise-seeds 0");
}

TEST_F(SimulateTest, NoiseSeeds) {
  ExpectFailure(2, "--noise-seeds", "--noise-seeds 0");
  ExpectFailure(2, "without noise all sequences are the same", "--noise-seeds 2 --noise-free");
  const ProgramRun run = RunShell(Command("--noise-seeds 2 --duration 0.1"));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* name : {"sequence-1", "sequence-2"}) {
    EXPECT_THAT(ReadText(out_ / name / "simulation.txt"),
                HasSubstr(std::string("Noise realisation ") + name[9] + " of 2."));
    EXPECT_TRUE(std::filesystem::exists(out_ / name / "mav0" / "imu0" / "data.csv"));
  }
  const auto entries = std::filesystem::directory_iterator(out_.path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 2);
  const ProgramRun again = RunShell(Command("--noise-seeds 3 --duration 0.1"));
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("sequence-1: exists already"));
  EXPECT_FALSE(std::filesystem::exists(out_ / "sequence-3"));
}

TEST_F(SimulateTest, ExistingOutputIsNotTouched) {
  WriteText(in_ / "seq" / "precious.txt", "mine");
  const ProgramRun run =
      RunShell(std::string(FACET_PROGRAM) + " simulate --out " + (in_ / "seq").string());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("exists already; delete it or choose another name"));
  EXPECT_EQ(ReadText(in_ / "seq" / "precious.txt"), "mine");
}

TEST_F(SimulateTest, UnusableTextures) {
  ExpectFailure(3, "textures: ", "--textures " + (in_ / "nowhere").string());
  std::filesystem::create_directory(in_ / "images");
  ExpectFailure(3, "holds no image", "--textures " + (in_ / "images").string());
  WriteText(in_ / "images" / "a.png", "not an image");
  ExpectFailure(3, "a.png: ", "--textures " + (in_ / "images").string());
}

TEST_F(SimulateTest, SceneFileWithUnknownWords) {
  ExpectFailure(
      3, "scene.yaml:1: unknown key 'object'", Scene("object: 1\nroute: [0,0,1, 1,0,1]\n"));
  const std::string route = "route: [[0,0,1], [3,0,1]]\n";
  ExpectFailure(3,
                "scene.yaml:3: no object type 'sofa'; known: board, box, ",
                Scene(route + "objects:\n  - {type: sofa, at: [0, 0, 0]}\n"));
  ExpectFailure(
      3,
      "no material 'gold'; known: plaster, ",
      Scene(route + "objects:\n  - {type: box, at: [0,2,0], size: [1,1,1], material: gold}\n"));
  ExpectFailure(
      3,
      "a 'box' has no 'radius'",
      Scene(route + "objects:\n  - {type: box, at: [0,2,0], size: [1,1,1], radius: 1}\n"));
}

TEST_F(SimulateTest, SceneFileWithUnusableSizesImagesAndMeshes) {
  const std::string head = "route: [[0,0,1], [3,0,1]]\nobjects:\n";
  ExpectFailure(3,
                "scene.yaml:3: 'size' must be larger than",
                Scene(head + "  - {type: box, at: [0,2,0], size: [1, 0, 1]}\n"));
  ExpectFailure(3,
                "scene.yaml:3: 'image': ",
                Scene(head + "  - {type: box, at: [0,2,0], size: [1,1,1], image: x.png}\n"));
  WriteText(in_ / "flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  ExpectFailure(3,
                "flat.obj: degenerate mesh",
                Scene(head + "  - {type: mesh, at: [0,2,0], file: flat.obj}\n"));
  ExpectFailure(
      3, "a made-up flight needs a 'route'", Scene("objects:\n  - {type: chair, at: [0,0,0]}\n"));
}

TEST_F(SimulateTest, DamagedSceneFilesAndMeshes) {
  const std::string objects = "objects:\n  - {type: chair, at: [0,2,0]}\n";
  ExpectFailure(3,
                "'objects' must be a list of at least one object",
                Scene("route: [[0,0,1], [3,0,1]]\nobjects: []\n"));
  ExpectFailure(3, "at least two points [x, y, z]", Scene("route: [[0,0,1]]\n" + objects));
  ExpectFailure(3, "scene.yaml:", Scene("objects: [\n"));
  const std::string mesh =
      "route: [[0,0,1], [3,0,1]]\nobjects:\n  - {type: mesh, at: [0,2,0], file: a.obj}\n";
  ExpectFailure(3, "a.obj: cannot be opened", Scene(mesh));
  WriteText(in_ / "a.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n");
  ExpectFailure(3, "a.obj:3: unknown corner", Scene(mesh));
  WriteText(in_ / "a.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n");
  ExpectFailure(3, "a.obj:3: a face needs three corners", Scene(mesh));
}

TEST_F(SimulateTest, PathThroughSurfacesOrOutOfTheScene) {
  ExpectFailure(3,
                "comes within",
                Scene("route: [[-2,0,1], [3,0,1]]\nobjects:\n"
                      "  - {type: box, at: [-1.5,0.3,0], size: [0.5,0.5,1.2]}\n"));
  ExpectFailure(3,
                "is inside a solid or outside the walls",
                Scene("route: [[-2,0,1], [3,0,1]]\nobjects:\n"
                      "  - {type: box, at: [0,0,-9], size: [20,20,20]}\n"));
  ExpectFailure(3,
                "leaves the scene",
                Scene("route: [[-2,0,5], [3,0,5]]\nobjects:\n"
                      "  - {type: box, at: [40,40,0], size: [0.5,0.5,0.5]}\n"));
}

TEST_F(SimulateTest, DamagedRecordedTrajectory) {
  WriteText(in_ / "truth.csv", "#t,p,q\n1000,1,2,3\n");
  ExpectFailure(3, "truth.csv:2: too few columns", "--trajectory " + (in_ / "truth.csv").string());
  std::string rows;
  for (int i = 0; i < 100; ++i)
    rows += std::to_string(1000000000LL + 5000000LL * i) + ",0,0,1,1,0,0,0\n";
  WriteText(in_ / "truth.csv", rows);
  const std::string flight = "--trajectory " + (in_ / "truth.csv").string();
  ExpectFailure(3, "have less than 1.45", flight);
  std::string samples;
  for (int i = 0; i < 1000; ++i) {
    const std::string t = std::to_string(1000000000LL + 5000000LL * i);
    samples += t + ",0,0,0,9.81,0,0\n";
    if (i >= 100) rows += t + ",0,0,1,1,0,0,0\n";
  }
  WriteText(in_ / "imu.csv", samples);
  const std::string with_imu = flight + " --imu " + (in_ / "imu.csv").string();
  ExpectFailure(3, "have less than 1.45", with_imu);
  WriteText(in_ / "truth.csv", rows);
  ExpectFailure(3, "need more than the", with_imu + " --duration 60");
}

TEST_F(SimulateTest, DamagedImuAndCalibration) {
  std::string rows;
  for (int i = 0; i < 1000; ++i)
    rows += std::to_string(1000000000LL + 5000000LL * i) + ",0,0,1,1,0,0,0\n";
  WriteText(in_ / "truth.csv", rows);
  WriteText(in_ / "imu.csv", "#t,gyro,accel\n1000000000,0,0\n");
  const std::string flight = "--trajectory " + (in_ / "truth.csv").string();
  ExpectFailure(3, "imu.csv:2: too few columns", flight + " --imu " + (in_ / "imu.csv").string());
  ExpectFailure(3, "nowhere.csv", flight + " --imu " + (in_ / "nowhere.csv").string());
  ExpectFailure(3, "nowhere", "--calibration " + (in_ / "nowhere").string());
}

TEST_F(SimulateTest, InterruptedLeavesNothing) {
  // In the foreground, or it signals the program twice: the second interrupt ends it at once.
  for (const std::string signal : {"INT", "HUP"}) {  // Ctrl-C, and a terminal that is closed
    const ProgramRun run = RunShell("timeout --foreground --preserve-status -s " + signal + " 2 " +
                                    Command("--duration 20 --trajectory hover"));
    Expect(run, 130, "interrupted; nothing was written");
  }
}

TEST_F(SimulateTest, DiskFullWithTheFirstImage) {
  const std::string scene = Scene(
      "route: [[-2,0,1], [2,0,1]]\nobjects:\n"
      "  - {type: mat, at: [0,0,0], size: [12,12]}\n"
      "  - {type: box, at: [0,3,0], size: [1,1,1]}\n");
  const ProgramRun run = RunShell(
      "(ulimit -f 60; " + Command(scene + " --duration 0.1 --set truth.max_points=100") + ")");
  Expect(run, 5, ".png: cannot be written");
}

TEST_F(SimulateTest, FullDisk) {
  // The shell limits the size of files; writing beyond it fails as on a full disk.
  const ProgramRun run = RunShell("(ulimit -f 200; " + Command("--duration 0.1") + ")");
  Expect(run, 5, "cannot be written (disk full, permissions?)");
}

}  // namespace
}  // namespace facet
