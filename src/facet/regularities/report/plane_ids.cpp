// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/report/plane_ids.h"

#include <unordered_map>

namespace facet {

void UseCurrentPlaneIds(std::span<const PlaneRecord> records, std::vector<int>& plane_ids) {
  std::unordered_map<std::int64_t, int> current;
  for (const PlaneRecord& record : records) {
    const int id = static_cast<int>(record.id.value);
    current[record.id.value] = id;
    for (const PlaneId merged : record.merged_ids)
      current.try_emplace(merged.value, id);
  }
  for (int& id : plane_ids) {
    const auto found = current.find(id);
    id = found == current.end() ? -1 : found->second;
  }
}

}  // namespace facet
