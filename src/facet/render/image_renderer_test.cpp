// SPDX-License-Identifier: BSD-2-Clause
// Where rendered surfaces appear in the images against where the camera model says they are.
#include "facet/render/image_renderer.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "facet/camera/stereo_rig.h"
#include "facet/geometry/so3.h"
#include "facet/render/shape_builder.h"
#include "facet/sim/euroc_rig.h"

namespace facet {
namespace {

/// A tilted sheet in front of the rig, alone in space, and the renderer of it.
struct SheetScene {
  explicit SheetScene(std::uint64_t seed) : materials(1, {}) {
    Rng rng(seed);
    ShapeBuilder builder(materials, rng);
    const Vector3d center(rng.Uniform(-0.4, 0.4), rng.Uniform(-0.3, 0.3), rng.Uniform(1.5, 3));
    T_BO = EurocRig().T_BC[0] * SE3(ExpSO3(0.5 * rng.Normal3()), center);
    builder.Place(T_BO);
    builder.AddPatch({"sheet", materials.Get("lamp")},
                     {-half.x(), -half.y(), 0},
                     {2 * half.x(), 0, 0},
                     {0, 2 * half.y(), 0});
    mesh = builder.TakeMesh();
    rays = std::make_unique<RayScene>(mesh);
    materials.Paint({materials.Get("lamp")}, 1);
    BakeLight(*rays, lighting, 1, 1, mesh);
    renderer = std::make_unique<ImageRenderer>(mesh, materials, *rays, lighting);
  }
  Vector3d PointAt(double s, double t) const {  // s, t in [-1, 1]
    return T_BO * Vector3d(s * half.x(), t * half.y(), 0);
  }

