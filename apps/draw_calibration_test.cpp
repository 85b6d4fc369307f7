// SPDX-License-Identifier: BSD-2-Clause
// Runs `facet simulate` with drawn calibrations and lenses that do not obey their model.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "facet/calibration/rig_parameters.h"
#include "facet/io/asl_dataset.h"
#include "facet/io/calibration_file.h"
#include "facet/render/sequence_writer.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class DrawCalibrationTest : public ::testing::Test {
 protected:
  DrawCalibrationTest() {
    WriteText(in_ / "scene.yaml",
              "route: [[-2,0,1], [2,0,1]]\nobjects:\n"
              "  - {type: mat, at: [0,0,0], size: [12,12]}\n"
              "  - {type: box, at: [0,3,0], size: [1,1,1]}\n");
  }

  /// Writes a sequence into `name`; expects this exit code. Returns what was on stderr.
  std::string Simulate(const std::string& name, const std::string& arguments, int exit_code = 0) {
    const std::string command = std::string(FACET_PROGRAM) + " simulate --quiet --out " +
                                (out_ / name).string() + " " + arguments + " >/dev/null 2>" +
                                (in_ / "err").string() + " </dev/null";
    // The command consists of constants and temporary folders of this test.
    const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe)
    const std::string err = ReadText(in_ / "err");
    EXPECT_EQ(WEXITSTATUS(status), exit_code) << err;
    return err;
  }

  std::string Scene() const {
    return "--scene " + (in_ / "scene.yaml").string() +
           " --duration 0.1 --set truth.max_points=100 ";
  }

  StereoRig Written(const std::string& name) const {
    return ReadEurocCalibration(out_ / name / "mav0", {}).rig;
  }
  StereoRig Exact(const std::string& name) const {
    return ReadEurocCalibration(out_ / name / "truth", {}).rig;
  }
  /// Of the first left image.
  fs::path Image(const std::string& name) const {
    const fs::path folder = out_ / name / "mav0" / "cam0" / "data";
    fs::path first;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (first.empty() || entry.path() < first) first = entry.path();
    }
    return first;
  }

  TempFolder in_, out_;
};

double Fx(const StereoRig& rig) {
  return rig.cameras[0].intrinsics().fx;
}

/// But for the digits that a calibration file does not have.
void ExpectSameRig(const StereoRig& a, const StereoRig& b) {
  EXPECT_LT(ParameterDifference(a, b).norm(), 1e-6);
  EXPECT_LT((a.T_BC[0].p - b.T_BC[0].p).norm(), 1e-9);
  EXPECT_LT(a.T_BC[0].q.angularDistance(b.T_BC[0].q), 1e-9);
  EXPECT_EQ(a.time_offset, b.time_offset);
  EXPECT_LT((a.gyro_scale - b.gyro_scale).norm(), 1e-9);
}

std::vector<ImuSample> Imu(const fs::path& sequence) {
  return AslDataset(sequence).imu();
}

/// How much the readings differ at most, in rad/s and m/s^2.
double ImuDifference(const std::vector<ImuSample>& a, const std::vector<ImuSample>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    largest = std::max({largest,
                        (a[i].gyro - b[i].gyro).cwiseAbs().maxCoeff(),
                        (a[i].accel - b[i].accel).cwiseAbs().maxCoeff()});
  }
  return largest;
}

TEST_F(DrawCalibrationTest, IsWrittenInPlaceOfTheExactOneAndChangesNoImage) {
  Simulate("exact", Scene());
  Simulate("drawn", Scene() + "--draw-calibration 3");
  EXPECT_EQ(ReadText(out_ / "exact" / "mav0" / "cam0" / "sensor.yaml"),
            ReadText(out_ / "drawn" / "truth" / "cam0" / "sensor.yaml"));
  EXPECT_EQ(ReadText(Image("exact")), ReadText(Image("drawn")));
  EXPECT_NE(Fx(Written("drawn")), Fx(Exact("drawn")));
  EXPECT_NEAR(Fx(Written("drawn")), Fx(Exact("drawn")), 1.5);
  EXPECT_NE(Written("drawn").time_offset.ns, 0);
  EXPECT_EQ(Exact("drawn").time_offset.ns, 0);
  // The IMU has errors that the calibration does not know.
  EXPECT_TRUE(Written("drawn").gyro_scale.isZero(0));
  EXPECT_GT(Exact("drawn").gyro_scale.norm(), 1e-4);
  const double difference = ImuDifference(Imu(out_ / "exact"), Imu(out_ / "drawn"));
  EXPECT_GT(difference, 1e-3);
  EXPECT_LT(difference, 0.2) << "a per cent of gravity and more";
}

