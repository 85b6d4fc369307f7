// SPDX-License-Identifier: BSD-2-Clause
// What the shared library shows: nothing of Facet.
#pragma once

struct TrackedPosition {
  bool is_known = false;
  double x = 0, y = 0, z = 0;  ///< of the body in the world [m]
  int num_calls = 0;           ///< of the observer of poses
};

/// Tracks two seconds of a camera pair at rest before a wall of random squares.
TrackedPosition TrackAtRest();
