// SPDX-License-Identifier: BSD-2-Clause
#include "facet/report/svg_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "facet/base/check.h"
#include "facet/report/table.h"

namespace facet {
namespace {

constexpr double kLeft = 66, kRight = 16, kTop = 14, kBottom = 46, kLegend = 14;  // margins [px]
constexpr double kColourBarWidth = 78;
constexpr int kWantedTicks = 6;

std::string Px(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f", value);
  return text;
}

std::string TextAt(
    double x, double y, const std::string& text, const char* anchor, const std::string& more = "") {
  return "<text x=\"" + Px(x) + "\" y=\"" + Px(y) + "\" text-anchor=\"" + anchor + "\"" + more +
         ">" + EscapeHtml(text) + "</text>\n";
}

std::string LineFromTo(double x0, double y0, double x1, double y1, const std::string& style) {
  return "<line x1=\"" + Px(x0) + "\" y1=\"" + Px(y0) + "\" x2=\"" + Px(x1) + "\" y2=\"" + Px(y1) +
         "\" " + style + "/>\n";
}

std::string Rectangle(double x0, double y0, double x1, double y1, const std::string& style) {
  return "<rect x=\"" + Px(std::min(x0, x1)) + "\" y=\"" + Px(std::min(y0, y1)) + "\" width=\"" +
         Px(std::abs(x1 - x0)) + "\" height=\"" + Px(std::abs(y1 - y0)) + "\" " + style + "/>\n";
}

// 1, 2 or 5 times a power of ten.
double RoundStep(double length) {
  const double raw = length / kWantedTicks;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  for (double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

Interval NonEmpty(Interval i) {
  if (!(i.high > i.low)) i = {i.low - 0.5, i.low + 0.5};
  return i;
}

// A share of the sorted values, linear between the nearest ranks.
double Quantile(const std::vector<double>& sorted, double share) {
  const double rank = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (rank - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

Interval Cover(const std::vector<double>& values, double margin) {
  Interval i{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (double v : values) {
    if (!std::isfinite(v)) continue;
    i.low = std::min(i.low, v);
    i.high = std::max(i.high, v);
  }
  if (i.low > i.high) return {0, 1};
  const double extra = margin * (i.high - i.low);
  return NonEmpty({i.low - extra, i.high + extra});
}

BoxSummary SummarizeBox(std::vector<double> values) {
  FACET_CHECK(!values.empty()) << "a box of nothing";
  std::sort(values.begin(), values.end());
  return {Quantile(values, 0.05),
          Quantile(values, 0.25),
          Quantile(values, 0.5),
          Quantile(values, 0.75),
          Quantile(values, 0.95)};
}

std::string RunColour(std::size_t i) {
  constexpr std::array<const char*, 6> kColours = {
      "#1f6fb4", "#e07b1a", "#2c9a3f", "#b8352f", "#7d53a8", "#6b5b4b"};
  return kColours[i % kColours.size()];
}

std::string DistanceColour(double share) {
  constexpr double kStops[][3] = {
      {49, 54, 149}, {69, 150, 200}, {120, 198, 121}, {253, 200, 60}, {215, 48, 39}};
  constexpr int kLast = 4;
  const double place = std::clamp(share, 0.0, 1.0) * kLast;
  const int below = std::min(static_cast<int>(place), kLast - 1);
  const double fraction = place - below;
  char text[16];
  std::array<int, 3> rgb{};
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    const double value = (1 - fraction) * kStops[below][i] + fraction * kStops[below + 1][i];
    rgb[i] = static_cast<int>(std::lround(value));
  }
  std::snprintf(text, sizeof(text), "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
  return text;
}

SvgPlot::SvgPlot(const PlotLayout& layout)
    : layout_(layout),
      left_(kLeft),
      right_(layout.width - (layout.has_colour_bar ? kColourBarWidth : kRight)),
      top_(layout.has_colour_bar ? kTop : kTop + kLegend),
      bottom_(layout.height - kBottom) {
  layout_.x = NonEmpty(layout_.x);
  layout_.y = NonEmpty(layout_.y);
  if (layout_.equal_scales) {
    const double metres_per_px = std::max((layout_.x.high - layout_.x.low) / (right_ - left_),
                                          (layout_.y.high - layout_.y.low) / (bottom_ - top_));
    const auto widen = [metres_per_px](Interval& i, double px) {
      const double middle = 0.5 * (i.low + i.high), half = 0.5 * px * metres_per_px;
      i = {middle - half, middle + half};
    };
    widen(layout_.x, right_ - left_);
    widen(layout_.y, bottom_ - top_);
  }
  DrawAxes();
}

double SvgPlot::X(double x) const {
  return left_ + (x - layout_.x.low) / (layout_.x.high - layout_.x.low) * (right_ - left_);
}

double SvgPlot::Y(double y) const {
  return bottom_ - (y - layout_.y.low) / (layout_.y.high - layout_.y.low) * (bottom_ - top_);
}

void SvgPlot::DrawTicks(bool is_x) {
  const Interval& range = is_x ? layout_.x : layout_.y;
  double step = RoundStep(range.high - range.low);
  if (!is_x && layout_.y_counts) step = std::max(1.0, step);
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  for (double k = std::ceil(range.low / step); k * step <= range.high; ++k) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.*f", decimals, k * step + 0.0);
    if (is_x) {
      const double x = X(k * step);
      axes_ += LineFromTo(x, top_, x, bottom_, "class=\"grid\"");
      axes_ += TextAt(x, bottom_ + 15, text, "middle");
    } else {
      const double y = Y(k * step);
      axes_ += LineFromTo(left_, y, right_, y, "class=\"grid\"");
      axes_ += TextAt(left_ - 6, y + 4, text, "end");
    }
  }
}

void SvgPlot::DrawAxes() {
  if (layout_.x_categories.empty()) DrawTicks(true);
  for (std::size_t i = 0; i < layout_.x_categories.size(); ++i) {
    axes_ += TextAt(X(static_cast<double>(i)), bottom_ + 15, layout_.x_categories[i], "middle");
  }
  DrawTicks(false);
  axes_ += Rectangle(left_, top_, right_, bottom_, "class=\"frame\"");
  axes_ += TextAt(0.5 * (left_ + right_), layout_.height - 10, layout_.x_label, "middle");
  const double middle = 0.5 * (top_ + bottom_);
  axes_ += TextAt(
      14, middle, layout_.y_label, "middle", " transform=\"rotate(-90 14 " + Px(middle) + ")\"");
}

void SvgPlot::AddLine(const std::vector<Vector2d>& points,
                      const std::string& colour,
                      const std::string& legend,
                      bool is_dashed) {
  std::string path;
  bool is_open = false;
  for (const Vector2d& p : points) {
    if (!p.allFinite()) {
      is_open = false;
      continue;
    }
    path += (is_open ? "L" : "M") + Px(X(p.x())) + " " + Px(Y(p.y()));
    is_open = true;
  }
  if (!path.empty()) {
    body_ += "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + colour +
             "\" stroke-width=\"1.4\"" + (is_dashed ? " stroke-dasharray=\"5 3\"" : "") + "/>\n";
  }
  if (!legend.empty()) AddLegend(legend, colour);
}

void SvgPlot::AddPoints(const std::vector<Vector2d>& points,
                        const std::vector<std::string>& colours,
                        double radius_px) {
  // Paths are the shortest SVG for a square, and there are thousands of them.
  const std::string side = Px(2 * radius_px);
  const std::string square = "h" + side + "v" + side + "h-" + side + "z\"/>\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    body_ += "<path fill=\"" + colours[i] + "\" d=\"M" + Px(X(points[i].x()) - radius_px) + " " +
             Px(Y(points[i].y()) - radius_px) + square;
  }
}

void SvgPlot::AddBox(double x,
                     double half_width,
                     const BoxSummary& box,
                     const std::string& colour) {
  const double x0 = X(x - half_width), x1 = X(x + half_width), middle = X(x);
  const std::string stroke = "stroke=\"" + colour + "\" stroke-width=\"1.2\"";
  body_ += LineFromTo(middle, Y(box.p5), middle, Y(box.q1), stroke);
  body_ += LineFromTo(middle, Y(box.q3), middle, Y(box.p95), stroke);
  body_ += LineFromTo(0.5 * (x0 + middle), Y(box.p5), 0.5 * (x1 + middle), Y(box.p5), stroke);
  body_ += LineFromTo(0.5 * (x0 + middle), Y(box.p95), 0.5 * (x1 + middle), Y(box.p95), stroke);
  body_ += Rectangle(x0, Y(box.q1), x1, Y(box.q3), stroke + " fill=\"" + colour + "33\"");
  body_ += LineFromTo(
      x0, Y(box.median), x1, Y(box.median), "stroke=\"" + colour + "\" stroke-width=\"2.4\"");
}

void SvgPlot::AddBar(double x, double half_width, const Interval& y, const std::string& colour) {
  body_ += Rectangle(
      X(x - half_width), Y(y.low), X(x + half_width), Y(y.high), "fill=\"" + colour + "\"");
}

void SvgPlot::AddLegend(const std::string& text, const std::string& colour) {
  legend_.emplace_back(text, colour);
}

void SvgPlot::AddColourBar(double from, double to, const std::string& label) {
  constexpr int kSteps = 40;
  const double x = right_ + 16, height = (bottom_ - top_) * 0.7;
  const double bar_top = top_ + 26;
  for (int i = 0; i < kSteps; ++i) {
    const double share = (i + 0.5) / kSteps;
    const double y = bar_top + height * (1 - (i + 1.0) / kSteps);
    body_ += Rectangle(
        x, y, x + 12, y + height / kSteps + 0.5, "fill=\"" + DistanceColour(share) + "\"");
  }
  for (double share : {0.0, 0.5, 1.0}) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.2f", from + share * (to - from));
    body_ += TextAt(x + 16, bar_top + height * (1 - share) + 4, text, "start");
  }
  body_ += TextAt(layout_.width - 4, top_ + 12, label, "end");
}

// In rows above the frame, where it hides no data; later rows lie above the picture's own height.
std::string SvgPlot::LegendSvg(double* extra_height) const {
  constexpr double kRow = 15, kLine = 20, kCharacter = 6.6, kBetween = 22;  // px
  std::vector<std::vector<std::size_t>> rows(1);
  std::vector<double> widths;
  double x = left_;
  for (std::size_t i = 0; i < legend_.size(); ++i) {
    widths.push_back(kLine + 6 + kCharacter * static_cast<double>(legend_[i].first.size()));
    if (x + widths[i] > layout_.width && !rows.back().empty()) {
      rows.emplace_back();
      x = left_;
    }
    rows.back().push_back(i);
    x += widths[i] + kBetween;
  }
  *extra_height = kRow * static_cast<double>(rows.size() - 1);
  std::string svg;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double y = top_ - 8 - kRow * static_cast<double>(rows.size() - 1 - r);
    x = left_;
    for (const std::size_t i : rows[r]) {
      const auto& [text, colour] = legend_[i];
      svg += LineFromTo(x, y - 4, x + kLine, y - 4, "stroke=\"" + colour + "\" stroke-width=\"4\"");
      svg += TextAt(x + kLine + 6, y, text, "start");
      x += widths[i] + kBetween;
    }
  }
  return svg;
}

std::string SvgPlot::ToString() const {
  double extra = 0;
  const std::string legend = LegendSvg(&extra);
  const std::string width = std::to_string(layout_.width), height = Px(layout_.height + extra);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 " + Px(0 - extra) + " " + width +
         " " + height + "\" width=\"" + width + "\" height=\"" + height +
         "\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"11\" "
         "fill=\"#222\">\n<style>.grid{stroke:#ddd;stroke-width:.7}.frame{fill:none;stroke:#888}"
         "</style>\n<rect y=\"" +
         Px(0 - extra) + "\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" + axes_ + body_ +
         legend + "</svg>\n";
}

}  // namespace facet
