// SPDX-License-Identifier: BSD-2-Clause
// Every knob of the search for planes. (!) marks the ones worth tuning.
#pragma once

#include "facet/base/options.h"

namespace facet {

/// How planes are found among the faces of the mesh (plane_detector.h).
struct DetectionOptions {
  /// A face votes for a floor or a wall when it leans less than this [deg]. (!)
  double max_lean_deg = 15;
  /// A plane that leans more than this, and more than three of its sigmas, is neither [deg].
  double max_plane_lean_deg = 2;
  /// Kernel of a vote, 1-sigma: height or distance [m], azimuth [deg].
  double vote_sigma_m = 0.03, vote_sigma_deg = 5;
  /// Surface within a vote's kernel that makes a peak, and least surface of a plane [m^2]. (!)
  double min_area_m2 = 0.15;
  /// Least spread (1-sigma) of a plane's points in its narrow direction [m].
  double min_extent_m = 0.12;
  /// Points farther from the plane than this are not on it [m].
  double max_distance_m = 0.05;
  /// Least number of vertices on a plane.
  int min_vertices = 10;
  /// Least number of faces of a plane (the paper: 20).
  int min_faces = 0;
  /// RMS distance of a plane's points above which it is none, or 1.5 times what is expected [m].
  double max_thickness_m = 0.02;
  /// Walls are voted for as in the paper: each face with the distance of its own plane from the
  /// world's origin. Far from there, faces of one wall miss each other.
  bool world_origin = false;
  /// Only faces that the newest keyframe sees are searched: the others were when they were seen.
  bool only_in_view = true;
  /// Planes at any angle, by growing regions.
  bool oblique = true;
  double oblique_min_area_m2 = 0.4;
  /// At most this many new planes of each kind per keyframe.
  int max_candidates = 6;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("max_lean_deg", max_lean_deg, Range{0.1, 45}, "a face that leans more does not vote");
    v.Field("max_plane_lean_deg",
            max_plane_lean_deg,
            Range{0, 45},
            "a plane that leans more is neither floor nor wall [deg]");
    v.Field("vote_sigma_m", vote_sigma_m, Range{0.002, 1}, "width of a vote [m]");
    v.Field("vote_sigma_deg", vote_sigma_deg, Range{0.5, 30}, "width of a vote in azimuth [deg]");
    v.Field("min_area_m2", min_area_m2, Range{1e-3, 1e3}, "least surface of a plane [m^2]");
    v.Field("min_extent_m", min_extent_m, Range{1e-3, 10}, "least spread across [m]");
    v.Field("max_distance_m", max_distance_m, Range{1e-3, 10}, "points farther off are not on it");
    v.Field("min_vertices", min_vertices, Range{3, 1000}, "least number of vertices on a plane");
    v.Field("min_faces", min_faces, Range{0, 1000}, "least number of faces on a plane");
    v.Field("max_thickness_m", max_thickness_m, Range{1e-4, 1}, "RMS distance of its points [m]");
    v.Field("world_origin", world_origin, Range{}, "walls by their distance from the origin");
    v.Field("only_in_view", only_in_view, Range{}, "search what the newest keyframe sees");
    v.Field("oblique", oblique, Range{}, "also planes that are neither level nor upright");
    v.Field("oblique_min_area_m2",
            oblique_min_area_m2,
            Range{1e-3, 1e3},
            "least surface of such a plane [m^2]");
    v.Field("max_candidates", max_candidates, Range{1, 100}, "new planes of a kind per keyframe");
  }
};

