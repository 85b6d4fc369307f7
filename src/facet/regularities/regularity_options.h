// SPDX-License-Identifier: BSD-2-Clause
// Every option of the search for planes. `facet config` prints those that users turn.
#pragma once

#include "facet/base/options.h"

namespace facet {

/// How planes are detected among the faces of the mesh (plane_detector.h).
struct DetectionOptions {
  /// A plane that leans more than this, and more than three of its sigmas, is neither level nor
  /// upright but oblique [deg].
  double max_plane_lean_deg = 2;
  /// Least surface of a plane, seen from kFullSizeDistance_m to kFarDistance_m; nearer and farther,
  /// what fills the same part of the view there is needed [m^2]. Smaller: more and less certain
  /// planes.
  double min_area_m2 = 0.15;
  /// Least spread (1-sigma) of a plane's points in its narrow direction, and of the landmarks of a
  /// new plane; less where it is near, more where it is far, as for the surface [m].
  double min_extent_m = 0.12;
  /// Points farther from a plane than this are not on it, however uncertain they are, nor are those
  /// that are known worse than to 1.6 times this (SquaredGate); parallel surfaces nearer to each
  /// other than this cannot be told apart; up to kFarDistance_m [m].
  double max_distance_m = 0.05;
  /// Least number of faces of a plane (the paper: 20).
  int min_faces = 0;
  /// Walls are voted for as in the paper: each face with the distance of its own plane from the
  /// world's origin. Far from there, faces of one wall miss each other.
  bool world_origin = false;
  /// Only faces that the newest keyframe sees are searched: the others were searched when they were
  /// seen.
  bool only_in_view = true;
  /// Planes at any angle, by growing regions, and their least surface [m^2].
  bool oblique = true;
  double oblique_min_area_m2 = 0.4;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("max_plane_lean_deg",
            max_plane_lean_deg,
            Range{0, 45},
            "a plane that leans more is neither floor nor wall [deg]");
    v.Field("min_area_m2",
            min_area_m2,
            Range{1e-3, 1e3},
            "least surface of a plane [m^2]",
            Audience::kUsers);
    v.Field("min_extent_m",
            min_extent_m,
            Range{1e-3, 10},
            "least extent of a plane in its narrower direction [m]");
    v.Field(
        "max_distance_m", max_distance_m, Range{0.01, 10}, "points farther off are not on it [m]");
    v.Field("min_faces", min_faces, Range{0, 1000}, "least number of faces on a plane");
    v.Field("world_origin",
            world_origin,
            Range{},
            "walls are told apart by their distance from the world's origin; else from the camera");
    v.Field(
        "only_in_view", only_in_view, Range{}, "search only faces that the newest keyframe sees");
    v.Field("oblique", oblique, Range{}, "also planes that are neither level nor upright");
    v.Field("oblique_min_area_m2",
            oblique_min_area_m2,
            Range{1e-3, 1e3},
            "least surface of such a plane [m^2]");
  }
};

