// SPDX-License-Identifier: BSD-2-Clause
// What a search for planes would say that knows the truth.
#pragma once

#include <map>

#include "consistency_run.h"

namespace facet {

struct OraclePlaneOptions {
  double max_age_s = 0;       ///< a plane ends this long after its creation; 0: stays all run
  int min_landmarks = 12;     ///< needed to create a plane
  double min_extent_m = 0.2;  ///< spread of the landmarks in the narrow direction
};

/// True surfaces, true membership; only the values of the planes are estimated. A plane begins at
/// the fit through the present estimates of its landmarks.
class OraclePlanes {
 public:
  OraclePlanes(const SimulatedRun& run, const OraclePlaneOptions& options)
      : run_(run), options_(options) {}

  PlaneAssignments operator()(const FrameObservations& observations, const MapSnapshot& snapshot);

 private:
  struct Known {
    PlaneId id;
    Timestamp since;
  };

  void EndOld(Timestamp now, PlaneAssignments& out);

  const SimulatedRun& run_;
  OraclePlaneOptions options_;
  std::map<PlaneId, Known> known_;  ///< by surface
  std::int64_t next_id_ = 0;
};

}  // namespace facet
