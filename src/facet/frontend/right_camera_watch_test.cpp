// SPDX-License-Identifier: BSD-2-Clause
#include "facet/frontend/right_camera_watch.h"

#include <gtest/gtest.h>

#include "facet/base/random.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

constexpr int kNumTracks = 150;

/// Of points in front of the rig, without noise.
std::vector<StereoRays> Matches(const StereoRig& rig, int num = 60) {
  Rng rng(1);
  std::vector<StereoRays> matches;
  while (static_cast<int>(matches.size()) < num) {
    const double z = rng.Uniform(1, 6);
    const Vector3d p_C0(z * rng.Uniform(-0.7, 0.7), z * rng.Uniform(-0.45, 0.45), z);
    const Vector3d p_C1 = rig.T_C1C0() * p_C0;
    matches.push_back({p_C0.normalized(), p_C1.normalized()});
  }
  return matches;
}

TEST(RightCameraWatchTest, UsualKeyframesAreNotSuspicious) {
  RightCameraWatch watch;
  for (int i = 0; i < 100; ++i)
    EXPECT_FALSE(watch.IsSuspicious(Timestamp{}, kNumTracks, 90 + 40 * (i % 2))) << i;
  EXPECT_FALSE(watch.IsSuspicious(Timestamp{}, 20, 0)) << "too few tracks say nothing";
}

TEST(RightCameraWatchTest, ATurnIsTakenFromASecondOfKeyframes) {
  const StereoRig rig = EurocRig();
  const Vector3d omega(0.004, 0, 0);
  RightCameraWatch watch;
  for (int i = 0; i < 20; ++i)
    EXPECT_FALSE(watch.IsSuspicious(Timestamp{}, kNumTracks, 120));
  const std::vector<StereoRays> matches = Matches(TurnedRig(rig, omega));
  // One that is hidden for a moment in between begins anew.
  Timestamp t;
  for (const int num_near : {10, 10, 10, 120, 10, 10, 10, 10}) {
    t = t + FromSeconds(0.3);
    if (!watch.IsSuspicious(Timestamp{}, kNumTracks, num_near)) continue;
    EXPECT_FALSE(watch.Add(t, rig, matches));
  }
  ASSERT_TRUE(watch.IsSuspicious(Timestamp{}, kNumTracks, 10));
  const auto turn = watch.Add(t + FromSeconds(0.3), rig, matches);
  ASSERT_TRUE(turn);
  EXPECT_LT((turn->omega - omega).norm(), 1e-4);
  EXPECT_FALSE(watch.IsTrustedAt(t + FromSeconds(0.3))) << "it may also be off along the lines";
}

// A bump before the run: the first keyframes are as bad as all others.
TEST(RightCameraWatchTest, ABadBeginningIsSuspicious) {
  RightCameraWatch watch;
  EXPECT_TRUE(watch.IsTrustedAt(Timestamp{}));
  EXPECT_TRUE(watch.IsSuspicious(Timestamp{}, kNumTracks, 10));
  EXPECT_FALSE(watch.IsTrustedAt(Timestamp{} + FromSeconds(1)));
  EXPECT_TRUE(watch.IsTrustedAt(Timestamp{} + FromSeconds(10)));
}

// A plain wall after a knock proves nothing.
TEST(RightCameraWatchTest, TooFewTracksKeepTheDoubt) {
  RightCameraWatch watch;
  Timestamp t;
  EXPECT_TRUE(watch.IsSuspicious(t, kNumTracks, 10));
  for (int i = 0; i < 40; ++i) {
    t = t + FromSeconds(0.3);
    EXPECT_FALSE(watch.IsSuspicious(t, 30, 10));
    EXPECT_FALSE(watch.IsTrustedAt(t)) << i;
  }
  for (int i = 0; i < 20; ++i) {
    t = t + FromSeconds(0.3);
    EXPECT_FALSE(watch.IsSuspicious(t, kNumTracks, 120));
  }
  EXPECT_TRUE(watch.IsTrustedAt(t));
}

// A hand in front of the right lens: nothing is found however wide the gate, and hardly looked for.
TEST(RightCameraWatchTest, ACoveredLensIsNoTurnAndCostsLittle) {
  const StereoRig rig = EurocRig();
  RightCameraWatch watch;
  int num_looks = 0;
  for (int i = 0; i < 300; ++i) {
    if (!watch.IsSuspicious(Timestamp{}, kNumTracks, 0)) continue;
    ++num_looks;
    EXPECT_FALSE(watch.Add(Timestamp{} + FromSeconds(0.3 * i), rig, {}));
  }
  EXPECT_LE(num_looks, 100);
  EXPECT_GE(num_looks, 10) << "it is still looked for";
}

}  // namespace
}  // namespace facet
