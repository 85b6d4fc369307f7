// SPDX-License-Identifier: BSD-2-Clause
// Plots as SVG text: axes with round ticks, lines, points, boxes and bars in data coordinates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "facet/base/types.h"

namespace facet {

struct Interval {
  double low = 0, high = 1;
};

/// Smallest interval that holds all finite values, widened by `margin` of its length; [0, 1]
/// without any.
Interval Cover(const std::vector<double>& values, double margin = 0.04);

/// Five numbers of a box plot: whiskers at the 5th and 95th percentile.
struct BoxSummary {
  double p5 = 0, q1 = 0, median = 0, q3 = 0, p95 = 0;
};
/// CHECKs that there is at least one value.
BoxSummary SummarizeBox(std::vector<double> values);

/// The colour of the i-th run in every figure.
std::string RunColour(std::size_t i);
/// Blue at 0 over green to red at 1; values outside are clamped.
std::string DistanceColour(double share);

struct PlotLayout {
  int width = 760, height = 320;  ///< [px], of the whole picture
  std::string x_label, y_label;
  Interval x, y;
  bool has_colour_bar = false;  ///< leaves room for AddColourBar at the right
  bool y_counts = false;        ///< whole numbers only
  bool equal_scales = false;    ///< widens one of the intervals until a metre is a metre in both
  std::vector<std::string> x_categories;  ///< names at x = 0, 1, 2 ... instead of numbers
};

/// Draws in the order of the calls. Values that are not finite break lines and are left out else.
class SvgPlot {
 public:
  explicit SvgPlot(const PlotLayout& layout);

  void AddLine(const std::vector<Vector2d>& points,
               const std::string& colour,
               const std::string& legend = "",
               bool is_dashed = false);
  /// One colour per point.
  void AddPoints(const std::vector<Vector2d>& points,
                 const std::vector<std::string>& colours,
                 double radius_px);
  void AddBox(double x, double half_width, const BoxSummary& box, const std::string& colour);
  void AddBar(double x, double half_width, const Interval& y, const std::string& colour);
  void AddLegend(const std::string& text, const std::string& colour);
  /// A scale for DistanceColour beside the plot; wants layout.has_colour_bar.
  void AddColourBar(double from, double to, const std::string& label);

  std::string ToString() const;

 private:
  double X(double x) const;
  double Y(double y) const;
  void DrawAxes();
  void DrawTicks(bool is_x);
  std::string LegendSvg(double* extra_height) const;

  PlotLayout layout_;
  double left_, right_, top_, bottom_;  // of the plot area [px]
  std::string axes_, body_;
  std::vector<std::pair<std::string, std::string>> legend_;  // text, colour
};

}  // namespace facet