/// How planes are kept, recognised and given their landmarks (plane_tracker.h).
struct PlaneTrackingOptions {
  /// Keyframes that must have shown a plane before it becomes a variable.
  int min_sightings = 3;
  /// Landmarks that must lie on it then (or min_spread_landmarks of them), and their least spread
  /// across (1-sigma) [m]. (!)
  int min_landmarks = 10;
  double min_landmark_extent_m = 0.12;
  /// 1-sigma of its normal as these landmarks determine it [deg]. (!)
  double max_normal_sigma_deg = 3;
  /// Fewer landmarks, but so many, are enough if they determine its normal to
  /// max_spread_sigma_deg [deg] (0: never): large walls with hardly any texture have no more. (!)
  int min_spread_landmarks = 7;
  double max_spread_sigma_deg = 1;
  /// A plane unseen for longer is dormant: only a whole new sighting brings it back [s].
  double active_s = 1.5;
  /// A face is on a plane when its corners are within three sigmas of it, but between these [m].
  double min_gate_m = 0.02, max_gate_m = 0.05;
  /// Angle between a face's normal and the plane's [deg].
  double max_face_angle_deg = 25;
  /// Squared sigmas within which a sighting is a known plane (3 degrees of freedom). (!)
  double max_chi_square = 11.3;
  /// 1-sigma of a sighting's normal, both directions together, above which nothing is recognised in
  /// it: it could be anything that crosses there [deg].
  double max_sighting_sigma_deg = 2.5;
  /// How far along the plane a sighting may be from what is known of it [m].
  double max_gap_m = 2.5;
  /// Planes nearer than this and within 5 deg of a known one are the same, or not new yet [m].
  double min_separation_m = 0.05;
  /// Planes that turn out to be one surface are merged, and those that are none end.
  bool revise = true;
  /// Mean square of a plane's landmarks about it, as vision alone sees them, over what is expected
  /// of points that are known as well and a surface that is flat to 1 cm: more is a row of things,
  /// or two surfaces. (!)
  double max_scatter = 1.4;
  /// Squared sigmas by which a surface of second order fits them better (3 degrees of freedom, if
  /// it is also 6 mm rms off the plane): more is rough ground, or two surfaces, and is not
  /// reported. (!)
  double max_bend = 4;
  /// A plane leaves the estimator this long after it came in [s]; 0: it stays (the paper: 6).
  double max_age_s = 0;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("min_sightings", min_sightings, Range{1, 100}, "keyframes that must have shown it");
    v.Field("min_landmarks",
            min_landmarks,
            Range{3, 1000},
            "landmarks of a new plane, if they are close together");
    v.Field("min_landmark_extent_m",
            min_landmark_extent_m,
            Range{0, 10},
            "least spread across of its landmarks [m]");
    v.Field("max_normal_sigma_deg",
            max_normal_sigma_deg,
            Range{0.01, 90},
            "1-sigma of a new plane's normal by its landmarks [deg]");
    v.Field("min_spread_landmarks",
            min_spread_landmarks,
            Range{3, 1000},
            "landmarks of a new plane, if they are far apart");
    v.Field("max_spread_sigma_deg",
            max_spread_sigma_deg,
            Range{0, 90},
            "far apart: they determine its normal to this, 1-sigma; 0: never [deg]");
    v.Field("active_s", active_s, Range{0, 1e3}, "a plane unseen for longer is dormant [s]");
    v.Field("min_gate_m", min_gate_m, Range{0, 1}, "least gate for the corners of faces [m]");
    v.Field("max_gate_m", max_gate_m, Range{0, 1}, "largest gate for the corners of faces [m]");
    v.Field("max_face_angle_deg", max_face_angle_deg, Range{1, 90}, "normal of a face on a plane");
    v.Field("max_chi_square", max_chi_square, Range{0, 1e3}, "squared sigmas of recognition");
    v.Field(
        "max_sighting_sigma_deg",
        max_sighting_sigma_deg,
        Range{0.01, 90},
        "1-sigma of the normal (both directions together) of a sighting that is recognised [deg]");
    v.Field("max_gap_m", max_gap_m, Range{0, 1e3}, "along the plane, to what is known of it [m]");
    v.Field("min_separation_m",
            min_separation_m,
            Range{0, 10},
            "nearer to a known plane a new one must wait [m]");
    v.Field("revise", revise, Range{}, "planes are merged, and end when their landmarks misfit");
    v.Field(
        "max_scatter", max_scatter, Range{0.1, 100}, "landmarks about it, over what is expected");
    v.Field("max_bend",
            max_bend,
            Range{0.1, 1e6},
            "squared sigmas by which they lie on a bend; more is not reported");
    v.Field("max_age_s", max_age_s, Range{0, 1e6}, "a plane leaves after this; 0: it stays [s]");
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
  /// Angle off which planes are not related, and from which a wall has a heading of its own [deg].
  double max_angle_deg = 3, new_heading_deg = 8;
  /// The same for heights [m].
  double max_height_m = 0.02;
  /// Keyframes in a row in which a relation must have held.
  int min_keyframes = 5;
  /// Smaller planes are not related to others [m^2].
  double min_area_m2 = 1;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "relate planes to each other and to gravity");
    v.Field("gravity", gravity, Range{}, "walls are upright, floors level");
    v.Field("headings", headings, Range{}, "walls are parallel or at right angles");
    v.Field("same_height", same_height, Range{}, "level planes have one height");
    v.Field("slopes", slopes, Range{}, "oblique planes are parallel or at right angles");
    v.Field("max_angle_deg", max_angle_deg, Range{0, 20}, "angle off which planes are not related");
    v.Field("new_heading_deg", new_heading_deg, Range{0, 45}, "a wall has its own heading [deg]");
    v.Field("max_height_m", max_height_m, Range{0, 1}, "off which heights are not related [m]");
    v.Field("min_keyframes", min_keyframes, Range{1, 1000}, "keyframes in which it must hold");
    v.Field("min_area_m2", min_area_m2, Range{0, 1e3}, "smaller planes are not related [m^2]");
  }
};

