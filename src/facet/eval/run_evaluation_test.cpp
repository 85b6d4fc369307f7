// SPDX-License-Identifier: BSD-2-Clause
#include "facet/eval/run_evaluation.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "facet/eval/evaluation_json.h"
#include "facet/geometry/so3.h"
#include "facet/io/calibration_file.h"
#include "facet/io/calibration_writer.h"
#include "facet/io/errors.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

constexpr std::int64_t kStartNs = 1403636584763555584;

std::vector<StampedPose> Circle(int num_poses, std::int64_t interval_ns) {
  std::vector<StampedPose> poses;
  for (int i = 0; i < num_poses; ++i) {
    const std::int64_t ns = interval_ns * i;
    const double a = 1e-9 * static_cast<double>(ns);
    const SE3 T(ExpSO3({0, 0, a}), {2 * std::cos(a), 2 * std::sin(a), 0.1 * std::sin(3 * a)});
    poses.push_back({Timestamp{kStartNs + ns}, T});
  }
  return poses;
}

// A sequence folder with truth and 100 frames, and the result folder of a run over it.
class RunEvaluationTest : public ::testing::Test {
 public:
  ~RunEvaluationTest() override { fs::remove_all(folder_); }

 protected:
  RunEvaluationTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        fs::path(::testing::TempDir()) / ("facet_eval_" + std::to_string(getpid()) + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "seq/mav0/cam0");
    fs::create_directories(folder_ / "seq/mav0/state_groundtruth_estimate0");
    fs::create_directories(result());
    WriteEuroc(folder_ / "seq/mav0/state_groundtruth_estimate0/data.csv", Circle(1000, 5'000'000));
    Write("seq/mav0/cam0/data.csv", FrameTable());
    WriteTum(result() / "trajectory.tum", std::vector(Circle(90, 50'000'000)));
  }
  fs::path result() const { return folder_ / "result"; }
  fs::path sequence() const { return folder_ / "seq"; }

  static std::string FrameTable() {
    std::string text = "#timestamp [ns],filename\r\n";
    for (const StampedPose& pose : Circle(100, 50'000'000)) {
      text += std::to_string(pose.t.ns) + "," + std::to_string(pose.t.ns) + ".png\r\n";
    }
    return text;
  }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  static void WriteEuroc(const fs::path& file, const std::vector<StampedPose>& poses) {
    std::ofstream stream(file);
    stream.precision(15);
    stream << "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z\n";
    for (const auto& [t, T] : poses) {
      stream << t.ns << ',' << T.p.x() << ',' << T.p.y() << ',' << T.p.z() << ',' << T.q.w() << ','
             << T.q.x() << ',' << T.q.y() << ',' << T.q.z() << '\n';
    }
  }

  RunEvaluation Evaluate() const { return EvaluateRun(result(), LoadGroundTruth(sequence()), {}); }

  fs::path folder_;
};

TEST_F(RunEvaluationTest, PerfectRunHasNoErrorAndTheRightCoverage) {
  const RunEvaluation evaluation = Evaluate();
  EXPECT_EQ(evaluation.causal.num_pairs, 90);
  EXPECT_LT(evaluation.causal.ate_m.max, 1e-8);
  EXPECT_DOUBLE_EQ(*evaluation.coverage, 0.9);
  EXPECT_FALSE(evaluation.keyframes);
}

TEST_F(RunEvaluationTest, ACalibrationOfAnotherLensModelIsNotJudged) {
  for (const char* sensor : {"cam0", "cam1", "imu0"})
    fs::create_directories(sequence() / "truth" / sensor);
  Write("seq/truth/cam0/sensor.yaml", TestCameraYaml(0));
  Write("seq/truth/cam1/sensor.yaml", TestCameraYaml(1));
  Write("seq/truth/imu0/sensor.yaml", TestImuYaml());
  StereoRig rig = ReadEurocCalibration(sequence() / "truth", {}).rig;
  WriteText(result() / "calibration.yaml", CalibrationYaml(rig));
  EXPECT_TRUE(Evaluate().calibration.has_value());
  CameraIntrinsics k = rig.cameras[1].intrinsics();
  k.distortion = DistortionModel::kEquidistant;
  k.coefficients = {};
  rig.cameras[1] = CameraModel(k);
  WriteText(result() / "calibration.yaml", CalibrationYaml(rig));
  const RunEvaluation evaluation = Evaluate();
  EXPECT_FALSE(evaluation.calibration.has_value());
  EXPECT_THAT(evaluation.warnings, ElementsAre(HasSubstr("camera 1 has another model")));
}

