// SPDX-License-Identifier: BSD-2-Clause
// Runs `facet evaluate` on damaged results and truths: exit code 3, one line that says where and
// what, and nothing half-written.
#include <algorithm>
#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/io/ply_writer.h"
#include "facet/io/trajectory_file.h"
#include "facet/testing/folders.h"
#include "facet/testing/io/program_run.h"

namespace facet {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr std::int64_t kStartNs = 1403636584763555584;

TriangleMesh OneTriangle() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}};
  return mesh;
}

class EvaluateInputTest : public ::testing::Test {
 protected:
  EvaluateInputTest() {
    std::string truth = "#timestamp,px,py,pz,qw,qx,qy,qz,vx,vy,vz,bwx,bwy,bwz,bax,bay,baz\n";
    std::vector<StampedPose> poses;
    for (int i = 0; i < 200; ++i) {
      const std::int64_t ns = kStartNs + 10'000'000LL * i;
      const Vector3d p(std::cos(0.03 * i), std::sin(0.03 * i), 0.001 * i);
      truth += std::to_string(ns) + "," + std::to_string(p.x()) + "," + std::to_string(p.y()) +
               "," + std::to_string(p.z()) + ",1,0,0,0,0,0,0,0,0,0,0,0,0\n";
      if (i % 5 == 0) poses.push_back({Timestamp{ns}, SE3(Quaterniond::Identity(), p)});
    }
    WriteText(Truth(), truth);
    WriteText(Sequence() / "mav0" / "cam0" / "data.csv", "#timestamp,file\n");
    fs::create_directories(Result());
    WriteTum(Result() / "trajectory.tum", poses);
    fs::create_directories(Sequence() / "truth");
    WritePlyMesh(Sequence() / "truth" / "mesh.ply", OneTriangle());
  }

  fs::path Sequence() const { return folder_ / "seq"; }
  fs::path Truth() const {
    return Sequence() / "mav0" / "state_groundtruth_estimate0" / "data.csv";
  }
  fs::path Result() const { return folder_ / "result"; }
  fs::path Trajectory() const { return Result() / "trajectory.tum"; }

  ProgramRun Evaluate(const std::string& more = "") const {
    return RunFacet("evaluate " + Result().string() + " --truth " + Sequence().string() +
                    " --report " + (folder_ / "report").string() + " " + more);
  }

  void ExpectRefused(const std::string& text) const {
    const ProgramRun run = Evaluate();
    EXPECT_EQ(run.exit_code, 3) << run.out;
    EXPECT_THAT(run.err, ::testing::StartsWith("facet: error: "));
    EXPECT_THAT(run.err, HasSubstr(text));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(fs::exists(Result() / "evaluation.json"));
    EXPECT_FALSE(fs::exists(Result() / "evaluation.json.partial"));
    EXPECT_FALSE(fs::exists(folder_ / "report"));
  }

  void ReplaceLine(const fs::path& file, std::size_t line, const std::string& text) const {
    EditLines(file, [&](std::vector<std::string>& lines) { lines.at(line - 1) = text; });
  }

  TempFolder folder_;
};

TEST_F(EvaluateInputTest, GoodInputIsJudged) {
  const ProgramRun run = Evaluate("--align-time --alignment yaw");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(Result() / "evaluation.json"));
  EXPECT_TRUE(fs::exists(folder_ / "report" / "report.html"));
}

TEST_F(EvaluateInputTest, TruthOfAMotionCaptureSystemIsFound) {
  // As in TUM-VI: poses only.
  EditLines(Truth(), [](std::vector<std::string>& lines) {
    for (std::string& line : lines) {
      std::size_t end = 0;
      for (int i = 0; i < 8; ++i)
        end = line.find(',', end) + 1;
      line.resize(end - 1);
    }
  });
  fs::rename(Truth().parent_path(), Sequence() / "mav0" / "mocap0");
  const ProgramRun run = Evaluate("--parts trajectory");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto evaluation = nlohmann::json::parse(ReadText(Result() / "evaluation.json"));
  EXPECT_LT(evaluation["ate"]["rmse_m"].get<double>(), 1e-5);
}

TEST_F(EvaluateInputTest, NoOverlapInTime) {
  EditLines(Trajectory(), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i][2] = '9';
  });
  ExpectRefused("result: no overlap in time: the trajectory covers 1493636584.76");
  ExpectRefused("state_groundtruth_estimate0/data.csv");
}

TEST_F(EvaluateInputTest, FewerThanThreePoses) {
  EditLines(Trajectory(), [](std::vector<std::string>& lines) { lines.resize(3); });
  ExpectRefused("result: the trajectory has 2 poses; at least 3 are needed");
}

