#include "tests/bench/embree/embree_collider.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace collided::test {
namespace {

// A native thread-local slot for each thread: the look-up must not affect the measurement.
using Counters =
    tbb::enumerable_thread_specific<uint64_t, tbb::cache_aligned_allocator<uint64_t>, tbb::ets_key_per_instance>;

struct Count {
  std::span<const FloatBox> boxes;
  const std::function<bool(uint32_t, uint32_t)>* filter = nullptr;
  Counters counters = Counters(uint64_t{0});

  void add(const RTCCollision* pairs, unsigned count) {
    uint64_t found = 0;
    for (unsigned i = 0; i < count; ++i) {
      const uint32_t a = pairs[i].primID0, b = pairs[i].primID1;
      if (a < b && overlap(boxes[a], boxes[b]) && (filter == nullptr || (*filter)(a, b))) ++found;
    }
    counters.local() += found;
  }
};

void bounds_of(const RTCBoundsFunctionArguments* call) {
  const FloatBox& box = static_cast<const FloatBox*>(call->geometryUserPtr)[call->primID];
  RTCBounds& out = *call->bounds_o;
  out.lower_x = box.lo[0], out.lower_y = box.lo[1], out.lower_z = box.lo[2];
  out.upper_x = box.hi[0], out.upper_y = box.hi[1], out.upper_z = box.hi[2];
}

uint64_t run(RTCScene scene, Count& count) {
  rtcCollide(
      scene, scene,
      [](void* count, RTCCollision* pairs, unsigned number) { static_cast<Count*>(count)->add(pairs, number); },
      &count);
  return count.counters.combine([](uint64_t a, uint64_t b) { return a + b; });
}

}  // namespace

EmbreeCollider::EmbreeCollider(std::span<const FloatBox> boxes, RTCBuildQuality quality, int threads)
    : boxes_(boxes),
      device_(rtcNewDevice(("threads=" + std::to_string(threads) + ",set_affinity=0").c_str())),
      scene_(rtcNewScene(device_)),
      geometry_(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER)) {
  rtcSetSceneBuildQuality(scene_, quality);
  rtcSetGeometryBuildQuality(geometry_, quality);
  rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(boxes.size()));
  rtcSetGeometryUserData(geometry_, const_cast<FloatBox*>(boxes.data()));  // Embree knows no pointer to const
  rtcSetGeometryBoundsFunction(geometry_, bounds_of, nullptr);
  rtcCommitGeometry(geometry_);
  rtcAttachGeometry(scene_, geometry_);
  check("scene");
}

EmbreeCollider::~EmbreeCollider() {
  rtcReleaseGeometry(geometry_);
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void EmbreeCollider::build() {
  rtcCommitGeometry(geometry_);  // marks it as changed: otherwise Embree would keep its hierarchy
  rtcCommitScene(scene_);
  check("build");
}

uint64_t EmbreeCollider::collide() {
  Count count{boxes_};
  return run(scene_, count);
}

uint64_t EmbreeCollider::collide(const std::function<bool(uint32_t, uint32_t)>& filter) {
  Count count{boxes_, &filter};
  return run(scene_, count);
}

void EmbreeCollider::check(const char* what) const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error != RTC_ERROR_NONE)
    throw std::runtime_error(std::string("Embree, ") + what + ": error " + std::to_string(error));
}

}  // namespace collided::test
