// SPDX-License-Identifier: BSD-2-Clause
// Every option of the front end. `facet config` prints those that users turn.
#pragma once

#include <string>

#include "facet/base/options.h"

namespace facet {

/// Image alignment of one patch (patch_tracker.h).
struct KltOptions {
  /// Images in the pyramid, the full image included. More follow faster motion.
  int num_levels = 4;
  /// Instruction set: auto, avx2, sse2, neon or scalar. The results are bit-identical.
  std::string simd = "auto";

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "num_levels",
        num_levels,
        Range{1, 5},
        "images of the pyramid, each half as large as the one before; large images get one more");
    v.Choice("simd",
             simd,
             {"auto", "avx2", "sse2", "neon", "scalar"},
             "instruction set of the tracker; the results are the same");
  }
};

/// Detection of new points (feature_detector.h).
struct DetectorOptions {
  /// Side of a square grid cell; one new point per cell that holds no track. Smaller: more points.
  /// In an image of 752 x 480; cells and distances grow with the root of the number of pixels
  /// (camera/image_extent.h).
  int cell_px = 40;
  /// Distance that a new point keeps from every track.
  double min_distance_px = 16;
  /// First FAST threshold, in grey levels.
  int fast_threshold = 20;
  /// Smallest eigenvalue of the patch's structure tensor, in (grey levels per pixel)^2. Raising it
  /// refuses weak corners and points on edges.
  double min_eigenvalue = 5;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("cell_px",
            cell_px,
            Range{8, 400},
            "side of a grid cell, which gets at most one new point [px of 752 x 480]");
    v.Field("min_distance_px",
            min_distance_px,
            Range{0, 200},
            "least distance of new points from tracks [px of 752 x 480]");
    v.Field("fast_threshold",
            fast_threshold,
            Range{1, 255},
            "threshold of FAST; lower where it finds too few [grey values]");
    v.Field("min_eigenvalue",
            min_eigenvalue,
            Range{0, 1e5},
            "least strength of a corner (smaller eigenvalue)");
  }
};

/// Tracking from left image to left image (temporal_tracker.h).
struct TrackingOptions {
  /// A point that does not come back to within this distance when tracked back is lost.
  double max_forward_backward_px = 0.4;
  /// Similarity (ZNCC, -1..1) with the previous frame below which a point is lost.
  double min_zncc = 0.8;
  /// Similarity with the reference patch below which the patch is taken anew, and the track goes on
  /// as another landmark.
  double min_reference_zncc = 0.85;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("max_forward_backward_px",
            max_forward_backward_px,
            Range{0.01, 10},
            "a track that ends farther from its start when tracked back is dropped [px]");
    v.Field("min_zncc",
            min_zncc,
            Range{-1, 1},
            "least similarity of a patch with the previous frame (ZNCC)");
    v.Field("min_reference_zncc",
            min_reference_zncc,
            Range{-1, 1},
            "least similarity with the patch it began with; below it becomes a new landmark");
  }
};

/// From the left image to the right one (stereo_matcher.h).
struct StereoMatcherOptions {
  /// Nearest distance that the search of new points covers. Smaller costs time and false matches.
  double min_depth_m = 0.3;
  /// Similarity (ZNCC) of the final match.
  double min_zncc = 0.8;
  /// A match that does not come back to within this distance when tracked back is dropped.
  double max_left_right_px = 0.5;
  /// Distance from the epipolar line, in pixels of the mean focal length.
  double max_epipolar_px = 1.0;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("min_depth_m",
            min_depth_m,
            Range{0.02, 100},
            "nearest distance that is searched [m]",
            Audience::kUsers);
    v.Field("min_zncc", min_zncc, Range{-1, 1}, "least similarity of left and right patch (ZNCC)");
    v.Field("max_left_right_px",
            max_left_right_px,
            Range{0.01, 10},
            "a match that ends farther from its start when tracked back is dropped [px]");
    v.Field("max_epipolar_px",
            max_epipolar_px,
            Range{0.05, 50},
            "greatest distance from the epipolar line [px]");
  }
};

