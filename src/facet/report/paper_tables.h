// SPDX-License-Identifier: BSD-2-Clause
// Tables I and II of Rosinol et al., "Incremental Visual-Inertial 3D Mesh Generation with
// Structural Regularities", ICRA 2019: ATE on EuRoC in cm.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace facet {

/// One line of both tables. Empty: the paper has no (legible) value, or the system failed.
struct PaperRow {
  std::string_view sequence;  ///< as the folder of the download is called
  /// Table I; S, SP, SPR.
  std::array<std::optional<double>, 3> median_cm, rmse_cm;
  /// Table II: OKVIS, MSCKF, ROVIO, VINS-MONO, SVO-GTSAM, SPR.
  std::array<std::optional<double>, 6> others_rmse_cm;
};

inline constexpr std::array<std::string_view, 3> kPaperPipelines = {"S", "SP", "SPR"};
inline constexpr std::array<std::string_view, 6> kPaperSystems = {
    "OKVIS", "MSCKF", "ROVIO", "VINS-MONO", "SVO-GTSAM", "SPR (paper)"};

std::span<const PaperRow> PaperRows();

/// The line of a sequence folder such as "V1_01_easy" or "V1_01"; null for any other name.
const PaperRow* FindPaperRow(std::string_view sequence);

}  // namespace facet
