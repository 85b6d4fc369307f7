// SPDX-License-Identifier: BSD-2-Clause
#include "facet/loop/place_record.h"

#include <cmath>

namespace facet {

void SetLenses(const std::vector<CameraIntrinsics>& lenses, std::deque<PlaceRecord>& places) {
  std::vector<std::shared_ptr<const CameraModel>> cameras;
  for (const CameraIntrinsics& lens : lenses)
    cameras.push_back(std::make_shared<const CameraModel>(lens));
  for (PlaceRecord& place : places) {
    if (static_cast<std::size_t>(place.session) < cameras.size())
      place.lens = cameras[static_cast<std::size_t>(place.session)];
  }
}

std::vector<const PlaceRecord*> WithNeighbours(const std::deque<PlaceRecord>& places, int place) {
  constexpr int kNeighbours = 2;
  constexpr double kNear_s = 5;
  std::vector<const PlaceRecord*> found = {&places[place]};
  for (int i = place - kNeighbours; i <= place + kNeighbours; ++i) {
    if (i == place || i < 0 || i >= static_cast<int>(places.size())) continue;
    const PlaceRecord& other = places[i];
    if (other.session == places[place].session && other.segment == places[place].segment &&
        std::abs(ToSeconds(other.t - places[place].t)) < kNear_s)
      found.push_back(&other);
  }
  return found;
}

}  // namespace facet
