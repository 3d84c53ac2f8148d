// What a workload needs, as JSON and in sentences.

#include "client/measure/capacity/report.hpp"

#include <algorithm>

#include "client/app/report/numbers.hpp"

namespace collided::cli {

namespace {

Json workload_json(const Capacity& capacity) {
  const Workload& workload = capacity.workload;
  Json out = {{"scenes", workload.scenes}};
  if (workload.rate) {
    out["rate"] = *workload.rate;
    out["frames_per_second"] = *workload.rate * workload.scenes;
  }
  if (capacity.scene.step_ms) out["step_ms"] = *capacity.scene.step_ms;
  out["transport"] = workload.transport;
  out["utilisation"] = workload.utilisation;
  return out;
}

Json measured_json(const Measured& measured) {
  return {{"steps", measured.steps},
          {"engine_ms", measured.engine_ms},
          {"contacts_per_frame", measured.contacts},
          {"device_bytes", measured.device_bytes}};
}

/// Of a frame, and of all scenes.
Json network_json(const Capacity& capacity) {
  const double scenes = capacity.workload.scenes;
  Json out = {{"bytes_in", capacity.scene.frame_bytes}};
  if (capacity.scene.bytes_out) out["bytes_out"] = static_cast<uint64_t>(*capacity.scene.bytes_out + 0.5);
  const Traffic traffic = traffic_of(capacity.workload, capacity.scene);
  if (traffic.in) out["gigabits_in_per_second"] = scenes * *traffic.in;
  if (traffic.out) out["gigabits_out_per_second"] = scenes * *traffic.out;
  return out;
}

bool is_known(const Plan& plan, const char* name) {
  return std::any_of(plan.resources.begin(), plan.resources.end(), [&](const Resource& r) { return r.name == name; });
}

bool is_cuda(const Capacity& capacity) { return capacity.estimate.spec().backend() == v1::BACKEND_CUDA; }

/// "GPUs" or, where a device is the cores of a host, "hosts".
std::string devices_text(const Capacity& capacity, uint64_t count) {
  const bool is_gpu = is_cuda(capacity) || capacity.workload.device_gigabytes;
  return count_text(count) + (is_gpu ? " GPU" : " host") + (count == 1 ? "" : "s");
}

std::string time_assumption(const Capacity& capacity) {
  const Workload& workload = capacity.workload;
  if (!is_known(capacity.plan, "time"))
    return "time is left out: it takes --rate, and --measure or --step-ms for what a frame takes";
  const std::string share = format_double("%.3g", 100 * workload.utilisation) + " %";
  std::string text = "a device works " + share + " of the time, on one frame after the other";
  if (workload.utilisation < 1) {
    // Pollaczek and Khinchine's formula for service times that do not vary.
    const double wait = workload.utilisation / (2 * (1 - workload.utilisation));
    text += "; frames that come at random then wait " + format_double("%.2g", wait) + " times as long as one takes";
  }
  return text;
}

std::string network_assumption(const Capacity& capacity) {
  const Workload& workload = capacity.workload;
  if (!workload.has_network()) return "frames over " + workload.transport + " take no network";
  std::string text = is_known(capacity.plan, "network") ? "network: positions and contacts alone, without headers"
                                                        : "network is left out: it takes --rate and --network";
  if (!capacity.scene.bytes_out) text += "; contacts are left out: they take --measure or --contacts";
  return text;
}

std::string memory_assumption(const Capacity& capacity) {
  std::string text = "scenes may hold " + bytes_text(static_cast<double>(capacity.usable_bytes)) + " of a device; ";
  text += capacity.measured
              ? "a scene holds the most of this estimate and of the measured frames"
              : "a scene may hold more than this estimate, by the candidates and contacts that its frames find";
  if (capacity.workload.device_gigabytes && !is_cuda(capacity))
    text += "; what it holds was told for CPU cores, not for a GPU";
  return text;
}

/// A limit of the daemon, and how much of it is needed.
struct Limit {
  std::string option;
  double limit, need;

  std::string text(double value) const {
    return option.find("-mb") == std::string::npos ? count_text(static_cast<uint64_t>(value)) : bytes_text(value);
  }
};

}  // namespace

void add_capacity(Json& out, const Capacity& capacity) {
  const v1::EstimateSceneResponse& estimate = capacity.estimate;
  if (estimate.triangle_count() > 0)
    out["bytes_per_triangle"] =
        static_cast<double>(capacity.scene.memory_bytes) / static_cast<double>(estimate.triangle_count());
  if (capacity.measured) out["measured"] = measured_json(*capacity.measured);
  out["workload"] = workload_json(capacity);
  out["network"] = network_json(capacity);
  out["usable_bytes"] = capacity.usable_bytes;
  for (const Resource& resource : capacity.plan.resources) {
    out["scenes_per_device"][resource.name] = resource.scenes_per_device;
    out["devices_needed"][resource.name] = resource.devices ? Json(*resource.devices) : Json(nullptr);
  }
  const Resource& binding = capacity.plan.binding();
  out["device_count"] = binding.devices ? Json(*binding.devices) : Json(nullptr);
  out["bound_by"] = binding.name;
}

std::string verdict(const Capacity& capacity) {
  const Resource& binding = capacity.plan.binding();
  if (!binding.devices) return "one scene alone needs more " + binding.name + " than a device has";
  const bool is_whole = is_known(capacity.plan, "time");
  return devices_text(capacity, *binding.devices) + (is_whole ? "" : " or more") + ", bound by " + binding.name + ": " +
         count_text(capacity.workload.scenes) + " scenes, at most " + count_text(binding.scenes_per_device) +
         " on each";
}

std::vector<std::string> assumptions(const Capacity& capacity) {
  return {memory_assumption(capacity), time_assumption(capacity), network_assumption(capacity)};
}

std::vector<std::string> limit_warnings(const Capacity& capacity) {
  const Resource& binding = capacity.plan.binding();
  const v1::ServerLimits& limits = capacity.limits;
  const auto bytes = static_cast<double>(capacity.scene.memory_bytes);
  const double scenes = std::min<double>(capacity.workload.scenes, static_cast<double>(binding.scenes_per_device));
  const Limit needs[] = {
      {"max-scene-mb", static_cast<double>(limits.max_scene_bytes()), bytes},
      {"max-scenes", static_cast<double>(limits.max_scenes()), scenes},
      {"max-scenes-per-client", static_cast<double>(limits.max_scenes_per_client()), scenes},
      {"max-streams", static_cast<double>(limits.max_streams()), scenes},
      {"max-streams-per-client", static_cast<double>(limits.max_streams_per_client()), scenes},
      {"max-device-mb", static_cast<double>(limits.max_device_bytes()), scenes * bytes},
      {"max-device-mb-per-client", static_cast<double>(limits.max_device_bytes_per_client()), scenes * bytes},
      {"max-frames-per-second", limits.max_frames_per_second(), scenes * capacity.workload.rate.value_or(0)},
  };
  std::vector<std::string> warnings;
  for (const Limit& each : needs)
    if (each.need > each.limit)
      warnings.push_back("the daemon's " + each.option + " allows " + each.text(each.limit) +
                         "; a device's scenes need " + each.text(each.need));
  return warnings;
}

}  // namespace collided::cli
