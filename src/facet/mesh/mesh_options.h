// SPDX-License-Identifier: BSD-2-Clause
// Every option of the mesh. `facet config` prints those that users turn.
#pragma once

#include <algorithm>

#include "facet/base/options.h"

namespace facet {

/// Limits of one face in 3D (face_filter.h). The defaults are the loose level, for the mesh.
struct FaceLimits {
  /// Shortest over longest side. Raising it removes narrow faces.
  double min_side_ratio = 0.1;
  /// Extent across the view over extent in depth. Raising it removes faces that lead away from the
  /// camera, first of all those between a near and a far surface.
  double min_elongation = 1.2;
  /// Longest side [m].
  double max_side_m = 3.0;
  /// Longest side over the smallest distance; 0.44 is about 200 px with EuRoC's cameras.
  double max_side_per_depth = 0.5;
  /// Smallest angle [deg].
  double min_angle_deg = 6;
  /// Largest angle between the normal and the line of sight [deg].
  double max_grazing_deg = 82;
  /// Greatest ratio of a vertex's 1-sigma of distance to its distance.
  double max_depth_sigma = 0.06;
  bool grow_with_distance = false;  ///< max_side_m and max_depth_sigma do (far_surfaces.h)
  /// Differences in depth below this many sigma are noise and not held against a face.
  double noise_sigmas = 1;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "min_side_ratio", min_side_ratio, Range{0, 1}, "least ratio of shortest to longest side");
    v.Field("min_elongation",
            min_elongation,
            Range{0, 100},
            "least ratio of the extent across the view to that in depth");
    v.Field("max_side_m", max_side_m, Range{0.01, 1e3}, "greatest length of a side [m]");
    v.Field("max_side_per_depth",
            max_side_per_depth,
            Range{0.01, 1e3},
            "greatest ratio of the longest side to the smallest distance");
    v.Field("min_angle_deg", min_angle_deg, Range{0, 60}, "least angle of a corner [deg]");
    v.Field("max_grazing_deg",
            max_grazing_deg,
            Range{0, 90},
            "greatest angle between normal and line of sight [deg]");
    v.Field("max_depth_sigma",
            max_depth_sigma,
            Range{1e-4, 1e3},
            "greatest ratio of a vertex's 1-sigma of distance to its distance");
    v.Field("noise_sigmas", noise_sigmas, Range{0, 10}, "depth differences below this are noise");
  }
};

/// The strict level: faces whose normals may be trusted enough to vote for planes.
inline FaceLimits StrictFaceLimits() {
  FaceLimits limits;
  limits.min_side_ratio = 0.3;
  limits.min_elongation = 0.4;
  limits.max_side_m = 1.2;
  limits.max_side_per_depth = 0.5;
  limits.min_angle_deg = 15;
  limits.max_grazing_deg = 78;
  limits.max_depth_sigma = 0.03;
  limits.noise_sigmas = 0;
  limits.grow_with_distance = true;
  return limits;
}

/// Faces that look like the gap between a near and a far surface (size, elongation, grazing angle),
/// and yet may be a floor or a wall seen at a flat angle: kept if a corner's surroundings are
/// plane. A corner of a gap always has other surfaces around it.
struct PlaneRescueOptions {
  bool enabled = true;
  /// Longest side of such a face over the smallest distance. No option: it follows the view.
  double max_side_per_depth = 0.8;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "keep steep faces whose neighbours lie on one plane");
  }
};

/// Which old faces give way to what the newest keyframe sees (view_check.h).
struct ContradictionOptions {
  /// Faces whose vertices are all seen but which the newest triangulation lacks are removed.
  bool by_triangulation = true;
  /// Faces that lie on the newest keyframe's faces, or before what it sees, are removed.
  bool by_view = true;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("by_triangulation",
            by_triangulation,
            Range{},
            "remove older faces that the newest triangulation of their vertices lacks");
    v.Field("by_view",
            by_view,
            Range{},
            "remove older faces that newer ones cover or that lines of sight cross");
  }
};

