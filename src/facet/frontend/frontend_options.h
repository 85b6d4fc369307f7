// SPDX-License-Identifier: BSD-2-Clause
// Every knob of the front end. (!) marks the ones worth tuning.
#pragma once

#include <string>

#include "facet/base/options.h"

namespace facet {

/// Image alignment of one patch (patch_tracker.h).
struct KltOptions {
  /// Images in the pyramid, the full image included. More follow faster motion.
  int num_levels = 4;
  /// Iterations per level and alignment. More cost time on the few tracks that need them.
  int max_iterations = 6;
  /// An alignment ends when an update moves the patch by less than this. Smaller costs iterations.
  double min_update_px = 0.01;
  /// Instruction set: auto, avx2, sse2 or scalar. The results are bit-identical.
  std::string simd = "auto";

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("num_levels", num_levels, Range{1, 5}, "images in the pyramid");
    v.Field("max_iterations", max_iterations, Range{1, 50}, "iterations per pyramid level");
    v.Field("min_update_px", min_update_px, Range{1e-4, 1}, "update that ends the iterations");
    v.Field("simd", simd, Range{}, "auto, avx2, sse2 or scalar; same results");
  }
};

/// Where new points come from (feature_detector.h).
struct DetectorOptions {
  /// Free parameters of the warp that the strength of a corner is judged with (see
  /// TrackingOptions).
  int num_parameters = 4;
  /// Side of a square grid cell; one new point per cell that holds no track. Smaller: more points.
  /// (!)
  int cell_px = 40;
  /// Distance that a new point keeps from every track.
  double min_distance_px = 16;
  /// First FAST threshold, in grey levels.
  int fast_threshold = 20;
  /// Cells without any corner are searched again with this one if there are too few points.
  int fast_threshold_min = 7;
  /// Smallest eigenvalue of the patch's structure tensor, in (grey levels per pixel)^2. Raising it
  /// refuses weak corners and points on edges.
  double min_eigenvalue = 5;
  /// Pixels at the image border without points.
  int border_px = 8;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("num_parameters", num_parameters, Range{2, 6}, "warp parameters of the strength");
    v.Field("cell_px", cell_px, Range{8, 400}, "side of a grid cell with at most one new point");
    v.Field(
        "min_distance_px", min_distance_px, Range{0, 200}, "distance of new points from tracks");
    v.Field("fast_threshold", fast_threshold, Range{1, 255}, "first FAST threshold");
    v.Field("fast_threshold_min", fast_threshold_min, Range{1, 255}, "threshold for empty cells");
    v.Field("min_eigenvalue", min_eigenvalue, Range{0, 1e5}, "smallest accepted corner strength");
    v.Field("border_px", border_px, Range{4, 100}, "border without points");
  }
};

