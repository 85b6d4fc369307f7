// SPDX-License-Identifier: BSD-2-Clause
#include "facet/regularities/report/plane_ids.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

TEST(PlaneIds, FollowMergersAndForgetWhatIsNoPlane) {
  std::vector<PlaneRecord> records(2);
  records[0].id = PlaneId{1};
  records[0].merged_ids = {PlaneId{4}, PlaneId{2}};
  records[1].id = PlaneId{3};
  std::vector<int> plane_ids = {1, 2, 3, 4, -1, 0, 7};
  UseCurrentPlaneIds(records, plane_ids);
  EXPECT_EQ(plane_ids, (std::vector<int>{1, 1, 3, 1, -1, -1, -1}));
  UseCurrentPlaneIds({}, plane_ids);
  EXPECT_EQ(plane_ids, std::vector<int>(7, -1));
}

}  // namespace
}  // namespace facet