TEST_F(RunEvaluationTest, QuaternionsInTheWrongOrderGiveAWarning) {
  EXPECT_TRUE(Evaluate().warnings.empty());
  std::vector<StampedPose> swapped = Circle(90, 50'000'000);
  for (StampedPose& pose : swapped) {
    const Quaterniond q = pose.T_WB.q;
    pose.T_WB.q = Quaterniond(q.z(), q.w(), q.x(), q.y());
  }
  WriteTum(result() / "trajectory.tum", swapped);
  EXPECT_THAT(Evaluate().warnings,
              ElementsAre(AllOf(HasSubstr("result: the orientations are off by"),
                                HasSubstr("TUM: qx qy qz qw"))));
  // The same file as truth.
  const GroundTruth truth = LoadGroundTruth(result() / "trajectory.tum");
  const RunEvaluation other =
      EvaluateRun(sequence() / "mav0/state_groundtruth_estimate0/data.csv", truth, {});
  EXPECT_THAT(other.warnings, ElementsAre(HasSubstr("or in " + truth.pose_file.string())));
}

TEST_F(RunEvaluationTest, CoverageFollowsTheSummaryOfTheRun) {
  Write("result/summary.json", R"({"frames": 95, "frames_with_pose": 90})");
  EXPECT_DOUBLE_EQ(*Evaluate().coverage, 90.0 / 95.0);
  Write("result/summary.json", "{ damaged");
  EXPECT_DOUBLE_EQ(*Evaluate().coverage, 0.9);
}

TEST_F(RunEvaluationTest, TruthFileHasNoCoverage) {
  const GroundTruth truth =
      LoadGroundTruth(sequence() / "mav0/state_groundtruth_estimate0/data.csv");
  const auto json = ToJson(EvaluateRun(result() / "trajectory.tum", truth, {}));
  EXPECT_FALSE(json.contains("coverage"));
  EXPECT_FALSE(json.contains("ate_keyframes"));
  EXPECT_FALSE(json.contains("mesh"));
  EXPECT_TRUE(json.contains("ate"));
}

TEST_F(RunEvaluationTest, AcceptsMav0ItselfAsSequence) {
  EXPECT_EQ(LoadGroundTruth(sequence() / "mav0").poses.size(), 1000u);
}

TEST_F(RunEvaluationTest, JudgesKeyframesWhenThereAreEnough) {
  WriteTum(result() / "keyframes.tum", std::vector(Circle(20, 200'000'000)));
  EXPECT_EQ(Evaluate().keyframes->num_pairs, 20);
  WriteTum(result() / "keyframes.tum", std::vector(Circle(2, 200'000'000)));
  EXPECT_FALSE(Evaluate().keyframes);
  Write("result/keyframes.tum", "");
  EXPECT_FALSE(Evaluate().keyframes);
}

