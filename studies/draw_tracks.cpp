// SPDX-License-Identifier: BSD-2-Clause
// Question: what does the front end track, and where does it lose it? One PNG per frame, the left
//   image beside the right one.
// Command: draw_tracks SEQUENCE --out DIR [--from S] [--duration S] [--every N] [--set
//   key=value]...
// Answer: MH_01 loses its tracks where a net half a metre away fills half of the image; along the
//   same motion without near things tracks live five times as long
//   (docs/notebook/simulator_realism.md).
// Date: 2026-11-23.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bench/program.h"
#include "stage_run.h"
#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "facet/io/errors.h"
#include "facet/io/png_writer.h"

namespace facet {
namespace {

constexpr const char* kLegend =
    "Dots are tracked points, from blue (new) over green to red (64 frames and more as the same\n"
    "landmark), with their path over the last ten frames. A magenta cross is where a track of the\n"
    "frame before was lost, or was renewed: its patch no longer fitted, and it goes on as another\n"
    "landmark (a blue dot beside the cross). Dots in the right image (keyframes) are where it was\n"
    "found there.";

cv::Scalar AgeColour(int age) {
  constexpr double kOldest = 64;
  const double s = std::min(1.0, std::log1p(age) / std::log1p(kOldest));
  return {255 * std::clamp(2 * s - 1, 0.0, 1.0),
          255 * (1 - std::abs(2 * s - 1)),
          255 * std::clamp(1 - 2 * s, 0.0, 1.0)};
}

const cv::Scalar kLost(255, 0, 255), kText(255, 255, 0);

cv::Point ToPixel(const Vector2d& px) {
  return {static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y()))};
}

class TrackPainter {
 public:
  /// To be called for every frame, in order.
  void Add(const FrameObservations& frame) {
    lost_.clear();
    std::unordered_map<LandmarkId, std::vector<Vector2d>> now;
    for (const FeatureObservation& o : frame.features) {
      auto path = paths_.extract(o.landmark);
      std::vector<Vector2d>& points = now[o.landmark];
      if (path) points = std::move(path.mapped());
      points.push_back(o.px_left);
    }
    for (const auto& [id, points] : paths_)
      lost_.push_back(points.back());
    paths_ = std::move(now);
  }

  /// The frame that was added last.
  cv::Mat Paint(const StereoFrame& images, const FrontendResult& result) const {
    cv::Mat left = ToRgb(images.left, images.left.size());
    cv::Mat right = ToRgb(images.right, images.left.size());
    for (const FeatureObservation& o : result.observations.features) {
      const std::vector<Vector2d>& path = paths_.at(o.landmark);
      const cv::Scalar colour = AgeColour(static_cast<int>(path.size()) - 1);
      PaintPath(path, colour, left);
      cv::circle(left, ToPixel(o.px_left), 2, colour, cv::FILLED, cv::LINE_AA);
      if (o.px_right) cv::circle(right, ToPixel(*o.px_right), 2, colour, cv::FILLED, cv::LINE_AA);
    }
    for (const Vector2d& px : lost_)
      cv::drawMarker(left, ToPixel(px), kLost, cv::MARKER_TILTED_CROSS, 7);
    cv::Mat both;
    cv::hconcat(left, right, both);
    return both;
  }

 private:
  static cv::Mat ToRgb(const cv::Mat& grey, cv::Size size) {
    cv::Mat rgb(size, CV_8UC3, cv::Scalar::all(0));
    if (grey.size() == size) cv::cvtColor(grey, rgb, cv::COLOR_GRAY2RGB);
    return rgb;
  }

  static void PaintPath(const std::vector<Vector2d>& path, const cv::Scalar& colour, cv::Mat& to) {
    constexpr std::size_t kLongest = 10;
    const std::size_t first = path.size() > kLongest ? path.size() - kLongest : 0;
    for (std::size_t k = first; k + 1 < path.size(); ++k)
      cv::line(to, ToPixel(path[k]), ToPixel(path[k + 1]), colour, 1, cv::LINE_AA);
  }

  std::unordered_map<LandmarkId, std::vector<Vector2d>> paths_;
  std::vector<Vector2d> lost_;
};

struct Request {
  std::string sequence;
  std::filesystem::path out;
  double from_s = 0;
  double duration_s = 1e9;
  int every = 1;
};

void PaintCaption(std::size_t index, double t_s, const FrontendResult& result, cv::Mat& picture) {
  const FrameObservations& frame = result.observations;
  std::array<char, 160> text{};
  std::snprintf(text.data(),
                text.size(),
                "%zu  %.2f s  tracked %d (renewed %d)  lost %d  new %d  %s",
                index,
                t_s,
                result.tracking.num_tracked,
                result.tracking.num_refreshed,
                result.tracking.num_lost() + result.num_outliers,
                result.num_new,
                frame.is_keyframe ? "keyframe" : "");
  cv::putText(picture, text.data(), {8, 16}, cv::FONT_HERSHEY_SIMPLEX, 0.45, kText, 1, cv::LINE_AA);
}

void CreateFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw OutputError(folder.string() + ": cannot be created: " + error.message());
}

int Draw(const Request& request, const VioOptions& options) {
  AslDataset dataset(request.sequence);
  CreateFolder(request.out);
  TrackPainter painter;
  int pictures = 0;
  const auto visit = [&](std::size_t i, const StereoFrame& images, TrackedFrame& tracked) {
    painter.Add(tracked.frontend.observations);
    const double t_s = ToSeconds(images.t - dataset.frames().front().t);
    if (t_s > request.from_s + request.duration_s) return false;
    if (t_s < request.from_s || i % static_cast<std::size_t>(request.every) != 0) return true;
    cv::Mat picture = painter.Paint(images, tracked.frontend);
    PaintCaption(i, t_s, tracked.frontend, picture);
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%06zu.png", i);
    WritePng(request.out / name.data(), picture);
    ++pictures;
    return true;
  };
  RunStages(dataset, options, visit, [](const VioOutput&) {});
  return pictures;
}

int Main(int argc, char** argv) {
  CLI::App app("Pictures of the tracks of a recording");
  app.footer(kLegend);
  Request request;
  std::vector<std::string> overrides;
  app.add_option("sequence", request.sequence, "folder in ASL layout")->required();
  app.add_option("--out", request.out, "folder for the pictures")->required();
  app.add_option("--from", request.from_s, "first picture, seconds into the recording");
  app.add_option("--duration", request.duration_s, "length of the part that is drawn, s");
  app.add_option("--every", request.every, "one picture every N frames")
      ->check(CLI::Range(1, 100000));
  app.add_option("--set", overrides, "option of the pipeline, key=value");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  const int pictures = Draw(request, OptionsOfS(overrides));
  if (pictures == 0) throw InputError("no frame of the recording was asked for");
  std::printf("%d pictures in %s\n%s\n", pictures, request.out.string().c_str(), kLegend);
  return 0;
}

}  // namespace
}  // namespace facet

int main(int argc, char** argv) {
  return facet::RunProgram("draw_tracks", facet::Main, argc, argv);
}
