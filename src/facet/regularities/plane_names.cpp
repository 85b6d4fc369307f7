// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/plane_names.h"

#include <unordered_map>

namespace facet {

void UseCurrentPlanes(std::span<const PlaneRecord> records, std::vector<int>& plane_ids) {
  std::unordered_map<std::int64_t, int> current;
  for (const PlaneRecord& record : records) {
    const int id = static_cast<int>(record.id.value);
    current[record.id.value] = id;
    for (PlaneId absorbed : record.absorbed)
      current.try_emplace(absorbed.value, id);
  }
  for (int& id : plane_ids) {
    const auto found = current.find(id);
    id = found == current.end() ? -1 : found->second;
  }
}

}  // namespace facet