TEST_F(EvaluateInputTest, NotANumber) {
  ReplaceLine(Trajectory(), 7, "1403636585.0 0 nan 0 0 0 0 1");
  ExpectRefused("trajectory.tum:7: column 3 is 'nan', a finite number is expected");
}

TEST_F(EvaluateInputTest, NotANumberInTheTruth) {
  ReplaceLine(Truth(), 9, std::to_string(kStartNs + 1) + ",nan,0,0,1,0,0,0");
  ExpectRefused("data.csv:9: column 2 is 'nan'");
}

TEST_F(EvaluateInputTest, WrongQuaternionNorm) {
  ReplaceLine(Trajectory(), 4, "1403636584.9 0 0 0 0.5 0.5 0.5 0.9");
  ExpectRefused("trajectory.tum:4: the quaternion has norm 1.24");
}

TEST_F(EvaluateInputTest, SecondsWhereNanosecondsAreExpected) {
  EditLines(Truth(), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i].insert(10, 1, '.');
  });
  ExpectRefused("data.csv:2: stamp '1403636584.763555584' looks like seconds");
  ExpectRefused("nanoseconds");
}

TEST_F(EvaluateInputTest, MillisecondsWhereNanosecondsAreExpected) {
  EditLines(Truth(), [](std::vector<std::string>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
      lines[i].erase(13, 6);
  });
  ExpectRefused("must be nanoseconds");
}

TEST_F(EvaluateInputTest, EmptyMesh) {
  TriangleMesh mesh = OneTriangle();
  mesh.faces.clear();
  WritePlyMesh(Result() / "map.ply", mesh);
  ExpectRefused("map.ply: an empty mesh, 3 vertices and 0 faces without area");
  EXPECT_EQ(Evaluate("--parts trajectory").exit_code, 0);
}

TEST_F(EvaluateInputTest, MeshInMillimetres) {
  TriangleMesh mesh = OneTriangle();
  for (Vector3d& p : mesh.vertices)
    p *= 1e4;
  WritePlyMesh(Result() / "map.ply", mesh);
  ExpectRefused("map.ply: the mesh has an area of 5e+07 m2; vertices must be in metres");
}

TEST_F(EvaluateInputTest, StatesCutShort) {
  WriteText(Result() / "states.csv",
            "timestamp_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,sigma_px,sigma_rx\n" +
                std::to_string(kStartNs) + ",0,0,0,1,0,0,0,0,0,0,1,1\n" +
                std::to_string(kStartNs + 1) + ",0,0,0,1,0\n");
  ExpectRefused("states.csv:3: 6 columns, the header has 13");
}

TEST_F(EvaluateInputTest, DamagedMesh) {
  WritePlyMesh(Result() / "mesh.ply", OneTriangle());
  Truncate(Result() / "mesh.ply", fs::file_size(Result() / "mesh.ply") - 3);
  ExpectRefused("mesh.ply: face 0: the file ends here");
}

