// SPDX-License-Identifier: BSD-2-Clause
// Two maps of places as one: where the second lies in the first is found by what their places look
// like, without images.
#pragma once

#include "facet/loop/saved_map.h"

namespace facet {

struct MapMerge {
  bool is_found = false;
  bool is_ambiguous = false;  ///< the second looks like more than one part of the first
  int num_compared = 0;       ///< pairs of places, by appearance
  int num_alike = 0;          ///< of them those with a common pose
  int num_closures = 0;       ///< of them those that are believed
  /// In the frame of the first, if it was found: the runs of the first, then those of the second.
  SavedMap map;
};

/// As for a run that is looked for in a map (place_map.h): three places of the second that are not
/// one view have to say the same, while no others that count say something else. Then all that
/// agree tie the maps together. Deterministic; each of the maps has places.
MapMerge MergeMaps(const SavedMap& first, const SavedMap& second);

}  // namespace facet
