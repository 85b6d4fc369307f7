// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/image_renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace facet {
namespace {

/// Turns the pattern of the rays by another angle in each pixel of a tile. With the same pattern
/// everywhere all pixels along an upright edge would err in the same direction.
class PatternTurns {
 public:
  PatternTurns() {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const double share = std::fmod(0.7548776662 * x + 0.5698402910 * y, 1.0);
        turns_[y][x] = Eigen::Rotation2Df(static_cast<float>(std::numbers::pi * share)).matrix();
      }
    }
  }
  Eigen::Vector2f Turn(int x, int y, const Eigen::Vector2f& offset_px) const {
    return turns_[y % kSide][x % kSide] * offset_px;
  }

 private:
  static constexpr int kSide = 16;
  Eigen::Matrix2f turns_[kSide][kSide];
};

/// Logarithm to base 2 of x >= 1, to 0.01.
float Log2(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const float exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  const float mantissa = std::bit_cast<float>((bits & 0x007FFFFFU) | 0x3F800000U);
  return exponent + (-0.344845F * mantissa + 2.024658F) * mantissa - 1.674873F;
}

float TexelsPerMetre(const SceneMesh& mesh, std::size_t triangle, const Texture& texture) {
  const auto& v = mesh.triangles[triangle].vertices;
  const Eigen::Vector2f a = mesh.vertices[v[0]].uv, b = mesh.vertices[v[1]].uv,
                        c = mesh.vertices[v[2]].uv;
  const Eigen::Vector2f ab = b - a, ac = c - a;
  const double uv_area = 0.5 * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
  const double texels = uv_area * texture.width() * texture.height();
  return static_cast<float>(std::sqrt(texels / std::max(1e-12, mesh.TriangleArea(triangle))));
}

}  // namespace

ImageRenderer::ImageRenderer(const SceneMesh& mesh,
                             const MaterialLibrary& materials,
                             const RayScene& rays,
                             const Lighting& lighting,
                             bool with_highlights)
    : mesh_(mesh),
      rays_(rays),
      lighting_(lighting),
      with_highlights_(with_highlights),
      looks_(mesh.triangles.size()) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const SceneTriangle& triangle = mesh.triangles[i];
    const SceneVertex &a = mesh.vertices[triangle.vertices[0]],
                      &b = mesh.vertices[triangle.vertices[1]],
                      &c = mesh.vertices[triangle.vertices[2]];
    const auto material = static_cast<std::size_t>(mesh.parts[triangle.part].material);
    TriangleLook& look = looks_[i];
    look.material = &materials.materials()[material];
    look.u = a.uv.x(), look.u_1 = b.uv.x() - a.uv.x(), look.u_2 = c.uv.x() - a.uv.x();
    look.v = a.uv.y(), look.v_1 = b.uv.y() - a.uv.y(), look.v_2 = c.uv.y() - a.uv.y();
    look.light = a.light, look.light_1 = b.light - a.light, look.light_2 = c.light - a.light;
    const Eigen::Vector3f n_W = (b.p_W - a.p_W).cross(c.p_W - a.p_W).normalized();
    std::copy_n(n_W.data(), 3, look.n_W);
    look.texels_per_m = TexelsPerMetre(mesh, i, look.material->texture);
    if (mesh.parts[triangle.part].is_planar) look.grid = static_cast<int>(triangle.part);
  }
}

void ImageRenderer::Fill(const CameraRays& camera,
                         const View& view,
                         const Eigen::Vector2f& offset_px,
                         int x,
                         int y,
                         int step_px,
                         RayPacket& packet) const {
  static const PatternTurns turns;
  for (int lane = 0; lane < RayPacket::kSize; ++lane) {
    const int column = std::min(x + lane * step_px, camera.width() - 1);
    const Eigen::Vector3f ray_C = camera.At(column, y, turns.Turn(column, y, offset_px));
    for (int k = 0; k < 3; ++k) {
      packet.origin[k][lane] = view.p_WC(k);
      packet.direction[k][lane] = view.R_WC.row(k).dot(ray_C);
    }
  }
  rays_.Intersect(packet);
}

float ImageRenderer::Mirror(const Eigen::Vector3f& p_W,
                            const Eigen::Vector3f& n_W,
                            const Eigen::Vector3f& direction_W) const {
  const Eigen::Vector3f mirrored = direction_W - 2 * n_W.dot(direction_W) * n_W;
  float sum = 0;
  for (const Light& light : lighting_.lights) {
    const Eigen::Vector3f to_light = light.p_W.cast<float>() - p_W;
    const float along = mirrored.dot(to_light), distance_2 = to_light.squaredNorm();
    if (along <= 0 || along * along < 0.7F * distance_2) continue;  // dark: 0.7^16
    float lobe = along * along / distance_2;
    for (int i = 0; i < 4; ++i)  // the cosine to the power of 32
      lobe *= lobe;
    sum += lobe * static_cast<float>(Falloff(light, std::sqrt(distance_2)));
  }
  return sum;
}

