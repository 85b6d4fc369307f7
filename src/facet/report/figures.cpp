// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "facet/base/stage_timer.h"
#include "facet/report/svg_plot.h"
#include "facet/report/table.h"

namespace facet {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kMaxMeshDistance = 0.30;  // [m], the range of the paper's Fig. 4
constexpr std::size_t kMaxLinePoints = 4000;
constexpr const char* kTruthColour = "#999999";

template <class T>
std::vector<T> Thin(const std::vector<T>& all, std::size_t most = kMaxLinePoints) {
  std::vector<T> some;
  const std::size_t k = std::max<std::size_t>(1, (all.size() + most - 1) / most);
  for (std::size_t i = 0; i < all.size(); i += k)
    some.push_back(all[i]);
  return some;
}

std::vector<double> Coordinates(const std::vector<std::vector<Vector2d>>& lines, int axis) {
  std::vector<double> values;
  for (const auto& line : lines) {
    for (const Vector2d& p : line)
      values.push_back(p[axis]);
  }
  return values;
}

Timestamp FirstStamp(std::span<const ReportRun> runs) {
  Timestamp first{std::numeric_limits<std::int64_t>::max()};
  for (const ReportRun& run : runs) {
    if (!run.evaluation.pairs.empty()) first = std::min(first, run.evaluation.pairs.front().t);
  }
  return first;
}

// ----------------------------------------------------------------------------------- trajectory

ReportFigure TrajectoryView(std::span<const ReportRun> runs, bool from_above) {
  const int vertical = from_above ? 1 : 2;
  std::vector<std::vector<Vector2d>> lines;
  std::vector<Vector2d> truth;
  for (const PosePair& pair : runs.front().evaluation.pairs)
    truth.emplace_back(pair.T_GB.p.x(), pair.T_GB.p[vertical]);
  lines.push_back(Thin(truth));
  for (const ReportRun& run : runs) {
    std::vector<Vector2d> line;
    for (const PosePair& pair : run.evaluation.pairs) {
      const Vector3d p_G = run.evaluation.causal.alignment * pair.T_WB.p;
      line.emplace_back(p_G.x(), p_G[vertical]);
    }
    lines.push_back(Thin(line));
  }
  PlotLayout layout;
  layout.height = from_above ? 520 : 300;
  layout.x_label = "x [m]";
  layout.y_label = from_above ? "y [m]" : "z [m]";
  layout.equal_scales = true;
  layout.x = Cover(Coordinates(lines, 0));
  layout.y = Cover(Coordinates(lines, 1));
  SvgPlot plot(layout);
  plot.AddLine(lines[0], kTruthColour, "ground truth", true);
  for (std::size_t i = 0; i < runs.size(); ++i)
    plot.AddLine(lines[i + 1], RunColour(i), runs[i].name);
  return {from_above ? "trajectory_top" : "trajectory_side",
          from_above ? "Trajectory from above" : "Trajectory from the side",
          "Causal poses, aligned to the ground truth, in its frame (z points up). Where curves "
          "coincide "
          "the last one of the legend covers the others.",
          plot.ToString()};
}

ReportFigure ErrorOverTime(std::span<const ReportRun> runs) {
  const Timestamp first = FirstStamp(runs);
  std::vector<std::vector<Vector2d>> lines;
  for (const ReportRun& run : runs) {
    const auto& pairs = run.evaluation.pairs;
    const auto errors = AbsoluteErrors(pairs, run.evaluation.causal.alignment);
    std::vector<Vector2d> line;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      line.emplace_back(ToSeconds(pairs[i].t - first), 100 * errors[i]);
    lines.push_back(Thin(line));
  }
  PlotLayout layout;
  layout.x_label = "time since the first pose [s]";
  layout.y_label = "position error [cm]";
  layout.x = Cover(Coordinates(lines, 0), 0.01);
  layout.y = {0, Cover(Coordinates(lines, 1)).high};
  SvgPlot plot(layout);
  for (std::size_t i = 0; i < runs.size(); ++i)
    plot.AddLine(lines[i], RunColour(i), runs[i].name);
  return {"error_over_time",
          "Position error over time",
          "Distance between the aligned causal pose and the truth at the same moment.",
          plot.ToString()};
}

// ------------------------------------------------------------------------------------ box plots

ReportFigure RelativeErrorBoxes(std::span<const ReportRun> runs, bool is_translation) {
  std::vector<double> lengths;
  for (const ReportRun& run : runs) {
    for (const RelativeErrors& errors : run.evaluation.causal.rpe)
      lengths.push_back(errors.length_m);
  }
  std::sort(lengths.begin(), lengths.end());
  lengths.erase(std::unique(lengths.begin(), lengths.end()), lengths.end());
  struct Box {
    double x;
    BoxSummary box;
    std::size_t run;
  };
  std::vector<Box> boxes;
  const double width = 0.8 / static_cast<double>(runs.size());
  double largest = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (const RelativeErrors& errors : runs[r].evaluation.causal.rpe) {
      std::vector<double> values = is_translation ? errors.translation_m : errors.rotation_rad;
      for (double& v : values)
        v *= is_translation ? 100 : kDegPerRad;
      const auto place = std::ranges::find(lengths, errors.length_m) - lengths.begin();
      const double x = static_cast<double>(place) - 0.4 + (static_cast<double>(r) + 0.5) * width;
      boxes.push_back({x, SummarizeBox(values), r});
      largest = std::max(largest, boxes.back().box.p95);
    }
  }
  PlotLayout layout;
  layout.x_label = "length of path [m]";
  layout.y_label = is_translation ? "translation error [cm]" : "rotation error [deg]";
  layout.x = {-0.6, static_cast<double>(lengths.size()) - 0.4};
  layout.y = {0, 1.06 * largest};
  for (double length : lengths)
    layout.x_categories.push_back(FormatNumber("%g", length));
  SvgPlot plot(layout);
  for (const Box& box : boxes)
    plot.AddBox(box.x, 0.42 * width, box.box, RunColour(box.run));
  for (std::size_t r = 0; r < runs.size(); ++r)
    plot.AddLegend(runs[r].name, RunColour(r));
  return {is_translation ? "rpe_translation" : "rpe_rotation",
          is_translation ? "Relative error: translation" : "Relative error: rotation",
          "Error of the motion over stretches of each length, from every pose on. Box: quartiles "
          "with the median; whiskers: 5th and 95th percentile. (In the paper: Fig. 3.)",
          plot.ToString()};
}