/// How planes are tracked over the run and given their landmarks (plane_tracker.h).
struct PlaneTrackingOptions {
  /// Keyframes that must have detected a plane before it becomes a variable of the estimator.
  int min_detections = 3;
  /// Landmarks that must lie on it then, or min_spread_landmarks of them.
  int min_landmarks = 10;
  /// 1-sigma of its normal as these landmarks determine it [deg].
  double max_normal_sigma_deg = 3;
  /// Fewer landmarks, but so many, are enough if they determine its normal to
  /// max_spread_sigma_deg [deg] (0: never): large walls with little texture have no more.
  int min_spread_landmarks = 7;
  double max_spread_sigma_deg = 1;
  /// A plane out of view for longer is dormant: only a new detection finds it again. A tentative
  /// plane is forgotten [s].
  double active_s = 1.5;
  /// Squared sigmas within which a detection is a plane of the estimator (3 degrees of freedom).
  double max_chi_square = 11.3;
  /// Planes that turn out to be one surface are merged, and those that turn out to be none are
  /// removed.
  bool revise = true;
  /// A plane leaves the estimator this long after it came in [s]; 0: it stays (the paper: 6).
  double max_age_s = 0;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "min_detections", min_detections, Range{1, 100}, "keyframes that must have detected it");
    v.Field("min_landmarks",
            min_landmarks,
            Range{5, 1000},
            "landmarks of a new plane, if they are close together");
    v.Field("max_normal_sigma_deg",
            max_normal_sigma_deg,
            Range{0.01, 90},
            "1-sigma of a new plane's normal by its landmarks [deg]");
    v.Field("min_spread_landmarks",
            min_spread_landmarks,
            Range{5, 1000},
            "landmarks of a new plane, if they are far apart");
    v.Field("max_spread_sigma_deg",
            max_spread_sigma_deg,
            Range{0, 90},
            "far apart: they determine its normal to this, 1-sigma; 0: never [deg]");
    v.Field("active_s", active_s, Range{0, 1e3}, "a plane out of view for longer is dormant [s]");
    v.Field("max_chi_square",
            max_chi_square,
            Range{0, 1e3},
            "a detection is a known plane up to this squared Mahalanobis distance (of 3 numbers)");
    v.Field(
        "revise", revise, Range{}, "planes are merged, and removed when their landmarks misfit");
    v.Field("max_age_s", max_age_s, Range{0, 1e6}, "a plane is removed at this age; 0: never [s]");
  }
};

/// What planes have in common (plane_relations.h).
struct PlaneRelationOptions {
  bool enabled = true;
  /// Walls are upright and floors level.
  bool gravity = true;
  /// Walls are parallel or at right angles.
  bool headings = true;
  /// Tables, steps and pieces of floor have one height.
  bool same_height = true;
  /// Oblique planes are parallel or at right angles to each other, as roofs and ramps are. Boards
  /// that lean on a wall are not, and soon look as if they were.
  bool slopes = false;
  /// Smaller planes are not related to others [m^2].
  double min_area_m2 = 1;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "relate planes to each other and to gravity");
    v.Field("gravity", gravity, Range{}, "walls are upright, floors level");
    v.Field("headings", headings, Range{}, "walls are parallel or at right angles");
    v.Field("same_height", same_height, Range{}, "level planes have one height");
    v.Field("slopes", slopes, Range{}, "oblique planes are parallel or at right angles");
    v.Field("min_area_m2", min_area_m2, Range{0, 1e3}, "smaller planes are not related [m^2]");
  }
};

/// Depths of support points that lie on planes (support_depths.h).
struct SupportDepthOptions {
  bool enabled = true;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "planes correct the depth of their support points");
  }
};

/// What the support points of a keyframe tell the estimator of a plane (plane_measurements.h).
struct PlaneMeasurementOptions {
  bool enabled = true;
  /// Errors of neighbouring points are correlated, and so are those of the next keyframe: what many
  /// points say together is worse than their own sigmas by this factor.
  double sigma_scale = 2;
  /// What the errors of all points of a keyframe have in common, as a share of one point's sigma.
  double common_share = 0.6;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "support points measure planes of the estimator");
    v.Field(
        "sigma_scale", sigma_scale, Range{0.1, 100}, "factor on the sigma of many points together");
    v.Field("common_share",
            common_share,
            Range{0, 10},
            "what all points of a keyframe have in common, as a share of one's sigma");
  }
};

/// Whether planes decide which faces of the mesh are shown (triangle_verdicts.h).
struct TriangleVerdictOptions {
  bool enabled = true;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "planes decide which faces are shown");
  }
};

struct RegularityOptions {
  DetectionOptions detection;
  PlaneTrackingOptions tracking;
  PlaneRelationOptions relations;
  PlaneMeasurementOptions measurements;
  SupportDepthOptions support_depths;
  TriangleVerdictOptions faces;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Group("detection", detection);
    v.Group("tracking", tracking);
    v.Group("relations", relations);
    v.Group("measurements", measurements);
    v.Group("support_depths", support_depths);
    v.Group("faces", faces);
  }
};

}  // namespace facet
