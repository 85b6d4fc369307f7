// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/relative_error_tables.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "facet/eval/trajectory_error.h"

namespace facet {
namespace {

using nlohmann::ordered_json;

constexpr const char* kErrorKeys[] = {"translation_median_m", "rotation_median_deg"};

struct Gain {
  double mean = 0, largest = 0;
};

const ordered_json* FindLength(const ordered_json& rpe, double length_m) {
  const auto found = std::ranges::find_if(
      rpe, [&](const ordered_json& entry) { return entry["length_m"] == length_m; });
  return found == rpe.end() ? nullptr : &*found;
}

// Empty if the two have no length in common.
std::optional<Gain> FindGain(const ordered_json& better,
                             const ordered_json& worse,
                             const char* key) {
  std::vector<double> gains;
  for (const ordered_json& entry : better) {
    const ordered_json* other = FindLength(worse, entry["length_m"].get<double>());
    if (other == nullptr || !((*other)[key].get<double>() > 0)) continue;
    gains.push_back(1 - entry[key].get<double>() / (*other)[key].get<double>());
  }
  if (gains.empty()) return std::nullopt;
  return Gain{Summarize(gains).mean, *std::ranges::max_element(gains)};
}

const ordered_json* FindCombination(const ordered_json& combinations, const std::string& name) {
  const auto found = std::ranges::find_if(
      combinations, [&](const ordered_json& entry) { return entry["name"] == name; });
  return found == combinations.end() || !found->contains("rpe") ? nullptr : &*found;
}

std::set<double> LengthsOf(const ordered_json& comparison) {
  std::set<double> lengths;
  for (const ordered_json& sequence : comparison["sequences"]) {
    for (const ordered_json& combination : sequence["combinations"]) {
      for (const ordered_json& entry : combination.value("rpe", ordered_json::array()))
        lengths.insert(entry["length_m"].get<double>());
    }
  }
  return lengths;
}

TableCell TextCell(const std::string& text) {
  return {text, "", "", 1};
}

std::string IndexOfLength(const ordered_json& rpe, double length_m) {
  const ordered_json* entry = FindLength(rpe, length_m);
  return entry == nullptr ? "none" : std::to_string(entry - &rpe[0]);
}

Table ErrorTable(const ordered_json& comparison) {
  Table table;
  table.title = "ATE and RPE: absolute error, and error of the motion over stretches of path";
  table.header = {"sequence", "combination", "ATE median [cm]", "ATE RMSE [cm]"};
  const std::set<double> lengths = LengthsOf(comparison);
  for (const char* unit : {" m [cm]", " m [deg]"}) {
    for (const double length_m : lengths)
      table.header.push_back("RPE " + FormatNumber("%g", length_m) + unit);
  }
  if (lengths.empty()) return table;
  const auto& sequences = comparison["sequences"];
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const auto& combinations = sequences[s]["combinations"];
    for (std::size_t c = 0; c < combinations.size(); ++c) {
      const std::string place =
          "/sequences/" + std::to_string(s) + "/combinations/" + std::to_string(c);
      const ordered_json rpe = combinations[c].value("rpe", ordered_json::array());
      auto& row = table.rows.emplace_back();
      row.push_back(TextCell(sequences[s]["name"]));
      row.push_back(TextCell(combinations[c]["name"]));
      row.push_back(NumberCell(comparison, place + "/ate_median_m", "%.2f", 100));
      row.push_back(NumberCell(comparison, place + "/ate_rmse_m", "%.2f", 100));
      for (const char* key : kErrorKeys) {
        const bool is_length = key == kErrorKeys[0];
        for (const double length_m : lengths) {
          const std::string entry = place + "/rpe/" + IndexOfLength(rpe, length_m) + "/" + key;
          row.push_back(
              NumberCell(comparison, entry, is_length ? "%.2f" : "%.3f", is_length ? 100 : 1));
        }
      }
    }
  }
  table.notes.push_back(
      "Medians over all stretches of a run and over the starts; a dash where no path is that "
      "long.");
  return table;
}

Table GainTable(const ordered_json& comparison) {
  Table table;
  table.title = "Fig. 3: how much smaller the RPE is with planes [%]";
  table.header = {"sequence",
                  "compared",
                  "translation, mean",
                  "translation, best length",
                  "rotation, mean",
                  "rotation, best length",
                  "lengths"};
  const auto& sequences = comparison["sequences"];
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const auto& gains = sequences[s].value("rpe_gains", ordered_json::array());
    for (std::size_t g = 0; g < gains.size(); ++g) {
      const std::string place =
          "/sequences/" + std::to_string(s) + "/rpe_gains/" + std::to_string(g);
      auto& row = table.rows.emplace_back();
      row.push_back(TextCell(sequences[s]["name"]));
      row.push_back(TextCell(gains[g]["other"].get<std::string>() + " / " +
                             gains[g]["reference"].get<std::string>()));
      for (const char* key :
           {"translation_mean", "translation_best", "rotation_mean", "rotation_best"})
        row.push_back(NumberCell(comparison, place + "/" + key, "%+.1f", 100));
      row.push_back(NumberCell(comparison, place + "/lengths", "%.0f"));
    }
  }
  if (table.rows.empty()) return table;
  auto& paper = table.rows.emplace_back();  // III-A
  for (const char* text : {"V2_02 (paper)", "SPR / SP", "+20", "+50", "+15", "+30", "-"})
    paper.push_back(TextCell(text));
  table.notes.push_back(
      "1 - ratio of the medians, mean over the lengths and at the length with the largest gain; "
      "negative: worse.");
  return table;
}

}  // namespace