// ----------------------------------------------------------------------------------------- mesh

struct ColouredPoint {
  Vector2d p;
  double depth;
  double distance_m;
};

ReportFigure MeshFigure(const std::string& run,
                        const std::string& kind,
                        const MeshError& error,
                        bool from_above) {
  // Looking down, or from the south and above at 30 deg, as an architect draws.
  constexpr double kSine = 0.5, kCosine = 0.866;
  std::vector<ColouredPoint> points;
  for (std::size_t i = 0; i < error.picture_samples_G.size(); ++i) {
    const Vector3d& p = error.picture_samples_G[i];
    const Vector2d seen =
        from_above ? Vector2d(p.x(), p.y()) : Vector2d(p.x(), kSine * p.y() + kCosine * p.z());
    const double depth = from_above ? -p.z() : kCosine * p.y() - kSine * p.z();
    points.push_back({seen, depth, error.picture_distances_m[i]});
  }
  std::ranges::sort(points, std::greater<>(), &ColouredPoint::depth);
  std::vector<Vector2d> places;
  std::vector<std::string> colours;
  for (const ColouredPoint& point : points) {
    places.push_back(point.p);
    colours.push_back(DistanceColour(point.distance_m / kMaxMeshDistance));
  }
  PlotLayout layout;
  layout.has_colour_bar = true;
  layout.height = 520;
  layout.x_label = "x [m]";
  layout.y_label = from_above ? "y [m]" : "0.5 y + 0.87 z [m]";
  layout.equal_scales = true;
  layout.x = Cover(Coordinates({places}, 0));
  layout.y = Cover(Coordinates({places}, 1));
  SvgPlot plot(layout);
  plot.AddPoints(places, colours, 2.0);
  plot.AddColourBar(0, kMaxMeshDistance, "distance [m]");
  return {kind + (from_above ? "_top_" : "_oblique_") + run,
          (kind == "map" ? "Map of the whole run: " : "Horizon mesh: ") + run +
              (from_above ? ", from above" : ", from the south and 30 deg above"),
          "Samples of the mesh, coloured by their distance from the true surface; red is 0.30 m "
          "and more. Placed by the trajectory's alignment, before ICP. (In the paper: Fig. 4.)",
          plot.ToString()};
}

