// SPDX-License-Identifier: BSD-2-Clause
// The rungs of the ladder: the same simulated measurements, with planes from better and better
// sources.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/consistency_run.h"
#include "ladder_planes.h"

namespace facet {

/// Options of the search; the estimator's come with ConsistencyOptions.
struct SearchOptions {
  MeshOptions mesh;
  RegularityOptions regularities;

  template <class Visitor>
  void Visit(Visitor& v) {
    v.Group("mesh", mesh);
    v.Group("regularities", regularities);
  }
};

struct Rung {
  std::string key;                                                       ///< for the command line
  std::string name;                                                      ///< for people
  std::function<PlanePolicy(const SimulatedRun&, SearchQuality&)> make;  ///< empty: no planes
  std::string against;  ///< key of the rung whose error it is also compared with; may be empty
};

/// All of them; S is the first.
std::vector<Rung> MakeRungs(const SearchOptions& search);

/// S, and of the others those with one of these keys; all if there are none. Throws
/// std::runtime_error, with the keys, for an unknown one.
std::vector<Rung> SelectRungs(std::vector<Rung> rungs, const std::vector<std::string>& keys);

struct Outcome {
  double ate_m = 0;
  double pose_nees = 0, yaw_nees = 0;  ///< over their degrees of freedom, mean over the frames
  int num_resets = 0;
  double cpu_s = 0;
  SearchQuality quality;
};

Outcome RunRung(const SimulatedRun& run, const ConsistencyOptions& options, const Rung& rung);

}  // namespace facet
