// SPDX-License-Identifier: BSD-2-Clause
#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include "facet/map/map_snapshot.h"

namespace facet {

/// How many different landmarks were ever attached to a plane. Only the estimator knows: it refuses
/// some that the tracker proposes, and some are detached and attached again.
class LandmarkCount {
 public:
  /// After a keyframe; landmarks are sorted by id, and ids are never used again.
  void Update(std::span<const LandmarkEstimate> landmarks, PlaneId plane);

  /// The two planes turned out to be the same.
  void Add(const LandmarkCount& other);

  int num() const { return num_; }

 private:
  std::vector<LandmarkId> in_window_;  ///< counted ones that the estimator still has, ascending
  std::vector<LandmarkId> spare_;      ///< keeps its memory
  int num_ = 0;
};

inline void LandmarkCount::Update(std::span<const LandmarkEstimate> landmarks, PlaneId plane) {
  spare_.clear();
  auto counted = in_window_.begin();
  for (const LandmarkEstimate& landmark : landmarks) {
    while (counted != in_window_.end() && *counted < landmark.id)
      ++counted;
    const bool is_counted = counted != in_window_.end() && *counted == landmark.id;
    if (!is_counted && !landmark.IsOn(plane)) continue;
    spare_.push_back(landmark.id);
    if (!is_counted) ++num_;
  }
  in_window_.swap(spare_);
}

inline void LandmarkCount::Add(const LandmarkCount& other) {
  spare_.clear();
  std::set_union(in_window_.begin(),
                 in_window_.end(),
                 other.in_window_.begin(),
                 other.in_window_.end(),
                 std::back_inserter(spare_));
  const auto num_of_both = in_window_.size() + other.in_window_.size() - spare_.size();
  num_ += other.num_ - static_cast<int>(num_of_both);
  in_window_.swap(spare_);
}

}  // namespace facet