TEST_F(DrawCalibrationTest, ACopyHasTheSameDrawAndLinksTheImages) {
  Simulate("exact", Scene());
  Simulate("drawn", Scene() + "--draw-calibration 3");
  Simulate("copy", "--of " + (out_ / "exact").string() + " --draw-calibration 3");
  ExpectSameRig(Written("copy"), Written("drawn"));
  ExpectSameRig(Exact("copy"), Exact("drawn"));
  EXPECT_LT(ImuDifference(Imu(out_ / "copy"), Imu(out_ / "drawn")), 1e-9);
  for (const char* file : {"mav0/cam0/data.csv", "truth/planes.csv"}) {
    EXPECT_EQ(ReadText(out_ / "copy" / file), ReadText(out_ / "drawn" / file)) << file;
  }
  EXPECT_TRUE(fs::equivalent(Image("exact"), Image("copy")));
}

TEST_F(DrawCalibrationTest, ACopyOfADrawnSequenceStartsFromItsExactCalibration) {
  Simulate("drawn", Scene() + "--draw-calibration 3");
  const std::string before = ReadText(out_ / "drawn" / "mav0" / "cam1" / "sensor.yaml");
  Simulate("other", "--of " + (out_ / "drawn").string() + " --draw-calibration 4");
  Simulate("direct", Scene() + "--draw-calibration 4");
  ExpectSameRig(Written("other"), Written("direct"));
  EXPECT_EQ(Fx(Exact("other")), Fx(Exact("drawn")));
  // Another calibration of the same IMU.
  EXPECT_EQ(Exact("other").gyro_scale, Exact("drawn").gyro_scale);
  EXPECT_LT(ImuDifference(Imu(out_ / "other"), Imu(out_ / "drawn")), 1e-9);
  EXPECT_EQ(ReadText(out_ / "drawn" / "mav0" / "cam1" / "sensor.yaml"), before);
}

TEST_F(DrawCalibrationTest, ACopyKeepsErrorsOfTheImuThatNoCalibrationHas) {
  Simulate("drawn", Scene() + "--draw-calibration 3 --set calibration.imu_scale_percent=0");
  EXPECT_TRUE(Exact("drawn").gyro_scale.isZero(0));
  Simulate("other", "--of " + (out_ / "drawn").string() + " --draw-calibration 4");
  EXPECT_LT(ImuDifference(Imu(out_ / "other"), Imu(out_ / "drawn")), 1e-9);
  EXPECT_EQ(ReadText(out_ / "other" / "truth" / "imu0" / "errors.yaml"),
            ReadText(out_ / "drawn" / "truth" / "imu0" / "errors.yaml"));

  // A fault multiplies them.
  Simulate("faulty", "--of " + (out_ / "drawn").string() + " --fault gyro_scaled:percent=1");
  const Matrix3d before = ReadImuErrors(out_ / "drawn")->of_gyro;
  const Matrix3d after = ReadImuErrors(out_ / "faulty")->of_gyro;
  EXPECT_LT((after - 1.01 * before).norm(), 1e-9);
  // No calibration may say of a scale what a gross one does.
  Simulate("gross", "--of " + (out_ / "drawn").string() + " --fault gyro_scaled:percent=80");
  EXPECT_TRUE(Exact("gross").gyro_scale.isZero(0));
  Simulate("of_gross", "--of " + (out_ / "gross").string() + " --draw-calibration 4");
  EXPECT_LT((ReadImuErrors(out_ / "of_gross")->of_gyro - 1.8 * before).norm(), 1e-9);
  WriteText(out_ / "faulty" / "truth" / "imu0" / "errors.yaml",
            "of_gyro: [1, 0, 0, 0, .nan, 0, 0, 0, 1]\n");
  EXPECT_THAT(Simulate("x", "--of " + (out_ / "faulty").string() + " --draw-calibration 4", 3),
              HasSubstr("errors.yaml:1: "));
  WriteText(out_ / "faulty" / "truth" / "imu0" / "errors.yaml", "of_gyro: [1, 0, 0]\n");
  EXPECT_THAT(Simulate("x", "--of " + (out_ / "faulty").string() + " --draw-calibration 4", 3),
              HasSubstr("errors.yaml:1: a matrix has nine numbers"));
}

