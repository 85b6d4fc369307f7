// SPDX-License-Identifier: BSD-2-Clause
// config/paper.yaml changes what it says and nothing else.
#include <map>
#include <string>

#include "load_options.h"
#include <gtest/gtest.h>

#include "facet/io/config_file.h"
#include "facet/testing/folders.h"

namespace facet {
namespace {

std::string ConfigFile(const std::string& name) {
  return testing::SourceFolder() / "config" / name;
}

std::map<std::string, std::string> ValuesOf(VioOptions options) {
  std::map<std::string, std::string> out;
  for (const ConfigField& field : ListFields(options))
    out[field.key] = FormatValue(field);
  return out;
}

TEST(PaperConfigTest, DiffersFromTheDefaultsInTheListedKeysOnly) {
  const auto defaults = ValuesOf(VioOptions());
  const auto paper = ValuesOf(LoadOptions(ConfigFile("paper.yaml"), {}).options);
  std::map<std::string, std::string> changed, changed_mesh;
  for (const auto& [key, value] : paper) {
    if (value != defaults.at(key)) (key.starts_with("mesh.") ? changed_mesh : changed)[key] = value;
  }
  EXPECT_EQ(changed,
            (std::map<std::string, std::string>{
                {"estimator.calibration.gyro", "false"},
                {"estimator.calibration.lens", "false"},
                {"estimator.calibration.mount", "false"},
                {"estimator.calibration.time", "false"},
                {"estimator.projection.convert_back", "false"},
                {"estimator.solver.keyframe_iterations", "1"},
                {"estimator.solver.plane_common_sigma_m", "0"},
                {"estimator.solver.plane_huber_sigma", "0.04"},
                {"estimator.solver.plane_sigma_m", "0.03"},
                {"frontend.noise.match_base_px", "0"},
                {"frontend.support.enabled", "false"},
                {"regularities.detection.min_faces", "20"},
                {"regularities.detection.oblique", "false"},
                {"regularities.detection.only_in_view", "false"},
                {"regularities.detection.world_origin", "true"},
                {"regularities.faces.enabled", "false"},
                {"regularities.measurements.enabled", "false"},
                {"regularities.relations.enabled", "false"},
                {"regularities.tracking.max_age_s", "6"},
                {"regularities.tracking.max_spread_sigma_deg", "0"},
                {"regularities.tracking.revise", "false"},
            }));
  std::string mesh;
  for (const auto& [key, value] : changed_mesh)
    mesh += key.substr(5) + " ";
  EXPECT_EQ(
      mesh,
      "border.enabled contradictions.by_triangulation contradictions.by_view faces.max_depth_sigma "
      "faces.max_grazing_deg faces.max_side_m faces.max_side_per_depth faces.min_angle_deg "
      "faces.min_elongation faces.min_side_ratio faces.noise_sigmas horizon_s map.enabled "
      "min_observations plane_rescue.enabled unknown_corners "
      "voting.max_depth_sigma "
      "voting.max_grazing_deg voting.max_side_m voting.max_side_per_depth "
      "voting.min_angle_deg voting.min_elongation voting.min_side_ratio ");
}

TEST(PaperConfigTest, DefaultsAreThoseOfEurocYaml) {
  EXPECT_EQ(ValuesOf(LoadOptions(ConfigFile("euroc.yaml"), {}).options), ValuesOf(VioOptions()));
}

// One level of faces: what votes for planes is what the mesh shows.
TEST(PaperConfigTest, TheSameFacesVoteThatAreShown) {
  const auto paper = ValuesOf(LoadOptions(ConfigFile("paper.yaml"), {}).options);
  int compared = 0;
  for (const auto& [key, value] : paper) {
    if (!key.starts_with("mesh.voting.")) continue;
    EXPECT_EQ(value, paper.at("mesh.faces." + key.substr(12))) << key;
    ++compared;
  }
  EXPECT_GT(compared, 5);
}

}  // namespace
}  // namespace facet
