// Triangles, balls and tubes that rays meet: a scene of Embree.

#include "client/cli/picture/ray_scene.hpp"

#include <limits>
#include <stdexcept>
#include <string>

namespace collided::cli {

namespace {

using scenes::Vec3d;

RTCRay ray_of(const Vec3d& origin, const Vec3d& direction, double distance) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin[0]);
  ray.org_y = static_cast<float>(origin[1]);
  ray.org_z = static_cast<float>(origin[2]);
  ray.dir_x = static_cast<float>(direction[0]);
  ray.dir_y = static_cast<float>(direction[1]);
  ray.dir_z = static_cast<float>(direction[2]);
  ray.tfar = static_cast<float>(distance);
  ray.mask = ~0u;
  return ray;
}

template <class T>
T* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t bytes, size_t count) {
  void* const buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, bytes, count);
  if (buffer == nullptr) throw std::runtime_error("no memory for a picture of this scene");
  return static_cast<T*>(buffer);
}

float* new_points(RTCGeometry geometry, size_t count) {
  return new_buffer<float>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 4 * sizeof(float), count);
}

/// Returns where the next one goes.
float* put_point(float* at, const Vec3d& position, double radius) {
  for (const double x : position) *at++ = static_cast<float>(x);
  *at++ = static_cast<float>(radius);
  return at;
}

}  // namespace

RayScene::RayScene() : device_(rtcNewDevice("set_affinity=0")), scene_(rtcNewScene(device_)) {
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
}

RayScene::~RayScene() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void RayScene::check() const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error != RTC_ERROR_NONE)
    throw std::runtime_error("Embree cannot draw this scene, error " + std::to_string(error));
}

void RayScene::attach(RTCGeometry geometry, uint32_t part) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_, geometry, part);
  rtcReleaseGeometry(geometry);
  check();
}

void RayScene::add_triangles(uint32_t part, std::span<const Vec3d> positions,
                             std::span<const std::array<uint32_t, 3>> triangles) {
  if (triangles.empty()) return;
  const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* corner =
      new_buffer<float>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), positions.size());
  for (const Vec3d& position : positions)
    for (const double x : position) *corner++ = static_cast<float>(x);
  auto* index =
      new_buffer<uint32_t>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), triangles.size());
  for (const auto& triangle : triangles)
    for (const uint32_t vertex : triangle) *index++ = vertex;
  attach(geometry, part);
}

void RayScene::add_balls(uint32_t part, std::span<const Vec3d> centres, double radius) {
  if (centres.empty()) return;
  const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  float* next = new_points(geometry, centres.size());
  for (const Vec3d& centre : centres) next = put_point(next, centre, radius);
  attach(geometry, part);
}

void RayScene::add_tubes(uint32_t part, std::span<const Tube> tubes, double radius) {
  if (tubes.empty()) return;
  const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
  float* next = new_points(geometry, 2 * tubes.size());
  auto* index = new_buffer<uint32_t>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, sizeof(uint32_t), tubes.size());
  uint32_t first = 0;
  for (const Tube& tube : tubes) {
    next = put_point(put_point(next, tube.a, radius), tube.b, radius);
    *index++ = first;
    first += 2;
  }
  attach(geometry, part);
}

void RayScene::commit() {
  rtcCommitScene(scene_);
  check();
}

std::optional<RayHit> RayScene::first_hit(const Vec3d& origin, const Vec3d& direction) const {
  RTCRayHit query{ray_of(origin, direction, std::numeric_limits<double>::infinity()), {}};
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  find_hit(scene_, query);
  const RTCHit& hit = query.hit;
  if (hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  Vec3d normal{hit.Ng_x, hit.Ng_y, hit.Ng_z};
  normal = scenes::length(normal) > 0 ? scenes::unit(normal) : direction;
  if (scenes::dot(normal, direction) > 0) normal = scenes::times(normal, -1);
  return RayHit{query.ray.tfar, normal, hit.geomID, hit.primID, hit.u, hit.v};
}

bool RayScene::is_blocked(const Vec3d& origin, const Vec3d& direction, double distance) const {
  RTCRay ray = ray_of(origin, direction, distance);
  find_any(scene_, ray);
  return ray.tfar < 0;
}

}  // namespace collided::cli