TEST_F(RunEvaluationTest, WritesEveryFieldOfTheContract) {
  WriteTum(result() / "keyframes.tum", std::vector(Circle(20, 200'000'000)));
  WriteEvaluation(Evaluate());
  const auto json = nlohmann::json::parse(std::ifstream(result() / "evaluation.json"));
  for (const char* key :
       {"coverage", "ate", "ate_keyframes", "rpe", "drift_percent", "scale_error_percent"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  for (const char* key : {"rmse_m", "median_m", "mean_m", "max_m"}) {
    EXPECT_TRUE(json["ate"].contains(key)) << key;
  }
  for (const char* key : {"length_m",
                          "translation_median_m",
                          "translation_rmse_m",
                          "rotation_median_deg",
                          "rotation_rmse_deg",
                          "pairs"}) {
    EXPECT_TRUE(json["rpe"][0].contains(key)) << key;
  }
  EXPECT_FALSE(fs::exists(result() / "evaluation.json.partial"));
}

TEST_F(RunEvaluationTest, FileResultsAreWrittenBeside) {
  EXPECT_EQ(EvaluationFile(result() / "trajectory.tum"),
            result() / "trajectory.tum.evaluation.json");
  EXPECT_EQ(EvaluationFile(result()), result() / "evaluation.json");
}

TEST_F(RunEvaluationTest, TableHasOneColumnPerRun) {
  const std::vector<RunEvaluation> both = {Evaluate(), Evaluate()};
  const std::string table = FormatTable(both);
  EXPECT_THAT(table, HasSubstr("ATE rmse [m]"));
  EXPECT_THAT(table, HasSubstr("90.0        90.0"));
  EXPECT_THAT(table, Not(HasSubstr("nan")));
}

TEST_F(RunEvaluationTest, ColumnsAreNamedByWhatTellsThemApart) {
  std::vector<RunEvaluation> runs(3);
  runs[0].result = "study/S/start_0.0";
  runs[1].result = "study/SPR/start_0.0/";
  runs[2].result = "other/../study/SP/start_0.1";
  EXPECT_THAT(ColumnNames(runs), ElementsAre("S/start_0.0", "SPR/start_0.0", "SP/start_0.1"));
  runs[1].result = "study/S/x.tum";
  EXPECT_THAT(ColumnNames(runs), ElementsAre("start_0.0", "x.tum", "start_0.1"));
  runs[1] = runs[2] = runs[0];
  EXPECT_THAT(ColumnNames(runs), ElementsAre("start_0.0", "start_0.0", "start_0.0"));
}

TEST_F(RunEvaluationTest, RefusesWhatCannotBeJudged) {
  const auto message_of = [&](const std::string& text) {
    Write("result/trajectory.tum", text);
    try {
      Evaluate();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string pose = " 0 0 0 0 0 0 1\n";
  EXPECT_THAT(message_of("1.0" + pose + "2.0" + pose + "3.0" + pose), HasSubstr("no overlap"));
  EXPECT_THAT(message_of("1403636585.0" + pose + "1403636586.0" + pose), HasSubstr("at least 3"));
  EXPECT_THAT(message_of("1403636585.0 nan 0 0 0 0 0 1\n"), HasSubstr("trajectory.tum:1"));
  EXPECT_THAT(message_of("1403636585.0 0 0 0 0 0 0 2\n"), HasSubstr("norm"));
  EXPECT_THAT(message_of("1403636585.5,0,0,0,1,0,0,0\n"), HasSubstr("seconds"));
  EXPECT_THAT(message_of("2.0" + pose + "1.0" + pose), HasSubstr("backwards"));
  EXPECT_THAT(message_of(""), HasSubstr("no pose"));
  EXPECT_FALSE(fs::exists(result() / "evaluation.json"));
}

TEST_F(RunEvaluationTest, NamesMissingFiles) {
  EXPECT_THAT([&] { LoadGroundTruth(folder_ / "result"); },
              ThrowsMessage<InputError>(HasSubstr("no ground truth")));
  fs::remove(result() / "trajectory.tum");
  EXPECT_THAT([&] { Evaluate(); }, ThrowsMessage<InputError>(HasSubstr("result folder")));
  fs::remove(result());
  EXPECT_THAT([&] { Evaluate(); }, ThrowsMessage<InputError>(HasSubstr("no such file or folder")));
}

TEST_F(RunEvaluationTest, UnwritableFolderIsAnOutputError) {
  RunEvaluation evaluation = Evaluate();
  evaluation.result = folder_ / "gone" / "trajectory.tum";
  EXPECT_THAT([&] { WriteEvaluation(evaluation); },
              ThrowsMessage<OutputError>(HasSubstr("cannot be written")));
}

}  // namespace
}  // namespace facet
