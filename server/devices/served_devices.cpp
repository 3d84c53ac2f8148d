// The devices that scenes can live on.
#include "server/devices/served_devices.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <map>
#include <stdexcept>
#include <thread>

#include "server/devices/chosen_devices.hpp"
#include "server/errors.hpp"
#include "server/ops/log.hpp"

namespace collided::server {
namespace {

uint64_t count_of(const std::vector<DeviceInfo>& devices, Backend backend) {
  return static_cast<uint64_t>(
      std::ranges::count_if(devices, [&](const DeviceInfo& info) { return info.device.backend == backend; }));
}

// On a GPU the host's part of one frame overlaps with the device's part of another; on CPU cores a second frame keeps
// all cores busy during the first one's serial parts. A step on a GPU cannot yield before its end: a client that held
// all turns would block the others for that long. The host's part is a thread's that waits awake, so that a quarter of
// the cores is left for the frames that come and go.
Turns::Options turn_options(const Config& config, Backend backend, uint64_t devices, const Now& now) {
  constexpr unsigned kLeastOnGpu = 4, kMostOnGpu = 12, kOnCpu = 2;
  const bool on_gpu = backend == Backend::kCuda;
  const unsigned of_one = std::thread::hardware_concurrency() / 4 * 3 / static_cast<unsigned>(devices);
  const unsigned by_default = on_gpu ? std::clamp(of_one, kLeastOnGpu, kMostOnGpu) : kOnCpu;
  const auto asked = static_cast<unsigned>(config.concurrent_frames);
  return {.concurrent = asked > 0 ? asked : by_default, .reserves_one = on_gpu, .now = now};
}

// Host work gets half of the cores, so that frames keep the other half however many clients ask for it. There are at
// least two turns, of which a client leaves one to others: checking a message cannot yield.
Turns::Options host_turn_options(const Now& now) {
  const unsigned half = std::thread::hardware_concurrency() / 2;
  return {.concurrent = std::clamp(half, 2u, 16u), .reserves_one = true, .now = now};
}

// A device that is the only one of its kind has all that scenes may hold.
uint64_t limit_of(const DeviceInfo& info, uint64_t devices, uint64_t of_all) {
  if (devices == 1) return of_all;
  return info.device.backend == Backend::kCpu ? of_all / devices : std::min(of_all, info.memory_bytes / 10 * 9);
}

// Returns why a device cannot be used; empty if it can.
std::string memory_obstacle(const Device& device) try {
  return device.backend == Backend::kCpu || free_device_memory(device) > 0 ? "" : "it has no free memory";
} catch (const std::runtime_error& error) {
  return error.what();
}

std::string kernels_obstacle(const Device& device) try {
  const auto start = std::chrono::steady_clock::now();
  load_kernels(device);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  log_event(spdlog::level::info, "kernels loaded", {{"device", to_string(device)}, {"seconds", took.count()}});
  return "";
} catch (const std::runtime_error& error) {
  return error.what();
}

// One after another: devices that are alike find the kernels of the first in the driver's cache.
std::vector<std::string> load_all_kernels(const std::vector<DeviceInfo>& devices) {
  std::vector<std::string> obstacles;
  for (const DeviceInfo& info : devices)
    obstacles.push_back(info.needs_compilation ? kernels_obstacle(info.device) : "");
  return obstacles;
}

// Where scenes are placed by free memory, which only a device that is ready for work tells. All at once, since that
// takes a while.
void ask_for_memory(const std::vector<DeviceInfo>& devices, std::vector<std::string>& obstacles) {
  if (count_of(devices, Backend::kCuda) < 2) return;
  std::vector<std::future<std::string>> answers;
  for (const DeviceInfo& info : devices)
    answers.push_back(std::async(std::launch::async, [device = info.device] { return memory_obstacle(device); }));
  for (size_t i = 0; i < devices.size(); ++i)
    if (std::string why = answers[i].get(); obstacles[i].empty()) obstacles[i] = std::move(why);
}

// Moves those that do not work from `devices` to what this returns.
std::vector<UnusableDevice> take_unusable(const Config& config, std::vector<DeviceInfo>& devices) {
  std::vector<std::string> obstacles = load_all_kernels(devices);
  ask_for_memory(devices, obstacles);
  std::vector<UnusableDevice> unusable = config.devices.empty() ? unusable_devices() : std::vector<UnusableDevice>();
  std::vector<DeviceInfo> working;
  for (size_t i = 0; i < devices.size(); ++i) {
    if (obstacles[i].empty())
      working.push_back(std::move(devices[i]));
    else if (!config.devices.empty())
      throw ConfigError("--device is " + to_string(devices[i].device) + ", which does not work: " + obstacles[i]);
    else
      unusable.push_back({devices[i].device, devices[i].name, "it does not work: " + obstacles[i]});
  }
  devices = std::move(working);
  return unusable;
}

void check_backend(const Config& config, const std::vector<DeviceInfo>& devices,
                   const std::vector<UnusableDevice>& unusable) {
  if (config.backend != "cuda" || count_of(devices, Backend::kCuda) > 0) return;
  std::string why;
  for (const UnusableDevice& each : unusable) why += (why.empty() ? "" : "; ") + to_string(each);
  throw std::runtime_error("--backend is cuda, but there is no usable CUDA device: " +
                           (why.empty() ? cuda_obstacle() : why));
}

// Of a scene's shards, which hold the same each.
std::map<Device, uint64_t> bytes_by_device(const DeviceWish& wish) {
  std::map<Device, uint64_t> bytes;
  for (const Device& device : wish.shards) bytes[device] += wish.min_bytes / wish.shards.size();
  return bytes;
}

auto& find_in(auto& served, const Device& device) {
  const auto found = std::ranges::find_if(served, [&](const auto& each) { return each.terms.info.device == device; });
  if (found == served.end()) throw std::logic_error(to_string(device) + " is not served");
  return *found;
}

}  // namespace

DevicesAtStart devices_at_start(const Config& config, const Now& now) {
  std::vector<DeviceInfo> devices = chosen_devices(config);
  std::vector<UnusableDevice> unusable = take_unusable(config, devices);
  check_backend(config, devices, unusable);
  std::vector<DeviceTerms> terms;
  for (const DeviceInfo& info : devices) {
    const Backend backend = info.device.backend;
    const uint64_t of_its_kind = count_of(devices, backend);
    terms.push_back({info, threads_of_scene(config, backend), turn_options(config, backend, of_its_kind, now),
                     limit_of(info, of_its_kind, config.limits.max_device_bytes)});
  }
  return {std::move(terms), std::move(unusable)};
}

ServedDevices::Served::Served(DeviceTerms given)
    : terms(std::move(given)),
      turns(terms.turns),
      bytes(std::make_shared<DeviceBytes>("device:" + to_string(terms.info.device),
                                          "max_device_bytes of " + to_string(terms.info.device), terms.max_bytes)) {}

ServedDevices::ServedDevices(std::vector<DeviceTerms> terms, const Now& now)
    : ServedDevices(DevicesAtStart{std::move(terms)}, now) {}

ServedDevices::ServedDevices(DevicesAtStart devices, const Now& now)
    : unusable_(std::move(devices.unusable)), host_turns_(host_turn_options(now)) {
  for (DeviceTerms& each : devices.terms) served_.emplace_back(std::move(each));
  has_several_gpus_ = count_of(infos(), Backend::kCuda) > 1;
}

std::vector<DeviceInfo> ServedDevices::infos() const {
  std::vector<DeviceInfo> infos;
  for (const Served& each : served_) infos.push_back(each.terms.info);
  return infos;
}

ServedDevices::Served& ServedDevices::served(const Device& device) { return find_in(served_, device); }
const ServedDevices::Served& ServedDevices::served(const Device& device) const { return find_in(served_, device); }

// Memory that scenes hold on the device is counted in both: what is left of the limit, and what is free.
uint64_t ServedDevices::free_bytes(const Served& served) const {
  const Device& device = served.terms.info.device;
  uint64_t awaited = 0;
  bool is_used = false;
  for (const auto& [weak, min_bytes] : served.scenes)
    if (const auto quota = weak.lock()) {
      is_used = true;
      awaited += min_bytes - std::min(min_bytes, quota->held());
    }
  uint64_t left = served.bytes->left();
  const bool is_ready = is_used || has_several_gpus_;  // a lone GPU is left alone until it is used
  if (device.backend == Backend::kCuda && is_ready) try {
      left = std::min(left, free_device_memory(device));
    } catch (const std::runtime_error&) {
      left = 0;
    }
  return left - std::min(left, awaited);
}

std::vector<ServedDevices::Candidate> ServedDevices::candidates(const DeviceWish& wish) const {
  std::vector<Candidate> found;
  for (const Served& each : served_) {
    const Device& device = each.terms.info.device;
    if (wish.device ? device != *wish.device : device.backend != wish.backend) continue;
    const uint64_t free = free_bytes(each);
    found.push_back({&each, free, static_cast<double>(free) / (1 + each.turns.load())});
  }
  if (found.empty()) throw std::logic_error("no device is served that a scene may have");
  return found;
}

std::shared_ptr<DeviceBytes> ServedDevices::add_scene(Served& served, uint64_t min_bytes,
                                                      const std::shared_ptr<DeviceBytes>& client) {
  std::erase_if(served.scenes, [](const auto& scene) { return scene.first.expired(); });
  auto quota = DeviceBytes::within(client, served.bytes);
  served.scenes.emplace_back(quota, min_bytes);
  return quota;
}

// Threads of the CPU's devices are shared out among the shards.
Placement ServedDevices::place_shards(const DeviceWish& wish) {
  std::map<Device, std::shared_ptr<DeviceBytes>> quotas;
  int threads = 0;
  for (const auto& [device, min_bytes] : bytes_by_device(wish)) {
    Served& here = served(device);
    quotas[device] = add_scene(here, min_bytes, nullptr);
    threads += here.terms.threads;
  }
  Placement placed{wish.shards.front(), threads, wish.client};
  for (const Device& device : wish.shards) placed.shards.push_back(quotas.at(device));
  return placed;
}

Placement ServedDevices::place(const DeviceWish& wish) {
  const std::lock_guard lock(mutex_);
  if (!wish.shards.empty()) return place_shards(wish);
  std::vector<Candidate> found = candidates(wish);
  const Candidate most = *std::ranges::max_element(found, {}, &Candidate::free);
  if (found.size() > 1) {
    if (most.free < wish.min_bytes)
      throw LimitExceeded::quota(
          "daemon", fmt::format("no device has room: the vertices and triangles of spec.meshes need at least {} bytes, "
                                "and {} has most, {} of {} bytes",
                                wish.min_bytes, to_string(most.served->terms.info.device), most.free,
                                most.served->terms.max_bytes));
    std::erase_if(found, [&](const Candidate& each) { return each.free < wish.min_bytes; });
  }
  Served& best = served(std::ranges::max_element(found, {}, &Candidate::score)->served->terms.info.device);
  return {best.terms.info.device, best.terms.threads, add_scene(best, wish.min_bytes, wish.client)};
}

const DeviceInfo& ServedDevices::preferred(const DeviceWish& wish) const {
  const std::lock_guard lock(mutex_);
  const std::vector<Candidate> found = candidates(wish);
  return std::ranges::max_element(found, {}, &Candidate::score)->served->terms.info;
}

void ServedDevices::check_could_hold(const DeviceWish& wish) const {
  constexpr const char* kWhat = "the vertices and triangles of spec.meshes";
  const std::lock_guard lock(mutex_);
  for (const auto& [device, min_bytes] : bytes_by_device(wish))
    served(device).bytes->check_could_hold(min_bytes, kWhat);
  if (!wish.shards.empty()) return;
  const std::vector<Candidate> found = candidates(wish);
  const auto limit = [](const Candidate& each) { return each.served->terms.max_bytes; };
  std::ranges::max_element(found, {}, limit)->served->bytes->check_could_hold(wish.min_bytes, kWhat);
}

void ServedDevices::set_limits(const Limits& limits) {
  const std::lock_guard lock(mutex_);
  const std::vector<DeviceInfo> all = infos();
  for (Served& each : served_) {
    const DeviceInfo& info = each.terms.info;
    each.terms.max_bytes = limit_of(info, count_of(all, info.device.backend), limits.max_device_bytes);
    each.bytes->set_max(each.terms.max_bytes);
  }
}

std::vector<DeviceState> ServedDevices::state() const {
  const std::lock_guard lock(mutex_);
  std::vector<DeviceState> states;
  for (const Served& each : served_) {
    const auto scenes = std::ranges::count_if(each.scenes, [](const auto& scene) { return !scene.first.expired(); });
    states.push_back({each.terms.info, each.terms.max_bytes, each.bytes->held(), free_bytes(each),
                      static_cast<uint32_t>(scenes), each.turns.load(), each.turns.busy_seconds(),
                      each.turns.waiting()});
  }
  return states;
}

}  // namespace collided::server