TEST_F(DrawCalibrationTest, PartsCanBeDrawnAlone) {
  Simulate("exact", Scene());
  const std::string source = "--of " + (out_ / "exact").string() + " --draw-calibration 3 ";
  Simulate("time", source + "--draw-parts time");
  EXPECT_EQ(Fx(Written("time")), Fx(Written("exact")));
  EXPECT_NE(Written("time").time_offset.ns, 0);
  EXPECT_LT(ImuDifference(Imu(out_ / "time"), Imu(out_ / "exact")), 1e-9);
  Simulate("scale", source + "--draw-parts scale");
  ExpectSameRig(Written("scale"), Written("exact"));
  EXPECT_GT(ImuDifference(Imu(out_ / "scale"), Imu(out_ / "exact")), 1e-3);
  Simulate("rest", source + "--draw-parts lens,imu");
  EXPECT_NE(Fx(Written("rest")), Fx(Written("exact")));
  EXPECT_EQ(Written("rest").time_offset.ns, 0);
}

TEST_F(DrawCalibrationTest, FaultsKeepTheExactCalibrationInTruth) {
  Simulate("exact", Scene());
  Simulate("faulty", "--of " + (out_ / "exact").string() + " --fault focal:percent=1");
  EXPECT_NEAR(Fx(Written("faulty")), 1.01 * Fx(Written("exact")), 1e-6);
  EXPECT_EQ(Fx(Exact("faulty")), Fx(Written("exact")));
}

TEST_F(DrawCalibrationTest, LensMisfitChangesImagesAndTruthOnly) {
  Simulate("exact", Scene());
  Simulate("misfit", Scene() + "--lens-misfit 1");
  EXPECT_EQ(ReadText(out_ / "exact" / "mav0" / "cam0" / "sensor.yaml"),
            ReadText(out_ / "misfit" / "mav0" / "cam0" / "sensor.yaml"));
  EXPECT_NE(ReadText(Image("exact")), ReadText(Image("misfit")));
  EXPECT_TRUE(Exact("misfit").HasLensModes());
  EXPECT_FALSE(Exact("exact").HasLensModes());
  Simulate("drawn", "--of " + (out_ / "misfit").string() + " --draw-calibration 1");
  EXPECT_FALSE(Written("drawn").HasLensModes());
  EXPECT_EQ(Exact("drawn").lens_modes, Exact("misfit").lens_modes);
}

TEST_F(DrawCalibrationTest, WrongUsageSaysWhatToDo) {
  EXPECT_THAT(Simulate("x", Scene() + "--calibration-error", 2),
              HasSubstr("--calibration-error: is no option any more; --draw-calibration SEED"));
  EXPECT_THAT(Simulate("x", Scene() + "--draw-calibration 1 --draw-parts lens,focus", 2),
              HasSubstr("--draw-parts focus: no such part; known: lens, imu, time, scale"));
  EXPECT_THAT(Simulate("x", Scene() + "--draw-parts lens", 2),
              HasSubstr("--draw-parts requires --draw-calibration"));
  EXPECT_THAT(Simulate("x", Scene() + "--draw-calibration -1", 2), HasSubstr("--draw-calibration"));
  EXPECT_THAT(Simulate("x", "--of somewhere", 2), HasSubstr("or --draw-calibration SEED"));
  EXPECT_THAT(Simulate("x", "--of somewhere --draw-calibration 1 --lens-misfit 1", 2),
              HasSubstr("--lens-misfit: nothing is rendered"));
}

}  // namespace
}  // namespace facet
