// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/ray_scene.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

#include <embree3/rtcore.h>

#include "facet/base/check.h"
#include "facet/geometry/triangle.h"

namespace facet {

struct RayScene::Device {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Device() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

namespace {

constexpr float kEndGap = 1e-3F;  // metres

struct NearestQuery {
  const SceneMesh* mesh = nullptr;
  Vector3d p_W;
  RayScene::Nearest best;
};

bool UpdateNearest(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<NearestQuery*>(arguments->userPtr);
  const std::size_t t = arguments->primID;
  const Vector3d nearest = ClosestOnTriangle(query.p_W,
                                             query.mesh->corner(t, 0).cast<double>(),
                                             query.mesh->corner(t, 1).cast<double>(),
                                             query.mesh->corner(t, 2).cast<double>());
  const double distance = (nearest - query.p_W).norm();
  if (distance >= query.best.distance_m) return false;
  query.best = {distance, arguments->primID};
  arguments->query->radius = static_cast<float>(distance);
  return true;
}

RTCRay MakeRay(const Vector3d& origin_W, const Vector3d& direction_W, float near, float far) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin_W.x());
  ray.org_y = static_cast<float>(origin_W.y());
  ray.org_z = static_cast<float>(origin_W.z());
  ray.dir_x = static_cast<float>(direction_W.x());
  ray.dir_y = static_cast<float>(direction_W.y());
  ray.dir_z = static_cast<float>(direction_W.z());
  ray.tnear = near;
  ray.tfar = far;
  ray.mask = ~0U;
  return ray;
}

}  // namespace

RayScene::RayScene(const SceneMesh& mesh) : device_(std::make_unique<Device>()), mesh_(mesh) {
  FACET_CHECK(!mesh.triangles.empty()) << "a scene without surfaces";
  // One thread: the tree, and with it the order of equal hits, must not depend on the machine.
  device_->device = rtcNewDevice("threads=1");
  if (!device_->device) throw std::runtime_error("Embree could not be started");
  device_->scene = rtcNewScene(device_->device);
  rtcSetSceneFlags(device_->scene, RTC_SCENE_FLAG_NONE);
  rtcSetSceneBuildQuality(device_->scene, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(device_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* corners = static_cast<float*>(rtcSetNewGeometryBuffer(geometry,
                                                              RTC_BUFFER_TYPE_VERTEX,
                                                              0,
                                                              RTC_FORMAT_FLOAT3,
                                                              3 * sizeof(float),
                                                              mesh.vertices.size()));
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(geometry,
                                                                      RTC_BUFFER_TYPE_INDEX,
                                                                      0,
                                                                      RTC_FORMAT_UINT3,
                                                                      3 * sizeof(std::uint32_t),
                                                                      mesh.triangles.size()));
  if (!corners || !indices) throw std::runtime_error("not enough memory for the scene");
  for (const SceneVertex& v : mesh.vertices)
    corners = std::copy_n(v.p_W.data(), 3, corners);
  for (const SceneTriangle& t : mesh.triangles)
    indices = std::copy(t.vertices.begin(), t.vertices.end(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(device_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(device_->scene);
  if (rtcGetDeviceError(device_->device) != RTC_ERROR_NONE) {
    throw std::runtime_error("Embree could not build the scene");
  }
}

RayScene::~RayScene() = default;

void RayScene::Intersect(RayPacket& packet) const {
  constexpr int kSize = RayPacket::kSize;
  alignas(64) RTCRayHit16 rays;
  alignas(64) int valid[kSize];
  std::memcpy(rays.ray.org_x, packet.origin[0], sizeof(packet.origin[0]));
  std::memcpy(rays.ray.org_y, packet.origin[1], sizeof(packet.origin[1]));
  std::memcpy(rays.ray.org_z, packet.origin[2], sizeof(packet.origin[2]));
  std::memcpy(rays.ray.dir_x, packet.direction[0], sizeof(packet.direction[0]));
  std::memcpy(rays.ray.dir_y, packet.direction[1], sizeof(packet.direction[1]));
  std::memcpy(rays.ray.dir_z, packet.direction[2], sizeof(packet.direction[2]));
  for (int i = 0; i < kSize; ++i) {
    valid[i] = -1;
    rays.ray.tnear[i] = 0;
    rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
    rays.ray.time[i] = 0;
    rays.ray.mask[i] = ~0U;
    rays.ray.flags[i] = 0;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, device_->scene, &context, &rays);
  static_assert(RayPacket::kMiss == RTC_INVALID_GEOMETRY_ID);
  std::memcpy(packet.triangle, rays.hit.primID, sizeof(packet.triangle));
  std::memcpy(packet.distance, rays.ray.tfar, sizeof(packet.distance));
  std::memcpy(packet.weight_1, rays.hit.u, sizeof(packet.weight_1));
  std::memcpy(packet.weight_2, rays.hit.v, sizeof(packet.weight_2));
}

std::optional<SceneHit> RayScene::Cast(const Vector3d& origin_W,
                                       const Vector3d& direction_W) const {
  RTCRayHit ray{};
  ray.ray = MakeRay(origin_W, direction_W, 0, std::numeric_limits<float>::infinity());
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(device_->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Vector3d n(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z);
  return SceneHit{ray.hit.primID, ray.ray.tfar, ray.hit.u, ray.hit.v, n.dot(direction_W) > 0};
}

bool RayScene::IsBlocked(const Vector3d& from_W, const Vector3d& to_W) const {
  const double length = (to_W - from_W).norm();
  if (length <= 2 * kEndGap) return false;
  RTCRay ray =
      MakeRay(from_W, (to_W - from_W) / length, kEndGap, static_cast<float>(length) - kEndGap);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(device_->scene, &context, &ray);
  return ray.tfar < 0;
}

bool RayScene::IsBlocked(const Vector3d& origin_W,
                         const Vector3d& direction_W,
                         double length) const {
  RTCRay ray = MakeRay(origin_W, direction_W, kEndGap, static_cast<float>(length));
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(device_->scene, &context, &ray);
  return ray.tfar < 0;
}

std::optional<RayScene::Nearest> RayScene::FindNearest(const Vector3d& p_W, double radius_m) const {
  RTCPointQuery point{};
  point.x = static_cast<float>(p_W.x());
  point.y = static_cast<float>(p_W.y());
  point.z = static_cast<float>(p_W.z());
  point.radius = static_cast<float>(radius_m);
  NearestQuery query{&mesh_, p_W, {radius_m, RayPacket::kMiss}};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(device_->scene, &point, &context, UpdateNearest, &query);
  if (query.best.triangle == RayPacket::kMiss) return std::nullopt;
  return query.best;
}

}  // namespace facet