// --------------------------------------------------------------------------------------- timing

// Values of one column at keyframes, from 0.
std::vector<Vector2d> AtKeyframes(const NumberColumns& timing, const std::string& name) {
  std::vector<Vector2d> line;
  const auto column = timing.find(name), is_keyframe = timing.find("is_keyframe");
  if (column == timing.end() || is_keyframe == timing.end()) return line;
  for (std::size_t i = 0; i < column->second.size(); ++i) {
    if (is_keyframe->second[i] > 0.5) {
      line.emplace_back(static_cast<double>(line.size()), column->second[i]);
    }
  }
  return line;
}

bool AnyPositive(const std::vector<std::vector<Vector2d>>& lines) {
  const std::vector<double> values = Coordinates(lines, 1);
  return std::ranges::any_of(values, [](double v) { return v > 0; });
}

struct KeyframeFigure {
  const char* column;
  const char* name;
  const char* title;
  const char* y_label;
  const char* caption;
  bool counts;  // whole numbers
};

// Absent (empty svg) when no run has anything but zeros.
ReportFigure OverKeyframes(std::span<const ReportRun> runs, const KeyframeFigure& kind) {
  std::vector<std::vector<Vector2d>> lines;
  for (const ReportRun& run : runs)
    lines.push_back(AtKeyframes(run.timing, kind.column));
  if (!AnyPositive(lines)) return {};
  PlotLayout layout;
  layout.x_label = "keyframe";
  layout.y_label = kind.y_label;
  layout.y_counts = kind.counts;
  layout.height = 260;
  layout.x = Cover(Coordinates(lines, 0), 0.01);
  layout.y = {0, Cover(Coordinates(lines, 1)).high};
  SvgPlot plot(layout);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!lines[i].empty()) plot.AddLine(lines[i], RunColour(i), runs[i].name);
  }
  return {kind.name, kind.title, kind.caption, plot.ToString()};
}

ReportFigure Stages(std::span<const ReportRun> runs) {
  std::vector<std::string> names;
  double largest = 0;
  const auto mean_of = [](const ReportRun& run, const std::string& stage) {
    const nlohmann::ordered_json::json_pointer place("/stages/" + stage + "/mean_ms");
    return run.summary.contains(place) ? run.summary[place].get<double>() : 0.0;
  };
  for (const char* stage : kStageNames) {
    double most = 0;
    for (const ReportRun& run : runs)
      most = std::max(most, mean_of(run, stage));
    if (most > 0) names.emplace_back(stage);
    largest = std::max(largest, most);
  }
  if (names.empty()) return {};
  PlotLayout layout;
  layout.x_label = "stage";
  layout.y_label = "mean CPU time per frame [ms]";
  layout.height = 280;
  layout.x = {-0.6, static_cast<double>(names.size()) - 0.4};
  layout.y = {0, 1.2 * largest};
  layout.x_categories = names;
  SvgPlot plot(layout);
  const double width = 0.8 / static_cast<double>(runs.size());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (std::size_t s = 0; s < names.size(); ++s) {
      const double x = static_cast<double>(s) - 0.4 + (static_cast<double>(r) + 0.5) * width;
      plot.AddBar(x, 0.42 * width, {0, mean_of(runs[r], names[s])}, RunColour(r));
    }
    plot.AddLegend(runs[r].name, RunColour(r));
  }
  return {"stages",
          "CPU time by stage",
          "Thread CPU time, mean over all frames; what happens on keyframes only is spread over "
          "all of them.",
          plot.ToString()};
}

