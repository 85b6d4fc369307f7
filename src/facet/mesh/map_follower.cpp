// SPDX-License-Identifier: BSD-2-Clause
#include "facet/mesh/map_follower.h"

namespace facet {

void MapFollower::Take(const std::vector<SurfaceMap::Block>& blocks) {
  for (const SurfaceMap::Block& block : blocks) {
    map_.SetBlock(block);
    Mark(block.index);
  }
}

void MapFollower::MarkAll() {
  for (const SurfaceMap::Block& block : map_.blocks())
    Mark(block.index);
}

// The cells of a block reach into the ones below it, and the other way round.
void MapFollower::Mark(const CubeIndex& at) {
  for (int i = 0; i < 8; ++i) {
    const int x = i & 1, y = i >> 1 & 1, z = i >> 2 & 1;
    changed_.insert(PartOf({at.x + x, at.y + y, at.z + z}));
    changed_.insert(PartOf({at.x - x, at.y - y, at.z - z}));
  }
}

std::optional<MapFollower::Part> MapFollower::TakePart() {
  if (changed_.empty()) return std::nullopt;
  const CubeIndex index = *changed_.begin();
  changed_.erase(changed_.begin());
  return Part{index, ExtractPart(map_, index)};
}

}  // namespace facet
