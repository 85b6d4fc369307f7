// SPDX-License-Identifier: BSD-2-Clause
// A camera that turns before a texture at infinity.
#include "facet/plausibility/image_rotation.h"

#include <gtest/gtest.h>

#include "facet/geometry/so3.h"
#include "facet/sim/euroc_rig.h"
#include "facet/testing/frontend/synthetic_image.h"

namespace facet {
namespace {

class ImageRotationTest : public ::testing::Test {
 protected:
  /// What the camera sees at an angle about its vertical axis.
  cv::Mat ImageAt(double angle) const {
    const Matrix3d R_WC = ExpSO3({0, angle, 0}).toRotationMatrix();
    return testing::Render(
        texture_, camera_.width(), camera_.height(), [&](double x, double y) -> Vector2d {
          const auto bearing_C = camera_.Unproject({x, y});
          const Vector3d bearing = R_WC * bearing_C.value_or(Vector3d::UnitZ());
          return 400 * bearing.head<2>() / bearing.z();
        });
  }

  void Begin(double angle) {
    left_.Build(ImageAt(angle), images_.num_levels());
    images_.Begin(left_.now);
  }
  double Follow(double angle) {
    left_.Build(ImageAt(angle), images_.num_levels());
    return images_.Follow(left_);
  }

  /// Of the newest image against the first one of its interval, about the vertical axis.
  double Turned() const {
    const auto rotation = images_.Estimate();
    return rotation ? rotation->theta.y() : 0;
  }

  static constexpr double kTurn = 0.02, kTolerance = 0.002;  // rad
  const CameraModel camera_ = EurocRig().cameras[0];
  const testing::WaveTexture texture_{1};
  ImageRotation images_{camera_};
  PyramidPair left_;
};

TEST_F(ImageRotationTest, MeasuresATurnFromWhereItBegan) {
  Begin(0);
  EXPECT_GT(Follow(kTurn), 0.7);
  EXPECT_NEAR(std::abs(Turned()), kTurn, kTolerance);
  EXPECT_GT(Follow(2 * kTurn), 0.6);
  EXPECT_NEAR(std::abs(Turned()), 2 * kTurn, kTolerance);
}

TEST_F(ImageRotationTest, BeginsAgainWithTheCornersThatItHas) {
  EXPECT_FALSE(images_.BeginAgain()) << "there are none";
  Begin(0);
  EXPECT_FALSE(images_.BeginAgain()) << "none was followed";
  Follow(kTurn);
  ASSERT_TRUE(images_.BeginAgain());
  EXPECT_GT(Follow(2 * kTurn), 0.7);
  EXPECT_NEAR(std::abs(Turned()), kTurn, kTolerance) << "from the second image on";
}

TEST_F(ImageRotationTest, DoesNotBeginAgainWithTooFewCorners) {
  Begin(0);
  EXPECT_LT(Follow(1), 0.3) << "of another part of the world";
  EXPECT_FALSE(images_.BeginAgain());
}

// Half of it would have too few cells.
TEST(SmallImageRotationTest, HasCornersEnough) {
  CameraIntrinsics k;
  k.width = 320;
  k.height = 240;
  k.fx = k.fy = 200;
  k.cx = 160;
  k.cy = 120;
  const CameraModel camera(k);
  const auto image = [&](double shift) {
    return testing::Render(testing::WaveTexture(1), k.width, k.height, [&](double x, double y) {
      return Vector2d(x + shift, y);
    });
  };
  ImageRotation images(camera);
  PyramidPair left;
  left.Build(image(0), images.num_levels());
  images.Begin(left.now);
  left.Build(image(3), images.num_levels());
  EXPECT_GT(images.Follow(left), 0.7);
  EXPECT_TRUE(images.Estimate());
}

}  // namespace
}  // namespace facet