constexpr KeyframeFigure kKeyframeFigures[] = {
    {"optimize",
     "optimize_time",
     "Optimisation time per keyframe",
     "optimisation [ms]",
     "Thread CPU time of the optimisation of each keyframe. (In the paper: Fig. 5.)",
     false},
    {"planes",
     "planes",
     "Planes over time",
     "planes in the estimator",
     "Number of planes in the estimator at each keyframe. (In the paper: Fig. 5.)",
     true},
    {"constraints",
     "constraints",
     "Regularity constraints over time",
     "constraints",
     "Number of regularity constraints in force at each keyframe.",
     true},
};

std::string FileStem(std::string name) {
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') c = '_';
  }
  return name;
}

}  // namespace

ReportFigure MakeComparisonFigure(const nlohmann::ordered_json& comparison) {
  PlotLayout layout;
  layout.x_label = "sequence";
  layout.y_label = "ATE RMSE [cm]";
  const auto& sequences = comparison["sequences"];
  if (sequences.empty()) return {};
  layout.x = {-0.6, static_cast<double>(sequences.size()) - 0.4};
  const std::size_t num_combinations = sequences[0]["combinations"].size();
  std::vector<std::vector<Vector2d>> points(num_combinations);
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    layout.x_categories.push_back(sequences[s]["name"]);
    for (std::size_t c = 0; c < num_combinations; ++c) {
      const auto& runs = sequences[s]["combinations"][c]["runs"];
      for (std::size_t r = 0; r < runs.size(); ++r) {
        if (!runs[r].contains("ate_rmse_m")) continue;
        // Combinations side by side, the starts of each one from left to right.
        const double share = (static_cast<double>(r) + 0.5) / static_cast<double>(runs.size());
        const double slot =
            (static_cast<double>(c) + 0.1 + 0.8 * share) / static_cast<double>(num_combinations);
        points[c].emplace_back(static_cast<double>(s) - 0.45 + 0.9 * slot,
                               100 * runs[r]["ate_rmse_m"].get<double>());
      }
    }
  }
  const std::vector<double> values = Coordinates(points, 1);
  if (values.empty()) return {};
  layout.y = {0, 1.06 * *std::ranges::max_element(values)};
  SvgPlot plot(layout);
  for (std::size_t c = 0; c < num_combinations; ++c) {
    if (points[c].empty()) continue;
    plot.AddPoints(points[c], std::vector<std::string>(points[c].size(), RunColour(c)), 2.5);
    plot.AddLegend(sequences[0]["combinations"][c]["name"], RunColour(c));
  }
  return {"ate_of_every_start",
          "ATE of every start",
          "One square per run, the starts of each combination from left to right.",
          plot.ToString()};
}

std::vector<ReportFigure> MakeFigures(std::span<const ReportRun> runs) {
  std::vector<ReportFigure> figures;
  if (runs.empty()) return figures;
  figures.push_back(TrajectoryView(runs, true));
  figures.push_back(TrajectoryView(runs, false));
  figures.push_back(ErrorOverTime(runs));
  const bool has_rpe = std::ranges::any_of(
      runs, [](const ReportRun& run) { return !run.evaluation.causal.rpe.empty(); });
  if (has_rpe) {
    figures.push_back(RelativeErrorBoxes(runs, true));
    figures.push_back(RelativeErrorBoxes(runs, false));
  }
  const auto add_mesh = [&figures](const ReportRun& run, const char* kind, const auto& error) {
    if (!error) return;
    for (bool from_above : {false, true})
      figures.push_back(MeshFigure(run.name, kind, *error, from_above));
  };
  for (const ReportRun& run : runs) {
    add_mesh(run, "mesh", run.evaluation.mesh);
    add_mesh(run, "map", run.evaluation.map);
  }
  for (const KeyframeFigure& kind : kKeyframeFigures)
    figures.push_back(OverKeyframes(runs, kind));
  figures.push_back(Stages(runs));
  std::erase_if(figures, [](const ReportFigure& figure) { return figure.svg.empty(); });
  for (ReportFigure& figure : figures)
    figure.name = FileStem(figure.name);
  return figures;
}

}  // namespace facet