/// From left image to left image (temporal_tracker.h).
struct TrackingOptions {
  /// Free parameters of the warp from frame to frame, besides gain and offset: 2 shift, 3 and
  /// rotation, 4 and scale, 6 affine. The prediction supplies the others. More are noisier, and
  /// follow more.
  int num_parameters = 2;
  /// The same for the alignment with the reference patch.
  int reference_parameters = 4;
  /// Coarsest pyramid level for points whose motion can be predicted; others begin at the top.
  int start_level = 1;
  /// A point that does not come back to within this distance when tracked back is lost. (!)
  double max_forward_backward_px = 0.4;
  /// Similarity (ZNCC, -1..1) with the previous frame below which a point is lost.
  double min_zncc = 0.8;
  /// Similarity with the reference patch below which the patch is taken anew, and the track goes on
  /// as another landmark.
  double min_reference_zncc = 0.85;
  /// Scale change since the reference patch, beyond which (or its inverse) it is taken anew, too.
  double max_reference_scale = 1.6;
  /// Farthest that the alignment with the reference may move a point before the reference is given
  /// up and taken anew.
  double max_reference_shift_px = 1.5;
  /// Lost tracks per tracked one, above which they are sought again as if nothing had moved: the
  /// prediction may be wrong.
  double retry_lost_ratio = 0.5;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "num_parameters", num_parameters, Range{2, 6}, "2 shift, 3 rotation, 4 scale, 6 affine");
    v.Field("reference_parameters", reference_parameters, Range{2, 6}, "same, to the reference");
    v.Field("start_level", start_level, Range{0, 4}, "coarsest level for predicted points");
    v.Field("max_forward_backward_px", max_forward_backward_px, Range{0.01, 10}, "tracking back");
    v.Field("min_zncc", min_zncc, Range{-1, 1}, "similarity with the previous frame");
    v.Field("min_reference_zncc",
            min_reference_zncc,
            Range{-1, 1},
            "similarity with the reference; below: new landmark");
    v.Field("max_reference_scale",
            max_reference_scale,
            Range{1, 10},
            "scale change of a reference; beyond: new landmark");
    v.Field("max_reference_shift_px", max_reference_shift_px, Range{0, 20}, "reference correction");
    v.Field("retry_lost_ratio", retry_lost_ratio, Range{0, 1}, "lost share that causes a retry");
  }
};

/// From the left image to the right one (stereo_matcher.h).
struct StereoMatcherOptions {
  /// Free parameters of the warp from left to right (see TrackingOptions).
  int num_parameters = 4;
  /// The same for places whose depth is asked for (support points of the mesh). More cost time, and
  /// lose more points.
  int near_parameters = 2;
  /// Nearest depth that the search of new points covers. Smaller costs time and false matches.
  double min_depth_m = 0.3;
  /// Pyramid level of the search along the epipolar line.
  int search_level = 2;
  /// Similarity (ZNCC) that the best place of the search must have.
  double min_search_zncc = 0.6;
  /// Similarity (ZNCC) of the final match.
  double min_zncc = 0.8;
  /// A match that does not come back to within this distance when tracked back is dropped. (!)
  double max_left_right_px = 0.5;
  /// Distance from the epipolar line, in pixels of the mean focal length. (!)
  double max_epipolar_px = 1.0;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "num_parameters", num_parameters, Range{2, 6}, "2 shift, 3 rotation, 4 scale, 6 affine");
    v.Field("near_parameters",
            near_parameters,
            Range{2, 6},
            "same, for places whose depth is asked for");
    v.Field("min_depth_m", min_depth_m, Range{0.02, 100}, "nearest depth of the search");
    v.Field("search_level", search_level, Range{0, 5}, "pyramid level of the epipolar search");
    v.Field("min_search_zncc", min_search_zncc, Range{-1, 1}, "similarity in the search");
    v.Field("min_zncc", min_zncc, Range{-1, 1}, "similarity of a match");
    v.Field("max_left_right_px", max_left_right_px, Range{0.01, 10}, "tracking back to the left");
    v.Field("max_epipolar_px", max_epipolar_px, Range{0.05, 50}, "distance from the epipolar line");
  }
};

/// Outliers between frames, rotation known (outlier_rejection.h).
struct OutlierOptions {
  bool enabled = true;
  /// Angle between a ray and its epipolar plane, in pixels of the mean focal length. (!)
  double max_error_px = 1.5;
  /// Median motion apart from any rotation, below which the test is skipped: the directions would
  /// be noise.
  double min_parallax_px = 1.0;
  int max_iterations = 60;
  /// Fewer inliers than this share and the model is not trusted: nothing is removed.
  double min_inlier_ratio = 0.7;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "two-point test with known rotation");
    v.Field("max_error_px", max_error_px, Range{0.05, 50}, "distance from the epipolar plane");
    v.Field(
        "min_parallax_px", min_parallax_px, Range{0, 50}, "motion below which the test is skipped");
    v.Field("max_iterations", max_iterations, Range{1, 10000}, "samples");
    v.Field("min_inlier_ratio", min_inlier_ratio, Range{0, 1}, "share needed to trust the model");
  }
};