  MaterialLibrary materials;
  Lighting lighting;
  Vector2d half{0.6, 0.45};
  SE3 T_BO;  // the body is at the origin of the world
  SceneMesh mesh;
  std::unique_ptr<RayScene> rays;
  std::unique_ptr<ImageRenderer> renderer;
};

/// Distance along a row between the true edge of the sheet and the border in the id buffer.
struct BorderErrors {
  double sum = 0, sum_beyond = 0;  // signed; what a pixel grid cannot explain
  int count = 0;
  void Add(double error) {
    sum += error;
    sum_beyond += std::max(0.0, std::abs(error) - 0.5);
    ++count;
  }
};

void CompareEdge(const cv::Mat1i& ids,
                 const CameraModel& camera,
                 const std::vector<Vector3d>& edge_C,
                 BorderErrors& errors) {
  for (std::size_t i = 1; i < edge_C.size(); ++i) {
    const auto a = camera.Project(edge_C[i - 1]), b = camera.Project(edge_C[i]);
    if (!a || !b || std::floor(a->y()) == std::floor(b->y())) continue;
    const int y = static_cast<int>(std::floor(std::max(a->y(), b->y())));
    const double share = (y - a->y()) / (b->y() - a->y());
    const double x = a->x() + share * (b->x() - a->x());
    // Nearly horizontal edges meet a row at a point that says little about the error.
    if (std::abs(b->y() - a->y()) < 0.5 * std::abs(b->x() - a->x())) continue;
    if (y < 0 || y >= ids.rows || x < 4 || x > ids.cols - 5) continue;
    double best = 10;
    for (int k = static_cast<int>(x) - 3; k <= static_cast<int>(x) + 3; ++k) {
      const bool is_border = (ids(y, k) >= 0) != (ids(y, k + 1) >= 0);
      if (is_border && std::abs(k + 0.5 - x) < std::abs(best)) best = k + 0.5 - x;
    }
    errors.Add(best);
  }
}

TEST(ImageRendererTest, IdBuffersShowSurfacesWhereTheCameraModelPutsThem) {
  const StereoRig rig = EurocRig();
  for (std::size_t c = 0; c < 2; ++c) {
    const CameraRays camera(rig.cameras[c]);
    BorderErrors errors;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const SheetScene scene(seed);
      const cv::Mat1i ids = scene.renderer->RenderIds(camera, rig.T_BC[c]);
      const SE3 T_CB = rig.T_BC[c].Inverse();
      for (const double side : {-1.0, 1.0}) {
        std::vector<Vector3d> upright, level;
        for (int i = 0; i <= 4000; ++i) {
          const double s = i / 2000.0 - 1;
          upright.push_back(T_CB * scene.PointAt(side, s));
          level.push_back(T_CB * scene.PointAt(s, side));
        }
        CompareEdge(ids, rig.cameras[c], upright, errors);
        CompareEdge(ids, rig.cameras[c], level, errors);
      }
    }
    ASSERT_GT(errors.count, 2000);
    const double bias_px = errors.sum / errors.count, beyond_px = errors.sum_beyond / errors.count;
    std::printf("camera %zu: %d borders, mean error %.4f px, beyond the pixel grid %.5f px\n",
                c,
                errors.count,
                bias_px,
                beyond_px);
    EXPECT_LT(std::abs(bias_px), 0.05);
    EXPECT_LT(beyond_px, 0.05);
  }
}

/// Where the image is half-way between both sides of an edge, against the true edge: mean distance
/// along rows (axis 0) or columns (axis 1).
double MeanEdgeShift(const cv::Mat1f& image,
                     const CameraModel& camera,
                     const std::vector<Vector3d>& edge_C,
                     int axis) {
  double sum = 0;
  int count = 0;
  const auto value = [&](int along, int across) {
    return axis == 0 ? image(across, along) : image(along, across);
  };
  for (std::size_t i = 1; i < edge_C.size(); ++i) {
    const auto a = camera.Project(edge_C[i - 1]), b = camera.Project(edge_C[i]);
    if (!a || !b || !camera.IsInside(*b, 8)) continue;
    const Vector2d step = *b - *a;
    const int line = static_cast<int>(std::floor(std::max((*a)(1 - axis), (*b)(1 - axis))));
    if (line <= std::min((*a)(1 - axis), (*b)(1 - axis))) continue;
    if (std::abs(step(1 - axis)) < 2 * std::abs(step(axis))) continue;
    const double truth = (*a)(axis) + (line - (*a)(1 - axis)) / step(1 - axis) * step(axis);
    const int center = static_cast<int>(truth);
    const float begin = value(center - 4, line), end = value(center + 5, line);
    if (std::abs(begin - end) < 0.5F) continue;  // a corner of the sheet is near
    const float half = 0.5F * (begin + end);
    for (int k = center - 3; k < center + 4; ++k) {
      const float before = value(k, line) - half, after = value(k + 1, line) - half;
      if (before * after > 0) continue;
      sum += k + static_cast<double>(before / (before - after)) - truth;
      ++count;
      break;
    }
  }
  return count > 100 ? sum / count : 0;
}

TEST(ImageRendererTest, EdgesInTheImagesLieWhereTheCameraModelPutsThem) {
  const StereoRig rig = EurocRig();
  for (std::size_t c = 0; c < 2; ++c) {
    const CameraRays camera(rig.cameras[c]);
    const SE3 T_CB = rig.T_BC[c].Inverse();
    for (const int num_rays : {3, 4, 8}) {
      // The shift of the whole image: opposite edges, so that the width of the blur cancels.
      Vector2d shift_px = Vector2d::Zero();
      constexpr int kScenes = 4;
      for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
        const SheetScene scene(seed);
        const std::vector<SE3> poses(static_cast<std::size_t>(num_rays), rig.T_BC[c]);
        const cv::Mat1f image = scene.renderer->Render(camera, poses, 0.5);
        for (const double side : {-1.0, 1.0}) {
          for (const bool is_first : {true, false}) {
            std::vector<Vector3d> edge_C;
            for (int i = 0; i <= 4000; ++i) {
              const double s = i / 2000.0 - 1;
              edge_C.push_back(T_CB * (is_first ? scene.PointAt(side, s) : scene.PointAt(s, side)));
            }
            for (int axis = 0; axis < 2; ++axis)
              shift_px(axis) += MeanEdgeShift(image, rig.cameras[c], edge_C, axis) / (2 * kScenes);
          }
        }
      }
      std::printf("camera %zu, %d rays: image shifted by %.4f %.4f px\n",
                  c,
                  num_rays,
                  shift_px.x(),
                  shift_px.y());
      EXPECT_LT(shift_px.norm(), 0.05) << num_rays << " rays, camera " << c;
    }
  }
}

