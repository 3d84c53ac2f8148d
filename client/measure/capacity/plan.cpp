// How many scenes a device has room for, and how many devices a workload needs.

#include "client/measure/capacity/plan.hpp"

#include <algorithm>
#include <cmath>

namespace collided::cli {

namespace {

constexpr double kUsableShare = 0.9;
/// A scene more where rounding alone leaves it out, as for 0.7 / 0.07.
constexpr double kRoundingTolerance = 1e-9;

Resource resource(const char* name, const Workload& workload, double available, double per_scene) {
  const double fit = std::floor(available / per_scene * (1 + kRoundingTolerance));
  const auto scenes = static_cast<uint64_t>(std::min(fit, double{UINT32_MAX}));
  if (scenes == 0) return {name, 0, {}};
  return {name, scenes, (workload.scenes + scenes - 1) / scenes};
}

}  // namespace

const Resource& Plan::binding() const {
  return *std::min_element(resources.begin(), resources.end(), [](const Resource& a, const Resource& b) {
    return a.scenes_per_device < b.scenes_per_device;
  });
}

uint64_t usable_bytes(double device_bytes) { return static_cast<uint64_t>(kUsableShare * device_bytes); }

Traffic traffic_of(const Workload& workload, const SceneCost& scene) {
  if (!workload.rate || !workload.has_network()) return {};
  const auto gigabits = [&](double bytes) { return bytes * *workload.rate * 8e-9; };
  Traffic traffic{.in = gigabits(static_cast<double>(scene.frame_bytes)), .out = {}};
  if (scene.bytes_out) traffic.out = gigabits(*scene.bytes_out);
  return traffic;
}

Plan plan_of(const Workload& workload, const SceneCost& scene, uint64_t usable_bytes) {
  Plan plan;
  const auto memory = static_cast<double>(std::max<uint64_t>(scene.memory_bytes, 1));
  plan.resources.push_back(resource("memory", workload, static_cast<double>(usable_bytes), memory));
  if (workload.rate && scene.step_ms)
    plan.resources.push_back(resource("time", workload, workload.utilisation * 1e3, *workload.rate * *scene.step_ms));
  const Traffic traffic = traffic_of(workload, scene);
  const double busier_way = std::max(traffic.in.value_or(0), traffic.out.value_or(0));
  if (workload.network_gigabits && busier_way > 0)
    plan.resources.push_back(
        resource("network", workload, workload.utilisation * *workload.network_gigabits, busier_way));
  return plan;
}

}  // namespace collided::cli
