// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/motion.h"

#include <iomanip>
#include <sstream>

#include <gtest/gtest.h>

#include "facet/io/test_sequence.h"

namespace facet {
namespace {

/// A flight as recorded: poses with 1 mm and 1 mrad of noise, samples of an IMU with constant
/// biases.
class RecordedMotionTest : public testing::Test {
 protected:
  static constexpr double kFlight_s = 12;

  RecordedMotionTest() : path_(SplineTrajectory::Fit(MakeFlight(kFlight_s, 1))) {
    std::ostringstream imu;
    imu << std::setprecision(17);
    for (Timestamp t = path_.begin(); t <= path_.end(); t = t + FromSeconds(0.005)) {
      const ImuSample ideal = path_.IdealImuAt(t);
      const Vector3d gyro = ideal.gyro + bias_.b_g, accel = ideal.accel + bias_.b_a;
      imu << t.ns << ',' << gyro.x() << ',' << gyro.y() << ',' << gyro.z() << ',' << accel.x()
          << ',' << accel.y() << ',' << accel.z() << '\n';
    }
    WriteText(folder_ / "imu.csv", imu.str());
  }

  /// `last_columns` follow the pose.
  void WriteTruth(const std::string& last_columns) const {
    Rng rng(1);
    std::ostringstream truth;
    truth << std::setprecision(17);
    for (Timestamp t = path_.begin(); t <= path_.end(); t = t + FromSeconds(0.005)) {
      const SE3 exact = path_.At(t).state.T_WB;
      const Vector3d p = exact.p + 1e-3 * rng.Normal3();
      const Quaterniond q = exact.q * ExpSO3(1e-3 * rng.Normal3());
      truth << t.ns << ',' << p.x() << ',' << p.y() << ',' << p.z() << ',' << q.w() << ',' << q.x()
            << ',' << q.y() << ',' << q.z() << last_columns << '\n';
    }
    WriteText(folder_ / "truth.csv", truth.str());
  }

  Motion Load() const { return LoadMotion(folder_ / "truth.csv", folder_ / "imu.csv", {1, 8, 20}); }

  const ImuBias bias_{{-0.003, 0.02, 0.08}, {0.1, -0.05, 0.2}};  // as large as EuRoC's
  SplineTrajectory path_;
  TempFolder folder_;
};

TEST_F(RecordedMotionTest, BiasesThatTheRecordLacksAreFound) {
  for (const char* columns : {"", ",0,0,0,nan,nan,nan,nan,nan,nan"}) {
    WriteTruth(columns);
    const Motion motion = Load();
    const ImuBias& found = motion.recorded.front().bias;
    EXPECT_LT((found.b_g - bias_.b_g).norm(), 3e-4) << columns;  // 1 mrad at both ends of 12 s
    EXPECT_LT((found.b_a - bias_.b_a).norm(), 0.02) << columns;
    EXPECT_LT(motion.smoothing->rotation_rms_deg, 0.15) << columns;
    EXPECT_LT(motion.smoothing->position_rms_m, 3e-3) << columns;
  }
}

TEST_F(RecordedMotionTest, BiasesOfTheRecordAreKept) {
  WriteTruth(",0,0,0,-0.003,0.02,0.08,0.1,-0.05,0.2");
  const Motion motion = Load();
  EXPECT_EQ(motion.recorded.front().bias.b_g, bias_.b_g);
  EXPECT_EQ(motion.recorded.back().bias.b_a, bias_.b_a);
}

}  // namespace
}  // namespace facet
