// SPDX-License-Identifier: BSD-2-Clause
#include "facet/viewer/view_access.h"

#include <gtest/gtest.h>

namespace facet {
namespace {

bool Allows(const ViewAccess& access,
            std::string_view host,
            std::optional<std::string_view> origin = {},
            std::string_view target = "/") {
  return access.Refusal({host, origin, target}) == nullptr;
}

TEST(ViewAccess, OnLoopbackOnlyNamesOfThisMachineAreAnswered) {
  const ViewAccess access("127.0.0.1", "");
  EXPECT_TRUE(Allows(access, "127.0.0.1:8470"));
  EXPECT_TRUE(Allows(access, "localhost:9000"));  // a port that ssh forwards
  EXPECT_TRUE(Allows(access, "[::1]:8470"));
  for (const char* host : {"",
                           "evil.example",
                           "evil.example:8470",
                           "127.0.0.1.evil.example:8470",
                           "192.168.1.5:8470",
                           "[::1",
                           "localhost.evil.example"}) {
    EXPECT_FALSE(Allows(access, host)) << host;
  }
}

TEST(ViewAccess, PagesOfOtherSitesAreRefused) {
  const ViewAccess access("127.0.0.1", "");
  EXPECT_TRUE(Allows(access, "127.0.0.1:8470", "http://127.0.0.1:8470"));
  for (const char* origin : {"http://evil.example",
                             "null",
                             "",
                             "http://127.0.0.1:8471",
                             "https://127.0.0.1:8470",
                             "http://127.0.0.1:8470.evil.example"}) {
    EXPECT_FALSE(Allows(access, "127.0.0.1:8470", origin)) << origin;
  }
}

TEST(ViewAccess, ForOtherMachinesTheTokenDecides) {
  const ViewAccess access("0.0.0.0", "secret");
  EXPECT_TRUE(Allows(access, "drone.local:8470", {}, "/?token=secret"));
  EXPECT_TRUE(Allows(access, "10.0.0.7:8470", {}, "/live?a=b&token=secret&c"));
  EXPECT_FALSE(Allows(access, "", {}, "/?token=secret"));
  for (const char* target : {"/",
                             "/?token=",
                             "/?token=secre",
                             "/?token=secrets",
                             "/?token=Secret",
                             "/token=secret",
                             "/?Token=secret",
                             "/?xtoken=secret"}) {
    EXPECT_FALSE(Allows(access, "10.0.0.7:8470", {}, target)) << target;
  }
}

TEST(ViewAccess, TokensAreLongAndDiffer) {
  EXPECT_EQ(RandomToken().size(), 32u);
  EXPECT_NE(RandomToken(), RandomToken());
}

}  // namespace
}  // namespace facet
