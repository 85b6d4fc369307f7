// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/paper_tables.h"

namespace facet {
namespace {

constexpr std::optional<double> kNone = std::nullopt;

// The medians of V1_03 and V2_03 are not legible in the paper's text. V1_01's and V1_02's SPR
// values are printed without their decimal point (53 and 74).
constexpr PaperRow kRows[] = {
    {"MH_01_easy", {13.7, 12.4, 10.7}, {15.0, 15.0, 14.5}, {16, 42, 21, 27, 5, 14}},
    {"MH_02_easy", {12.9, 17.6, 12.6}, {13.1, 16.7, 13.0}, {22, 45, 25, 12, 3, 13}},
    {"MH_03_medium", {21.0, 21.0, 21.0}, {21.2, 21.2, 21.2}, {24, 23, 25, 13, 12, 21}},
    {"MH_04_difficult", {17.3, 17.3, 17.3}, {21.7, 21.7, 21.7}, {34, 37, 49, 23, 13, 22}},
    {"MH_05_difficult", {21.6, 21.6, 21.6}, {22.6, 22.6, 22.6}, {47, 48, 52, 35, 16, 23}},
    {"V1_01_easy", {5.6, 6.2, 5.3}, {6.4, 7.7, 5.7}, {9, 34, 10, 7, 7, 6}},
    {"V1_02_medium", {7.7, 8.7, 6.3}, {8.9, 9.4, 7.4}, {20, 20, 10, 10, 11, 7}},
    {"V1_03_difficult", {kNone, kNone, kNone}, {23.1, 17.6, 16.7}, {24, 67, 14, 13, kNone, 17}},
    {"V2_01_easy", {8.0, 6.6, 6.3}, {8.9, 8.2, 8.1}, {13, 10, 12, 8, 7, 8}},
    {"V2_02_medium", {8.8, 9.1, 7.1}, {12.7, 13.5, 10.3}, {16, 16, 14, 8, kNone, 10}},
    {"V2_03_difficult", {kNone, kNone, kNone}, {41.5, 27.2, 27.2}, {29, 113, 14, 21, kNone, 27}},
};
constexpr std::size_t kShortName = 5;  // "V1_01"

}  // namespace

std::span<const PaperRow> PaperRows() {
  return kRows;
}

const PaperRow* FindPaperRow(std::string_view sequence) {
  for (const PaperRow& row : kRows) {
    if (sequence == row.sequence || sequence == row.sequence.substr(0, kShortName)) return &row;
  }
  return nullptr;
}

}  // namespace facet