TEST_F(EvaluateInputTest, MorePlanesThanAnyRunHas) {
  WriteText(Sequence() / "truth" / "planes.csv", "#plane,nx,ny,nz,d,area,seen area,label\n");
  std::string text = "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first,last,landmarks,area_m2\n";
  for (int i = 0; i < 100'000; ++i)
    text += std::to_string(i) + ",0,0,1,0,0,0,0,horizontal,floor,1,2,9,1.5\n";
  WriteText(Result() / "planes.csv", text);
  ExpectRefused("result/planes.csv:20002: more than 20000 planes");
}

TEST_F(EvaluateInputTest, PlanesAreJudgedTwice) {
  WriteText(Sequence() / "truth" / "planes.csv",
            "#plane,nx,ny,nz,d,area,seen area,label\n0,0,0,1,0,5,5,floor\n");
  WriteText(
      Result() / "planes.csv",
      "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first_seen_ns,last_seen_ns,landmarks,area_m2\n"
      "1,0,0,1,0.08,0,0,0.08,horizontal,floor,1,2,9,1.5\n");
  EXPECT_EQ(Evaluate().exit_code, 0);
  const auto planes = nlohmann::json::parse(ReadText(Result() / "evaluation.json"))["planes"];
  EXPECT_EQ(planes["recall"], 1);
  EXPECT_EQ(planes["precision"], 1);
  EXPECT_EQ(planes["within_3deg_5cm"]["recall"], 0);
  EXPECT_EQ(planes["within_3deg_5cm"]["precision"], 0);
  EXPECT_EQ(planes["within_3deg_2percent"]["precision"], 0);  // less than 4 m away
}

TEST_F(EvaluateInputTest, SceneWithoutPlanes) {
  const std::string header =
      "id,nx,ny,nz,d,cx,cy,cz,orientation,label,first_seen_ns,last_seen_ns,landmarks,area_m2\n";
  WriteText(Sequence() / "truth" / "planes.csv", "#plane,nx,ny,nz,d,area,seen area,label\n");
  WriteText(Result() / "planes.csv", header);
  EXPECT_EQ(Evaluate().exit_code, 0);
  nlohmann::json planes = nlohmann::json::parse(ReadText(Result() / "evaluation.json"))["planes"];
  EXPECT_FALSE(planes.contains("recall"));
  EXPECT_FALSE(planes.contains("precision"));
  WriteText(Result() / "planes.csv", header + "1,0,0,1,0,0,0,0,horizontal,floor,1,2,9,1.5\n");
  EXPECT_EQ(Evaluate().exit_code, 0);
  planes = nlohmann::json::parse(ReadText(Result() / "evaluation.json"))["planes"];
  EXPECT_FALSE(planes.contains("recall"));
  EXPECT_EQ(planes["precision"], 0);
}

TEST_F(EvaluateInputTest, PlanesFileThatEndsInItsHeader) {
  WriteText(Result() / "planes.csv", "id,nx,ny,nz,d,cx,cy,cz\n");
  WriteText(Sequence() / "truth" / "planes.csv", "#plane,nx,ny,");
  ExpectRefused("truth/planes.csv:1: the truth holds no plane");
}

TEST_F(EvaluateInputTest, EstimatedPlanesWithoutHeader) {
  WriteText(Sequence() / "truth" / "planes.csv", "#plane,nx,ny,nz,d,area,seen area,label\n");
  WriteText(Result() / "planes.csv", "");
  ExpectRefused("result/planes.csv:1: neither a plane nor a header");
}

TEST_F(EvaluateInputTest, DamagedPlanes) {
  WriteText(Sequence() / "truth" / "planes.csv", "#p,nx,ny,nz,d,a,s\n0,0,0,1,0,5,5\n");
  WriteText(Result() / "planes.csv", "id,nx,ny,nz,d,cx,cy,cz\n1,0,0,3,0,0,0,0\n");
  ExpectRefused("result/planes.csv:2: the normal has norm 3");
}

TEST_F(EvaluateInputTest, ABadRunToCompareWithLeavesNothingBehind) {
  const ProgramRun run = Evaluate("--against " + (folder_ / "none").string());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("none: there is no such file or folder"));
  EXPECT_FALSE(fs::exists(Result() / "evaluation.json"));
}

TEST_F(EvaluateInputTest, APartThatIsNamedMustBeThere) {
  const auto expect = [&](const std::string& part, const std::string& text) {
    const ProgramRun run = Evaluate("--parts " + part);
    EXPECT_EQ(run.exit_code, 3) << part;
    EXPECT_THAT(run.err, HasSubstr(text));
    EXPECT_FALSE(fs::exists(Result() / "evaluation.json"));
  };
  expect("planes", "seq: there is no list of true planes (truth/planes.csv)");
  expect("mesh", "result: there is no mesh");
  fs::remove(Sequence() / "truth" / "mesh.ply");
  expect("mesh", "seq: there is no true surface");
  expect("trajectory,consistency", "result: there is no states.csv");
  WriteText(Sequence() / "truth" / "planes.csv", "#plane,nx,ny,nz,d,area,seen area,label\n");
  expect("planes", "result: there is no planes.csv");
}

TEST_F(EvaluateInputTest, LengthsMustBePositiveNumbers) {
  for (const char* text : {"-3", "0", "nan", "two"}) {
    const ProgramRun run = Evaluate(std::string("--rpe-lengths 1,") + text);
    EXPECT_EQ(run.exit_code, 2) << text;
    EXPECT_THAT(run.err, HasSubstr("'" + std::string(text) + "' is not a positive number"));
  }
}

TEST_F(EvaluateInputTest, UnknownPart) {
  EXPECT_EQ(Evaluate("--parts wings").exit_code, 2);
}

TEST_F(EvaluateInputTest, ReportFolderThatCannotBeCreated) {
  WriteText(folder_ / "report", "a file");
  const ProgramRun run = Evaluate();
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("cannot be created"));
}

// ------------------------------------------------------------------------------- facet compare