/// Outliers between frames, rotation known (outlier_rejection.h).
struct OutlierOptions {
  bool enabled = true;
  /// Angle between a ray and its epipolar plane, in pixels of the mean focal length.
  double max_error_px = 1.5;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled",
            enabled,
            Range{},
            "reject tracks by two-point RANSAC, the rotation known from the gyroscope");
    v.Field("max_error_px",
            max_error_px,
            Range{0.05, 50},
            "greatest distance from the epipolar plane [px]");
  }
};

/// Choice of keyframes (keyframe_policy.h).
struct KeyframeOptions {
  /// Time between keyframes; half a frame of jitter is allowed for.
  double interval_s = 0.2;
  /// A keyframe is due when fewer than this share of the last keyframe's points is still tracked.
  double min_tracked_ratio = 0.7;
  /// The same for those that are still the same landmark: without any, a frame between keyframes
  /// says nothing.
  double min_landmark_ratio = 0.3;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("interval_s",
            interval_s,
            Range{0, 10},
            "a keyframe comes at least this often [s]",
            Audience::kUsers);
    v.Field("min_tracked_ratio",
            min_tracked_ratio,
            Range{0, 1},
            "it comes earlier if fewer of the last one's points are still tracked");
    v.Field("min_landmark_ratio",
            min_landmark_ratio,
            Range{0, 1},
            "it comes earlier if fewer of them are still the same landmark");
  }
};

/// 1-sigma per axis that the observations carry: the root of base^2 + (factor * residuals)^2, where
/// the residuals of the alignment tell how well this patch can be located (bench/frontend_report
/// checks it).
struct PixelNoiseOptions {
  /// Base of a left pixel: what no residual shows, for example calibration. Twice as much for each
  /// pyramid level that the alignment could not descend.
  double left_base_px = 0.2;
  /// The same for a right pixel.
  double right_base_px = 0.25;
  /// The same for the match of left and right alone, which is better than either pixel: a place
  /// that slides in the left image takes its match along. 0: both pixels are off each for itself.
  double match_base_px = 0.2;
  /// Above 1 because errors of a track are correlated from frame to frame.
  double residual_factor = 1.5;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("left_base_px",
            left_base_px,
            Range{0.01, 20},
            "1-sigma of a left pixel, besides what its residual adds [px]",
            Audience::kUsers);
    v.Field("right_base_px",
            right_base_px,
            Range{0.01, 20},
            "the same of a right pixel [px]",
            Audience::kUsers);
    v.Field("match_base_px",
            match_base_px,
            Range{0, 20},
            "the same of the match alone; 0: left and right pixel are off each for itself [px]");
    v.Field("residual_factor",
            residual_factor,
            Range{0, 10},
            "what a patch's residual adds to its 1-sigma, as a factor");
  }
};

/// Points besides the tracked corners, matched left to right in each keyframe for the mesh
/// (support_places.h).
struct SupportPointOptions {
  bool enabled = true;
  /// Side of a cell with at most one support point, if it holds no corner, in an image of 752 x
  /// 480. The cells take turns over two keyframes. Smaller: more points, more time.
  int cell_px = 23;
  /// Mean difference between pixels two apart along the rows that a place must have [grey values].
  double min_contrast = 1.5;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "match points left to right between the corners");
    v.Field("cell_px",
            cell_px,
            Range{12, 400},
            "side of a cell, which gets at most one support point [px of 752 x 480]");
    v.Field(
        "min_contrast", min_contrast, Range{0, 255}, "least contrast along the rows [grey values]");
  }
};

struct FrontendOptions {
  /// Tracks per frame; more cost time everywhere.
  int max_features = 160;
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
    v.Field("max_features",
            max_features,
            Range{1, 5000},
            "tracks per frame; more cost time",
            Audience::kUsers);
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