TEST(ImageRendererTest, RaysBesidePixelCentresGoWhereTheCameraModelSays) {
  const StereoRig rig = EurocRig();
  for (const CameraModel& model : rig.cameras) {
    const CameraRays camera(model);
    double sum = 0, largest = 0;
    int count = 0;
    for (int y = 0; y < model.height(); y += 7) {
      for (int x = 0; x < model.width(); x += 7) {
        const Eigen::Vector2f offset(0.7F, -0.7F);
        const auto px = model.Project(camera.At(x, y, offset).cast<double>());
        ASSERT_TRUE(px);
        const double error = (*px - Vector2d(x, y) - offset.cast<double>()).norm();
        sum += error, largest = std::max(largest, error), ++count;
      }
    }
    EXPECT_LT(sum / count, 0.002);
    EXPECT_LT(largest, 0.02);
  }
}

// Backwards in time the same rays go: neither their places nor the levels of the texture that they
// see have a trend, which would displace a moving image along its motion.
TEST(PixelRaysTest, AreTheSameForwardsAndBackwardsInTime) {
  for (const int count : {1, 2, 3, 4, 8, 14, 15, 24, 28}) {
    const std::vector<PixelRay> rays = PixelRays(count, 0.5);
    ASSERT_EQ(rays.size(), static_cast<std::size_t>(count));
    double squares = 0, roundings = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const PixelRay& mirrored = rays[rays.size() - 1 - i];
      EXPECT_EQ(rays[i].offset_px, -mirrored.offset_px) << count;
      EXPECT_EQ(rays[i].level_rounding, mirrored.level_rounding) << count;
      squares += static_cast<double>(rays[i].offset_px.squaredNorm());
      roundings += static_cast<double>(rays[i].level_rounding);
    }
    EXPECT_NEAR(roundings / count, 0.5, 1e-6) << count;
    if (count >= 14) {
      EXPECT_NEAR(std::sqrt(squares / (2 * count)), 0.5, 0.1) << count;
    }
  }
}

TEST(ImageRendererTest, MotionDuringTheExposureBlursTheBorder) {
  const StereoRig rig = EurocRig();
  const CameraRays camera(rig.cameras[0]);
  const SheetScene scene(3);
  std::vector<SE3> still(8, rig.T_BC[0]), moving;
  for (int i = 0; i < 8; ++i)
    moving.push_back(rig.T_BC[0] * SE3(ExpSO3(Vector3d(0, 0.002 * i, 0)), Vector3d::Zero()));
  // Number of pixels that are neither sheet nor background.
  const auto count_mixed = [&](const std::vector<SE3>& poses) {
    const cv::Mat1f image = scene.renderer->Render(camera, poses, 0);
    const auto sky = static_cast<float>(scene.lighting.sky);
    return cv::countNonZero((image > sky * 1.2F) & (image < 3.0F));
  };
  EXPECT_GT(count_mixed(moving), 4 * count_mixed(still));
}

TEST(RayCastingTest, NearestSurfaceAndBlockingAgreeWithTheGeometry) {
  const SheetScene scene(5);
  const Vector3d p_W = scene.PointAt(0.2, -0.3);
  const Vector3d n_W = scene.T_BO.q * Vector3d::UnitZ();
  const auto nearest = scene.rays->FindNearest(p_W + 0.37 * n_W, 1);
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->distance_m, 0.37, 1e-5);
  EXPECT_FALSE(scene.rays->FindNearest(p_W + 0.37 * n_W, 0.3));
  EXPECT_TRUE(scene.rays->IsBlocked(p_W + n_W, p_W - n_W));
  EXPECT_FALSE(scene.rays->IsBlocked(p_W + n_W, p_W));
  const auto hit = scene.rays->Cast(p_W + n_W, -n_W);
  ASSERT_TRUE(hit);
  EXPECT_FALSE(hit->is_back_face);
}

TEST(CameraRaysTest, ALensMisfitMovesTheRays) {
  const CameraModel camera = EurocRig().cameras[0];
  const LensMisfit misfit = LensMisfit::Draw(camera, 0.13, 1);
  const CameraRays exact(camera), displaced(camera, misfit);
  for (const Vector2d& px : {Vector2d(20, 30), Vector2d(376, 240), Vector2d(730, 460)}) {
    const int x = static_cast<int>(px.x()), y = static_cast<int>(px.y());
    const Eigen::Vector3f ray_C = displaced.At(x, y, {0, 0});
    const auto arrives = camera.Project(ray_C.cast<double>());
    ASSERT_TRUE(arrives);
    EXPECT_LT((*arrives + misfit.At(*arrives) - px).norm(), 1e-3) << px.transpose();
    EXPECT_NE(exact.At(x, y, {0, 0}), ray_C);
  }
}

}  // namespace
}  // namespace facet