class CompareInputTest : public ::testing::Test {
 protected:
  CompareInputTest() {
    WriteTestSequence(Sequence());
    std::string truth;
    for (int i = 0; i < 200; ++i)
      truth += std::to_string(kStartNs + 5'000'000LL * i) + ",0,0,0,1,0,0,0\n";
    WriteText(Truth(), truth);
  }
  fs::path Sequence() const { return folder_ / "seq"; }
  fs::path Truth() const {
    return Sequence() / "mav0" / "state_groundtruth_estimate0" / "data.csv";
  }
  ProgramRun Compare(const std::string& more) const {
    return RunFacet("compare " + Sequence().string() + " --out " + (folder_ / "out").string() +
                    " --starts 2 " + more);
  }
  void MakeImagesGrey() const {
    const std::string grey = "P5\n160 120\n255\n" + std::string(160 * 120, 'x');
    for (const char* camera : {"cam0", "cam1"}) {
      for (const auto& image : fs::directory_iterator(Sequence() / "mav0" / camera / "data"))
        WriteText(image, grey);
    }
  }

  TempFolder folder_;
};

TEST_F(CompareInputTest, RefusesBeforeTheFirstRun) {
  fs::remove(Truth());
  const ProgramRun run = Compare("");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("the sequence has no ground truth"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(CompareInputTest, WrongUsage) {
  EXPECT_THAT(Compare("--config x").err, HasSubstr("NAME=FILE is expected"));
  EXPECT_THAT(Compare("--config a=/nowhere.yaml").err, HasSubstr("nowhere.yaml"));
  EXPECT_THAT(Compare("--set nonsense=1").err, HasSubstr("unknown key 'nonsense'"));
  EXPECT_EQ(Compare("--set nonsense=1").exit_code, 2);
  EXPECT_EQ(Compare("--pipelines X").exit_code, 2);
  EXPECT_EQ(Compare("--starts 0").exit_code, 2);
  EXPECT_THAT(Compare("--duration 0").err, HasSubstr("--duration: '0' is not a positive number;"));
  EXPECT_THAT(Compare(Sequence().string()).err, HasSubstr("another sequence has the name 'seq'"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(CompareInputTest, RunsWithoutResultAreListedWithTheirReason) {
  // Nothing to see in grey images: no run can start, and the study says so instead of stopping.
  MakeImagesGrey();
  const ProgramRun run = Compare("--pipelines S");
  EXPECT_EQ(run.exit_code, 4) << run.err;
  EXPECT_THAT(run.out, HasSubstr("Runs without a result"));
  for (const char* file : {"comparison.json", "comparison.csv", "comparison.md", "comparison.html"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
}

// A folder like a download of EuRoC: places with sequences, one of them not unpacked yet, names
// with blanks around them.
TEST_F(CompareInputTest, TablesOfThePaperForADownload) {
  MakeImagesGrey();
  const fs::path euroc = folder_ / "my EuRoC";
  fs::create_directories(euroc / "vicon_room1" / "V1_02_medium");
  fs::create_directories(euroc / "machine_hall" / "MH_01_easy");
  fs::create_directories(euroc / "V1_01_easy" / "V1_01_easy");
  fs::create_directory_symlink(Sequence() / "mav0", euroc / "machine_hall/MH_01_easy/mav0");
  fs::create_directory_symlink(Sequence() / "mav0", euroc / "V1_01_easy/V1_01_easy/mav0");
  const std::string script = "FACET=" + std::string(FACET_PROGRAM) + " sh " +
                             testing::SourceFolder().string() + "/scripts/run_euroc.sh '" +
                             euroc.string() + "' --out '" + (euroc / "study").string() +
                             "' --starts 1 --pipelines S,SPR";
  const ProgramRun run = RunShell(script);
  EXPECT_EQ(run.exit_code, 4) << run.err;  // grey
  EXPECT_THAT(run.out, HasSubstr("sequences: MH_01_easy V1_01_easy\n"));
  EXPECT_THAT(run.err, HasSubstr("V1_02_medium: no mav0/ in it (not unpacked?), left out"));
  const std::string table = ReadText(euroc / "study" / "comparison.md");
  EXPECT_THAT(table, HasSubstr("| 13.7 | 15.0 | 12.4 | 15.0 | 10.7 | 14.5 |"));
  EXPECT_THAT(table, HasSubstr("| V1_01_easy | 9 | 34 | 10 | 7 | 7 | 6 |"));
  EXPECT_EQ(
      RunShell("FACET=" + std::string(FACET_PROGRAM) + " sh " + testing::SourceFolder().string() +
               "/scripts/run_euroc.sh " + (folder_ / "nowhere").string())
          .exit_code,
      3);
}

}  // namespace
}  // namespace facet