/// When a frame becomes a keyframe (keyframe_policy.h).
struct KeyframeOptions {
  /// Time between keyframes; half a frame of jitter is allowed for. (!)
  double interval_s = 0.2;
  /// A keyframe is due when fewer than this share of the last keyframe's points is still tracked.
  double min_tracked_ratio = 0.7;
  /// The same for those that are still the same landmark: without any, a frame between keyframes
  /// says nothing.
  double min_landmark_ratio = 0.3;
  /// Every frame is a keyframe until then [s]. The start does not need it; off.
  double every_frame_until_s = 0;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("interval_s", interval_s, Range{0, 10}, "time between keyframes");
    v.Field("min_tracked_ratio", min_tracked_ratio, Range{0, 1}, "tracked share that is enough");
    v.Field("min_landmark_ratio",
            min_landmark_ratio,
            Range{0, 1},
            "share of same landmarks that is enough");
    v.Field("every_frame_until_s", every_frame_until_s, Range{0, 60}, "keyframes only, until then");
  }
};

/// 1-sigma per axis that the observations carry: the root of base^2 + (factor * residuals)^2, where
/// the residuals of the alignment tell how well this patch can be located (bench/frontend_report
/// checks it).
struct PixelNoiseOptions {
  /// Base of a left pixel: what no residual shows, for example calibration. Twice as much for each
  /// pyramid level that the alignment could not descend. (!)
  double left_base_px = 0.2;
  /// The same for a right pixel. (!)
  double right_base_px = 0.25;
  /// Above 1 because errors of a track are correlated from frame to frame.
  double residual_factor = 1.5;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "left_base_px", left_base_px, Range{0.01, 20}, "noise of a left pixel besides residuals");
    v.Field("right_base_px", right_base_px, Range{0.01, 20}, "same of a right pixel");
    v.Field("residual_factor", residual_factor, Range{0, 10}, "weight of the patch residuals");
  }
};

/// Points besides the tracked corners, matched left to right in each keyframe for the mesh
/// (support_places.h).
struct SupportPointOptions {
  bool enabled = true;
  /// Side of a cell with at most one support point, if it holds no corner. The cells take turns
  /// over two keyframes. Smaller: more points, more time. (!)
  int cell_px = 23;
  /// Mean difference between pixels two apart along the rows that a place must have [grey values].
  double min_contrast = 1.5;
  /// A triangle whose corners' inverse depths differ by more is also searched around the nearest
  /// and the farthest of them [1/m].
  double min_depth_step = 0.12;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "match points left to right between the corners");
    v.Field("cell_px", cell_px, Range{12, 400}, "side of a cell with at most one support point");
    v.Field("min_contrast", min_contrast, Range{0, 255}, "contrast along the rows [grey values]");
    v.Field("min_depth_step",
            min_depth_step,
            Range{0, 100},
            "step in inverse depth that widens the search [1/m]");
  }
};

struct FrontendOptions {
  /// Tracks per frame; more cost time everywhere. (!)
  int max_features = 160;
  /// Pixels at the border where no observation is reported.
  int border_px = 4;
  KltOptions klt;
  DetectorOptions detector;
  TrackingOptions tracking;
  StereoMatcherOptions stereo;
  OutlierOptions outliers;
  KeyframeOptions keyframe;
  PixelNoiseOptions noise;
  SupportPointOptions support;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("max_features", max_features, Range{1, 5000}, "tracks per frame; more cost time");
    v.Field("border_px", border_px, Range{2, 100}, "border without observations");
    v.Group("klt", klt);
    v.Group("detector", detector);
    v.Group("tracking", tracking);
    v.Group("stereo", stereo);
    v.Group("outliers", outliers);
    v.Group("keyframe", keyframe);
    v.Group("noise", noise);
    v.Group("support", support);
  }
};

}  // namespace facet
