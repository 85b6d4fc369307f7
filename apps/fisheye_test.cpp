// SPDX-License-Identifier: BSD-2-Clause
// A flight that is seen through fisheye lenses, from the simulator to the planes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "facet/io/calibration_writer.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/io/program_run.h"
#include "facet/testing/io/test_sequence.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

// Lenses like those of TUM VI on EuRoC's vehicle: 190 degrees along the diagonal.
StereoRig FisheyeRig() {
  StereoRig rig = EurocRig();
  for (int i = 0; i < 2; ++i) {
    CameraIntrinsics k;
    k.width = k.height = 512;
    k.fx = k.fy = 191 - 0.5 * i;
    k.cx = 254.9 - 2 * i;
    k.cy = 256.9 - 2 * i;
    k.distortion = DistortionModel::kEquidistant;
    k.coefficients = {0.0035, 0.0007, -0.0021, 0.0002};
    rig.cameras[i] = CameraModel(k);
  }
  return rig;
}

TEST(FisheyeTest, FindsThePlanesOfARoom) {
  const TempFolder folder;
  const std::string sequence = (folder / "room").string(), out = (folder / "out").string();
  WriteCalibration(folder / "camchain.yaml", FisheyeRig());
  const ProgramRun made = RunFacet(
      "simulate --quiet --scene room --seed 61 --duration 8 --set image.rays_per_pixel=1 --set "
      "image.max_rays_per_pixel=2 --calibration " +
      (folder / "camchain.yaml").string() + " --out " + sequence);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const ProgramRun run = RunFacet("run " + sequence + " --quiet --out " + out);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const ProgramRun judged = RunFacet("evaluate " + out + " --truth " + sequence);
  ASSERT_EQ(judged.exit_code, 0) << judged.err;
  const auto figures = nlohmann::json::parse(ReadText(folder / "out/evaluation.json"));
  EXPECT_LT(figures["ate"]["rmse_m"], 0.01);
  EXPECT_GT(figures["planes"]["recall"], 0.15) << "of what 170 degrees show within 8 s";
  EXPECT_GT(figures["planes"]["precision"], 0.9);
  EXPECT_GT(figures["map"]["completeness_10cm"], 0.3);
}

}  // namespace
}  // namespace facet
