// SPDX-License-Identifier: BSD-2-Clause
// What a camera sees, before the sensor turns it into grey levels.
#pragma once

#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "facet/geometry/se3.h"
#include "facet/render/camera_rays.h"
#include "facet/render/lighting.h"
#include "facet/render/materials.h"
#include "facet/render/pixel_rays.h"
#include "facet/render/ray_scene.h"

namespace facet {

/// Thread-safe (immutable): one image per call, any number of calls at a time.
class ImageRenderer {
 public:
  /// Keeps references to all of them. The mesh has its light. Without highlights every surface
  /// looks the same from all sides.
  ImageRenderer(const SceneMesh& mesh,
                const MaterialLibrary& materials,
                const RayScene& rays,
                const Lighting& lighting,
                bool with_highlights = true);

  /// Radiance of each pixel: the mean over one ray for each pose of the camera during the exposure.
  /// The rays of a pixel are spread like a lens' point spread function of `blur_px` (1-sigma).
  cv::Mat1f Render(const CameraRays& camera, std::span<const SE3> T_WC, double blur_px) const;

  /// Mean radiance of a grid of pixels `step_px` apart, for the exposure.
  double MeanRadiance(const CameraRays& camera, const SE3& T_WC, int step_px) const;

  /// What the ray through the centre of each pixel hits: index of the triangle or -1.
  cv::Mat1i RenderIds(const CameraRays& camera, const SE3& T_WC) const;

 private:
  /// All that shading a matt triangle needs, in one cache line: values at the first corner and
  /// their differences at the other two.
  struct alignas(64) TriangleLook {
    const Material* material = nullptr;
    float u = 0, u_1 = 0, u_2 = 0;
    float v = 0, v_1 = 0, v_2 = 0;
    float light = 0, light_1 = 0, light_2 = 0;
    float n_W[3] = {0, 0, 1};
    float texels_per_m = 1;
    std::int32_t grid = -1;  ///< the part whose light grid counts; -1: the light above
  };
  static_assert(sizeof(TriangleLook) == 64);
  struct View {
    Eigen::Matrix3f R_WC;
    Eigen::Vector3f p_WC;
  };
  void AddRay(const CameraRays& camera,
              const View& view,
              const PixelRay& ray,
              cv::Mat1f& sum) const;
  void Fill(const CameraRays& camera,
            const View& view,
            const Eigen::Vector2f& offset_px,
            int x,
            int y,
            int step_px,
            RayPacket& packet) const;
  float Shade(const RayPacket& packet, int lane, float pixel_angle, float level_rounding) const;
  float Gloss(const RayPacket& packet, int lane, float gloss) const;
  float Mirror(const Eigen::Vector3f& p_W,
               const Eigen::Vector3f& n_W,
               const Eigen::Vector3f& direction_W) const;

  const SceneMesh& mesh_;
  const RayScene& rays_;
  const Lighting& lighting_;
  bool with_highlights_;
  std::vector<TriangleLook> looks_;
};

}  // namespace facet
