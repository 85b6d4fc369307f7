// SPDX-License-Identifier: BSD-2-Clause
#include "ladder_report.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "facet/eval/paired_comparison.h"

namespace facet {

namespace {

using Realisations = std::vector<Realisation>;

PairedComparison Compare(const Realisations& realisations, std::size_t rung, std::size_t base) {
  std::vector<double> ratios;
  for (const Realisation& r : realisations)
    ratios.push_back(r.outcomes[rung].ate_m / r.outcomes[base].ate_m);
  return CompareRatios(std::move(ratios));
}

template <class Value>
double Mean(const Realisations& realisations, std::size_t rung, const Value& value) {
  double sum = 0;
  for (const Realisation& r : realisations)
    sum += static_cast<double>(value(r.outcomes[rung]));
  return sum / static_cast<double>(realisations.size());
}

void PrintRatios(const Realisations& realisations, std::size_t rung, const char* name) {
  const PairedComparison ratio = Compare(realisations, rung, 0);
  std::printf(
      "  %-25s ATE %.4f m   over S %.3f [%.3f, %.3f]   worst %.2f   NEES pose %.2f yaw %.2f   "
      "resets %.0f   CPU %.1f s\n",
      name,
      Mean(realisations, rung, [](const Outcome& o) { return o.ate_m; }),
      ratio.median_ratio,
      ratio.low,
      ratio.high,
      *std::max_element(ratio.ratios.begin(), ratio.ratios.end()),
      Mean(realisations, rung, [](const Outcome& o) { return o.pose_nees; }),
      Mean(realisations, rung, [](const Outcome& o) { return o.yaw_nees; }),
      Mean(realisations, rung, [](const Outcome& o) { return o.num_resets; }) *
          static_cast<double>(realisations.size()),
      Mean(realisations, rung, [](const Outcome& o) { return o.cpu_s; }));
}

void PrintSecondBase(const std::vector<Rung>& rungs,
                     const Realisations& realisations,
                     std::size_t rung) {
  const auto base = std::find_if(
      rungs.begin(), rungs.end(), [&](const Rung& r) { return r.key == rungs[rung].against; });
  if (base == rungs.end()) return;
  const auto b = static_cast<std::size_t>(base - rungs.begin());
  const PairedComparison ratio = Compare(realisations, rung, b);
  std::printf("  %-25s over %s %.3f [%.3f, %.3f]",
              "",
              base->name.c_str(),
              ratio.median_ratio,
              ratio.low,
              ratio.high);
  if (rungs[rung].against == "oracle") {
    const double gain = 1 - Compare(realisations, rung, 0).median_ratio;
    const double ceiling = 1 - Compare(realisations, b, 0).median_ratio;
    std::printf("   %.0f %% of its gain", 100 * gain / ceiling);
  }
  std::printf("\n");
}

void PrintQuality(const Realisations& realisations, std::size_t rung) {
  const auto mean = [&](int SearchQuality::*count) {
    return Mean(realisations, rung, [&](const Outcome& o) { return o.quality.*count; });
  };
  const double joined = mean(&SearchQuality::num_joined);
  if (joined == 0) return;
  std::printf("  %-25s planes %.1f   landmarks joined %.0f   of them wrongly %.1f %%",
              "",
              mean(&SearchQuality::num_created),
              joined,
              100 * mean(&SearchQuality::num_wrong) / joined);
  const double events = mean(&SearchQuality::num_events) * static_cast<double>(realisations.size());
  if (events > 0) std::printf("   wrong returns %.0f", events);
  std::printf("\n");
}

std::string KeyOf(const std::string& flight, std::uint64_t seed, const std::string& rung) {
  return flight + "," + std::to_string(seed) + "," + rung;
}

}  // namespace

void PrintLadder(const std::vector<Rung>& rungs, const Realisations& realisations) {
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    PrintRatios(realisations, r, rungs[r].name.c_str());
    PrintSecondBase(rungs, realisations, r);
    PrintQuality(realisations, r);
  }
  double simulation_s = 0;
  for (const Realisation& r : realisations)
    simulation_s += r.simulation_s;
  std::printf("  %-25s CPU %.1f s\n",
              "simulation",
              simulation_s / static_cast<double>(realisations.size()));
  std::fflush(stdout);
}

OutcomeFile::OutcomeFile(const std::string& path, const std::string& settings) {
  const std::string begin = "# " + settings;
  std::ifstream old(path);
  std::string line;
  if (std::getline(old, line) && line != begin)
    throw std::runtime_error(path + ": is of other settings (" + line + ")");
  const bool is_new = !old;
  bool was_cut = false;  // the last line lacks its end
  while (std::getline(old, line)) {
    was_cut = old.eof();
    Outcome o;
    char flight[64], rung[64];
    unsigned long long seed = 0;
    const int found = std::sscanf(line.c_str(),
                                  "%63[^,],%llu,%63[^,],%lf,%lf,%lf,%d,%d,%d,%d,%d,%lf",
                                  flight,
                                  &seed,
                                  rung,
                                  &o.ate_m,
                                  &o.pose_nees,
                                  &o.yaw_nees,
                                  &o.num_resets,
                                  &o.quality.num_created,
                                  &o.quality.num_joined,
                                  &o.quality.num_wrong,
                                  &o.quality.num_events,
                                  &o.cpu_s);
    constexpr int kColumns = 12;
    if (found == kColumns) outcomes_[KeyOf(flight, seed, rung)] = o;
  }
  file_.reset(std::fopen(path.c_str(), "a"));
  if (!file_) throw std::runtime_error(path + ": cannot be written");
  if (was_cut) std::fputc('\n', file_.get());
  if (!is_new) return;
  std::fprintf(file_.get(),
               "%s\nflight,seed,rung,ate_m,pose_nees,yaw_nees,resets,planes,joined,joined_wrongly,"
               "wrong_returns,cpu_s\n",
               begin.c_str());
}

const Outcome* OutcomeFile::Find(const std::string& flight,
                                 std::uint64_t seed,
                                 const std::string& rung) const {
  const auto found = outcomes_.find(KeyOf(flight, seed, rung));
  return found == outcomes_.end() ? nullptr : &found->second;
}

void OutcomeFile::Add(const std::string& flight,
                      std::uint64_t seed,
                      const std::string& rung,
                      const Outcome& o) {
  const std::string key = KeyOf(flight, seed, rung);
  outcomes_[key] = o;
  std::fprintf(file_.get(),
               "%s,%.9g,%.6g,%.6g,%d,%d,%d,%d,%d,%.3f\n",
               key.c_str(),
               o.ate_m,
               o.pose_nees,
               o.yaw_nees,
               o.num_resets,
               o.quality.num_created,
               o.quality.num_joined,
               o.quality.num_wrong,
               o.quality.num_events,
               o.cpu_s);
  std::fflush(file_.get());
}

}  // namespace facet