/// Depths of support points where they lie on known planes (support_depths.h).
struct SupportDepthOptions {
  bool enabled = true;
  /// Farther from a plane than this, in sigmas of both, a point is not on it. (!)
  double max_sigma = 3;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "planes measure the depth of support points");
    v.Field("max_sigma", max_sigma, Range{0, 10}, "farther from the plane a point is not on it");
  }
};

/// What the support points of a keyframe tell the estimator of a plane (plane_measurements.h).
struct PlaneMeasurementOptions {
  bool enabled = true;
  /// Fewer points tell nothing.
  int min_points = 8;
  /// Points that are known worse across the plane do not count [m].
  double max_point_sigma_m = 0.05;
  /// Errors of neighbouring points are alike, and so are those of the next keyframe: what many
  /// points say together is worse than their own sigmas by this factor. (!)
  double sigma_scale = 2;
  /// Never known better than this [m], [deg]. (!)
  double min_sigma_m = 0.003, min_sigma_deg = 0.1;
  /// Nor used when the slope is known worse [deg].
  double max_sigma_deg = 5;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "support points measure known planes");
    v.Field("min_points", min_points, Range{4, 1000}, "points that a sighting needs");
    v.Field("max_point_sigma_m", max_point_sigma_m, Range{0, 1}, "of a point across the plane [m]");
    v.Field("sigma_scale", sigma_scale, Range{0.1, 100}, "on the sigmas of points together");
    v.Field("min_sigma_m", min_sigma_m, Range{0, 1}, "least 1-sigma of a distance [m]");
    v.Field("min_sigma_deg", min_sigma_deg, Range{0, 10}, "least 1-sigma of a slope [deg]");
    v.Field("max_sigma_deg", max_sigma_deg, Range{0, 90}, "of a slope, else no sighting [deg]");
  }
};

/// Which faces of the mesh are shown where planes are known (triangle_verdicts.h).
struct FaceVerdictOptions {
  bool enabled = true;
  /// A face with one or two corners on a plane is no surface when another is farther from the plane
  /// than this [m]. Less: flatter, and less of it. (!)
  double min_gap_m = 0.06;
  /// The same for a face whose corners lie on different planes and that passes farther than this
  /// from all of them [m].
  double max_cut_m = 0.03;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "known planes decide which faces are shown");
    v.Field("min_gap_m", min_gap_m, Range{0, 10}, "from the plane to the far end of a bridge [m]");
    v.Field("max_cut_m", max_cut_m, Range{0, 10}, "a face between planes is nearer to one [m]");
  }
};

struct RegularityOptions {
  DetectionOptions detection;
  PlaneTrackingOptions tracking;
  PlaneRelationOptions relations;
  PlaneMeasurementOptions sightings;
  SupportDepthOptions support_depths;
  FaceVerdictOptions faces;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Group("detection", detection);
    v.Group("tracking", tracking);
    v.Group("relations", relations);
    v.Group("sightings", sightings);
    v.Group("support_depths", support_depths);
    v.Group("faces", faces);
  }
};

}  // namespace facet