/// The map of the whole run (surface_map.h).
struct SurfaceMapOptions {
  bool enabled = true;
  /// Side of a voxel [m]. Smaller: finer, and memory grows with its inverse square.
  double voxel_m = 0.08;
  /// Beyond a side where nothing was seen a surface is expected to go on this far [m]: the corners
  /// between which faces hang are rarely at the boundary of things. More: more complete, less
  /// exact.
  double boundary_m = 0.2;
  /// That part counts by this share of the face's weight.
  double boundary_weight = 0.2;
  /// What each sight line takes from the weight of a surface that it passes through. More: wrong
  /// surfaces go sooner, and with them some of the thin and the seldom seen ones. 0: nothing.
  double carving_weight = 1;
  /// Holes with at most this perimeter are closed if their boundary is plane [m]; 0: none.
  double max_hole_m = 2.0;
  /// When the map is this large it grows no more; where it exists it is still improved [MB]. 1000
  /// m2 need about 60.
  double max_memory_mb = 2000;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field(
        "enabled", enabled, Range{}, "keep the surfaces that leave the horizon", Audience::kUsers);
    v.Field("voxel_m", voxel_m, Range{0.01, 1}, "side of a voxel [m]", Audience::kUsers);
    v.Field("boundary_m",
            boundary_m,
            Range{0, 5},
            "surfaces are continued this far beyond what was seen [m]");
    v.Field("boundary_weight",
            boundary_weight,
            Range{0, 1},
            "weight of that part relative to the face");
    v.Field("carving_weight",
            carving_weight,
            Range{0, 1e6},
            "weight that each line of sight takes from a surface it crosses");
    v.Field("max_memory_mb",
            max_memory_mb,
            Range{1, 1e6},
            "from this much memory on the map takes in no new places [MB]",
            Audience::kUsers);
    v.Field(
        "max_hole_m", max_hole_m, Range{0, 100}, "plane holes up to this perimeter are closed [m]");
  }
};

/// Points besides the tracked corners that the front end matched left to right in each keyframe.
struct SupportOptions {
  /// Takes the place of the faces' limit: where points are dense, a large face is a gap in which
  /// none could be matched.
  double max_side_per_depth = 0.3;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("max_side_per_depth",
            max_side_per_depth,
            Range{0.01, 1e3},
            "with support points: greatest ratio of a face's side to its depth");
  }
};

/// Points on the border of the image, continued from the planes beside it (border_points.h). Only
/// without support points, which reach the border themselves.
struct BorderOptions {
  bool enabled = true;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "continue planes to the border of the image");
  }
};

struct MeshOptions {
  bool enabled = true;
  /// How long faces stay, where they were, after the estimator has forgotten a vertex [s]. 0: they
  /// go with it, as in the paper.
  double horizon_s = 3;
  /// Keyframes' landmarks with fewer observations have no vertex.
  int min_observations = 2;
  /// Corners that the estimator does not know yet, or refused, are vertices where they were matched
  /// left to right: they live as long as their keyframe.
  bool unknown_corners = true;
  FaceLimits faces;
  FaceLimits voting = StrictFaceLimits();
  PlaneRescueOptions plane_rescue;
  ContradictionOptions contradictions;
  SupportOptions support;
  BorderOptions border;
  SurfaceMapOptions map;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Field("enabled", enabled, Range{}, "build the mesh", Audience::kUsers);
    v.Field("horizon_s",
            horizon_s,
            Range{0, 1e3},
            "faces stay this long after the estimator dropped their landmarks [s]",
            Audience::kUsers);
    v.Field("min_observations",
            min_observations,
            Range{1, 100},
            "least number of frames that saw a vertex");
    v.Field("unknown_corners",
            unknown_corners,
            Range{},
            "matched corners that are no landmarks yet are vertices, too");
    v.Group("faces", faces);
    v.Group("voting", voting);
    v.Group("plane_rescue", plane_rescue);
    v.Group("contradictions", contradictions);
    v.Group("support", support);
    v.Group("border", border);
    v.Group("map", map);
  }
};

/// The options in force where the front end matches support points: large faces are gaps, and what
/// can be matched near the border of the image is measured.
inline MeshOptions WithSupportPoints(MeshOptions options) {
  options.faces.max_side_per_depth =
      std::min(options.faces.max_side_per_depth, options.support.max_side_per_depth);
  options.border.enabled = false;
  return options;
}

/// The options for a view whose points are `angle` times as far apart on the sphere of rays as
/// those of EuRoC's cameras (camera/image_extent.h): faces between them are larger by as much, and
/// an error in depth tilts them less.
inline MeshOptions ForPointsApart(MeshOptions options, double angle) {
  for (FaceLimits* limits : {&options.faces, &options.voting}) {
    limits->max_side_per_depth *= angle;
    limits->max_depth_sigma *= angle;
  }
  options.plane_rescue.max_side_per_depth *= angle;
  return options;
}

}  // namespace facet
