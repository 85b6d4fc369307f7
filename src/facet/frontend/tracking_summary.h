// SPDX-License-Identifier: BSD-2-Clause
// What happened to the points of the previous frame.
#pragma once

namespace facet {

struct TrackingSummary {
  int num_tracked = 0;
  int num_refreshed = 0;     ///< tracked, with a new reference patch: other landmarks
  int num_out_of_view = 0;   ///< lost: predicted or found outside the image
  int num_not_found = 0;     ///< lost: no alignment, too dissimilar, or no texture
  int num_not_returned = 0;  ///< lost: tracking back ended elsewhere
  bool retried = false;      ///< too many were lost at first and were sought again more widely
  int num_lost() const { return num_out_of_view + num_not_found + num_not_returned; }
};

}  // namespace facet