ordered_json MedianRelativeErrors(std::span<const ordered_json> evaluations) {
  std::map<double, std::map<std::string, std::vector<double>>> values;
  for (const ordered_json& evaluation : evaluations) {
    for (const ordered_json& entry : evaluation.value("rpe", ordered_json::array())) {
      for (const char* key : kErrorKeys)
        values[entry["length_m"].get<double>()][key].push_back(entry[key].get<double>());
    }
  }
  ordered_json out = ordered_json::array();
  for (const auto& [length_m, by_key] : values) {
    ordered_json entry = {{"length_m", length_m}};
    for (const char* key : kErrorKeys)
      entry[key] = Summarize(by_key.at(key)).median;
    entry["runs"] = by_key.at(kErrorKeys[0]).size();
    out.push_back(std::move(entry));
  }
  return out;
}

ordered_json RelativeErrorGains(const ordered_json& combinations) {
  ordered_json out = ordered_json::array();
  for (const ordered_json& combination : combinations) {
    const std::string name = combination["name"];
    const std::string configuration = name.substr(0, name.find('-'));
    if (configuration != "SPR" || !combination.contains("rpe")) continue;
    for (const char* pipeline : {"SP", "S"}) {
      const std::string reference = pipeline + name.substr(configuration.size());
      const ordered_json* other = FindCombination(combinations, reference);
      if (other == nullptr) continue;
      const auto translation = FindGain(combination["rpe"], (*other)["rpe"], kErrorKeys[0]);
      const auto rotation = FindGain(combination["rpe"], (*other)["rpe"], kErrorKeys[1]);
      if (!translation || !rotation) continue;
      const std::size_t num_lengths =
          std::ranges::count_if(combination["rpe"], [&](const ordered_json& entry) {
            return FindLength((*other)["rpe"], entry["length_m"].get<double>()) != nullptr;
          });
      out.push_back({{"other", name},
                     {"reference", reference},
                     {"translation_mean", translation->mean},
                     {"translation_best", translation->largest},
                     {"rotation_mean", rotation->mean},
                     {"rotation_best", rotation->largest},
                     {"lengths", num_lengths}});
    }
  }
  return out;
}

std::vector<Table> RelativeErrorTables(const ordered_json& comparison) {
  std::vector<Table> tables;
  for (Table& table : std::vector<Table>{ErrorTable(comparison), GainTable(comparison)}) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace facet