float ImageRenderer::Gloss(const RayPacket& packet, int lane, float gloss) const {
  const SceneTriangle& triangle = mesh_.triangles[packet.triangle[lane]];
  const float w1 = packet.weight_1[lane], w2 = packet.weight_2[lane];
  const Eigen::Vector3f n_W = ((1 - w1 - w2) * mesh_.vertices[triangle.vertices[0]].n_W +
                               w1 * mesh_.vertices[triangle.vertices[1]].n_W +
                               w2 * mesh_.vertices[triangle.vertices[2]].n_W)
                                  .normalized();
  const Eigen::Vector3f origin(
      packet.origin[0][lane], packet.origin[1][lane], packet.origin[2][lane]);
  const Eigen::Vector3f direction(
      packet.direction[0][lane], packet.direction[1][lane], packet.direction[2][lane]);
  return gloss * Mirror(origin + packet.distance[lane] * direction, n_W, direction.normalized());
}

float ImageRenderer::Shade(const RayPacket& packet,
                           int lane,
                           float pixel_angle,
                           float level_rounding) const {
  const std::uint32_t id = packet.triangle[lane];
  if (id == RayPacket::kMiss) return static_cast<float>(lighting_.sky);
  const TriangleLook& look = looks_[id];
  const Material& material = *look.material;
  const float w1 = packet.weight_1[lane], w2 = packet.weight_2[lane];
  const float dx = packet.direction[0][lane], dy = packet.direction[1][lane],
              dz = packet.direction[2][lane];
  const float length_2 = dx * dx + dy * dy + dz * dz;
  const float along = std::abs(dx * look.n_W[0] + dy * look.n_W[1] + dz * look.n_W[2]);
  // Squared width of a pixel on the surface, of which the two directions differ by the cosine:
  // their geometric mean.
  const float cosine = std::max(0.05F, along / std::sqrt(length_2));
  const float texels = packet.distance[lane] * pixel_angle * look.texels_per_m;
  const float texels_2 = 0.64F * texels * texels * length_2 / cosine;
  const int level = static_cast<int>(0.5F * Log2(texels_2 + 1) + level_rounding);
  const float u = look.u + w1 * look.u_1 + w2 * look.u_2;
  const float v = look.v + w1 * look.v_1 + w2 * look.v_2;
  const float light = look.grid >= 0
                          ? mesh_.parts[static_cast<std::size_t>(look.grid)].light.At(u, v)
                          : look.light + w1 * look.light_1 + w2 * look.light_2;
  float radiance = material.texture.Sample(u, v, level) * light;
  if (material.gloss > 0 && with_highlights_)
    radiance += Gloss(packet, lane, static_cast<float>(material.gloss));
  if (material.glow > 0) radiance += static_cast<float>(material.glow);
  return radiance;
}

void ImageRenderer::AddRay(const CameraRays& camera,
                           const View& view,
                           const PixelRay& ray,
                           cv::Mat1f& sum) const {
  RayPacket packet;
  for (int y = 0; y < camera.height(); ++y) {
    float* row = sum[y];
    for (int x = 0; x < camera.width(); x += RayPacket::kSize) {
      Fill(camera, view, ray.offset_px, x, y, 1, packet);
      const int count = std::min(RayPacket::kSize, camera.width() - x);
      for (int lane = 0; lane < count; ++lane) {
        if (camera.IsValid(x + lane, y)) {
          row[x + lane] += Shade(packet, lane, camera.pixel_angle(), ray.level_rounding);
        }
      }
    }
  }
}

cv::Mat1f ImageRenderer::Render(const CameraRays& camera,
                                std::span<const SE3> T_WC,
                                double blur_px) const {
  cv::Mat1f sum(camera.height(), camera.width(), 0.0F);
  const int count = static_cast<int>(T_WC.size());
  const std::vector<PixelRay> rays = PixelRays(count, blur_px);
  for (std::size_t i = 0; i < T_WC.size(); ++i) {
    const View view{T_WC[i].R().cast<float>(), T_WC[i].p.cast<float>()};
    AddRay(camera, view, rays[i], sum);
  }
  sum *= 1.0 / count;
  return sum;
}

double ImageRenderer::MeanRadiance(const CameraRays& camera, const SE3& T_WC, int step_px) const {
  const View view{T_WC.R().cast<float>(), T_WC.p.cast<float>()};
  const Eigen::Vector2f center(0, 0);
  RayPacket packet;
  double sum = 0;
  int count = 0;
  for (int y = step_px / 2; y < camera.height(); y += step_px) {
    for (int x = step_px / 2; x < camera.width(); x += RayPacket::kSize * step_px) {
      Fill(camera, view, center, x, y, step_px, packet);
      for (int lane = 0; lane < RayPacket::kSize; ++lane) {
        const int column = x + lane * step_px;
        if (column >= camera.width() || !camera.IsValid(column, y)) continue;
        // Lamps and mirrors count no more than white paper.
        sum += std::min(1.5F, Shade(packet, lane, camera.pixel_angle(), 0.5F)) *
               camera.Vignette(column, y);
        ++count;
      }
    }
  }
  return count > 0 ? sum / count : 0;
}

cv::Mat1i ImageRenderer::RenderIds(const CameraRays& camera, const SE3& T_WC) const {
  const View view{T_WC.R().cast<float>(), T_WC.p.cast<float>()};
  cv::Mat1i ids(camera.height(), camera.width(), -1);
  RayPacket packet;
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); x += RayPacket::kSize) {
      Fill(camera, view, {0, 0}, x, y, 1, packet);
      for (int lane = 0; lane < std::min(RayPacket::kSize, camera.width() - x); ++lane) {
        if (packet.triangle[lane] != RayPacket::kMiss && camera.IsValid(x + lane, y)) {
          ids(y, x + lane) = static_cast<int>(packet.triangle[lane]);
        }
      }
    }
  }
  return ids;
}

}  // namespace facet
