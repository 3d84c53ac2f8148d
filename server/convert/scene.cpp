// Scenes from the protocol to the engine.
#include "server/convert/scene.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>
#include <functional>
#include <string_view>

#include "server/convert/kinds.hpp"
#include "server/convert/meshes.hpp"
#include "server/convert/options.hpp"
#include "server/refusals/refuse.hpp"
#include "server/shorten.hpp"

namespace collided::server {
namespace {

bool serves(const SceneDefaults& defaults, Backend backend) {
  return std::ranges::any_of(defaults.devices, [&](const Device& device) { return device.backend == backend; });
}

std::vector<std::string> ids_of(const std::vector<Device>& devices) {
  std::vector<std::string> ids;
  for (const Device& device : devices) ids.push_back(to_string(device));
  return ids;
}

// `why`: empty where the machine has a device, but the daemon does not serve it.
std::string no_cuda_text(const std::string& why) {
  return "spec.backend is BACKEND_CUDA, but this daemon has no usable CUDA device" + (why.empty() ? "" : ": " + why);
}

Backend parse_backend(pb::Backend wanted, const SceneDefaults& defaults) {
  if (wanted == pb::BACKEND_UNSPECIFIED)
    wanted = defaults.backend == "cpu"    ? pb::BACKEND_CPU
             : defaults.backend == "cuda" ? pb::BACKEND_CUDA
                                          : pb::BACKEND_AUTO;
  if (wanted == pb::BACKEND_AUTO) return serves(defaults, Backend::kCuda) ? Backend::kCuda : Backend::kCpu;
  if (wanted != pb::BACKEND_CPU && wanted != pb::BACKEND_CUDA)
    throw_unknown("spec.backend", wanted, {pb::BACKEND_AUTO, pb::BACKEND_CPU, pb::BACKEND_CUDA});
  if (wanted == pb::BACKEND_CUDA && !serves(defaults, Backend::kCuda))
    throw FailedPrecondition("spec.backend", no_cuda_text(cuda_obstacle()));
  if (wanted == pb::BACKEND_CPU && !serves(defaults, Backend::kCpu))
    throw FailedPrecondition("spec.backend", fmt::format("spec.backend is BACKEND_CPU, but this daemon serves only {}",
                                                         fmt::join(ids_of(defaults.devices), ", ")));
  return wanted == pb::BACKEND_CPU ? Backend::kCpu : Backend::kCuda;
}

// A device of the spec that `field` names by its id.
Device parse_device_id(const std::string& id, const std::string& field, const pb::SceneSpec& spec,
                       const SceneDefaults& defaults) {
  const std::optional<Device> device = parse_device(id);
  if (!device)
    throw_invalid(field,
                  fmt::format("is \"{}\", but must be {}", shorten(id, 64), list_choices(ids_of(defaults.devices))));
  if (std::ranges::count(defaults.devices, *device) == 0)
    throw FailedPrecondition(field, fmt::format("{} is {}, but this daemon serves {}", field, to_string(*device),
                                                fmt::join(ids_of(defaults.devices), ", ")));
  const pb::Backend backend = device->backend == Backend::kCpu ? pb::BACKEND_CPU : pb::BACKEND_CUDA;
  if ((spec.backend() == pb::BACKEND_CPU || spec.backend() == pb::BACKEND_CUDA) && spec.backend() != backend)
    throw_invalid(field,
                  fmt::format("is {}, but spec.backend is {}", to_string(*device), pb::Backend_Name(spec.backend())));
  return *device;
}

// Each shard has a thread of the host: many on one device would take them for nothing. Refusals call shards parts, as
// the field does.
std::vector<Device> parse_part_devices(const pb::SceneSpec& spec, const SceneDefaults& defaults) {
  constexpr ptrdiff_t kMaxShardsOnDevice = 4;
  const std::string field = "spec.part_devices";
  const auto shards = static_cast<size_t>(spec.part_devices_size());
  if (shards > kMaxShards) throw_invalid(field, fmt::format("has {} parts, more than {}", shards, kMaxShards));
  if (shards > 0 && !spec.device().empty())
    throw_invalid("spec.device",
                  fmt::format("is \"{}\", but {} says where the scene lives", shorten(spec.device(), 64), field));
  std::vector<Device> devices;
  for (const std::string& id : spec.part_devices()) {
    devices.push_back(parse_device_id(id, fmt::format("{}[{}]", field, devices.size()), spec, defaults));
    if (const auto there = std::ranges::count(devices, devices.back()); there > kMaxShardsOnDevice)
      throw_invalid(field, fmt::format("has {} or more parts on {}, more than {}", there, to_string(devices.back()),
                                       kMaxShardsOnDevice));
  }
  return devices;
}

// Its ordinal is decided when the scene is placed.
void parse_place(const pb::SceneSpec& spec, const SceneDefaults& defaults, ScenePlan& plan) {
  if (!plan.engine.part_devices.empty()) {
    plan.engine.device = plan.engine.part_devices.front();
    return;
  }
  if (!spec.device().empty()) plan.device = parse_device_id(spec.device(), "spec.device", spec, defaults);
  plan.engine.device = plan.device ? *plan.device : Device{parse_backend(spec.backend(), defaults)};
}

// A scene's first frame has all its positions, and a frame is one message.
void check_first_frame(uint64_t vertices, const SceneSpec& engine, const SceneDefaults& defaults) {
  const uint64_t bytes = vertices * position_bytes(engine), limit = defaults.limits.max_message_bytes;
  if (defaults.local_socket || bytes < limit) return;
  throw LimitExceeded(
      "spec.meshes", fmt::format("spec.meshes has {} vertices, whose positions, {} bytes, come with the first frame in "
                                 "one message, but max_message_bytes (max-message-mb) is {}, and this daemon has no "
                                 "local socket",
                                 vertices, bytes, limit));
}

// The minimum memory of the scene; refuses a scene that could never hold a frame.
uint64_t check_budget(const SceneSpec& engine, const SceneSize& size, bool is_asked) {
  const uint64_t need = min_scene_bytes(engine, size.vertices, size.elements());
  if (need > engine.memory_budget)
    throw LimitExceeded(
        "spec.memory_budget_bytes",
        fmt::format("spec.memory_budget_bytes is {}{}, but the {} vertices and {} {} of spec.meshes need at least {} "
                    "bytes",
                    engine.memory_budget, is_asked ? "" : " (max_scene_bytes)", size.vertices, size.elements(),
                    size.names_of_elements(), need));
  return need;
}

uint64_t parse_expected_contacts(uint64_t expected) {
  if (expected > kMaxListLength)
    throw_invalid("spec.expected_contacts", fmt::format("is {}, more than {}", expected, kMaxListLength));
  return expected;
}

uint64_t parse_budget(uint64_t budget, uint64_t limit) {
  if (budget > limit)
    throw LimitExceeded("spec.memory_budget_bytes",
                        fmt::format("spec.memory_budget_bytes is {}, more than max_scene_bytes, {}", budget, limit));
  return budget ? budget : limit;
}

// Hashes a stream block by block, without a copy of the whole.
class HashOfBytes final : public google::protobuf::io::CopyingOutputStream {
 public:
  bool Write(const void* bytes, int size) override {
    const std::string_view block(static_cast<const char*>(bytes), static_cast<size_t>(size));
    hash_ = hash_ * 0x9e3779b97f4a7c15u + std::hash<std::string_view>{}(block);
    return true;
  }
  uint64_t hash() const { return hash_; }

 private:
  uint64_t hash_ = 0;
};

// Equal for repeated requests, whose leases may differ.
uint64_t fingerprint(const pb::SceneSpec& spec) {
  HashOfBytes hash;
  {
    google::protobuf::io::CopyingOutputStreamAdaptor blocks(&hash);
    google::protobuf::io::CodedOutputStream coded(&blocks);
    coded.SetSerializationDeterministic(true);
    spec.SerializeToCodedStream(&coded);
  }
  return hash.hash();
}

double parse_lease(double seconds, const Limits& limits) {
  if (!(seconds >= 0)) throw_invalid("lease_seconds", fmt::format("is {}, but must be 0 or more", seconds));
  if (seconds > limits.max_lease_seconds)
    throw LimitExceeded("lease_seconds", fmt::format("lease_seconds is {}, more than max_lease_seconds, {}", seconds,
                                                     limits.max_lease_seconds));
  return seconds > 0 ? seconds : limits.lease_seconds;
}

// By default CERTIFIED, or the highest that the client may have.
Accuracy parse_scene_accuracy(pb::Accuracy wanted, Accuracy max) {
  const auto asked = parse<Accuracy>(wanted, "spec.accuracy");
  if (asked) check_max_accuracy(*asked, max, "spec.accuracy");
  return asked.value_or(std::min(Accuracy::kCertified, max));
}

// Worlds together are as large as a scene may be; only each one's first frame has to fit a message.
void check_set_size(const SceneSize& size, uint32_t worlds, const Limits& limits) {
  const auto check = [&](const char* what, uint64_t each, const char* name, uint64_t limit) {
    if (each * worlds > limit)
      throw LimitExceeded("count", fmt::format("count is {}, and so many scenes of {} {} have {}, more than {}, {}",
                                               worlds, each, what, each * worlds, name, limit));
  };
  check("vertices", size.vertices, "max_vertices", limits.max_vertices);
  check(size.names_of_elements(), size.elements(), "max_triangles", limits.max_triangles);
}

// `worlds`: of a set; 0: the request is for a scene.
template <class Request>
SceneRequest parse_request(const Request& request, const SceneDefaults& defaults, uint32_t worlds) {
  constexpr size_t kMaxRequestIdBytes = 64;
  if (request.request_id().size() > kMaxRequestIdBytes)
    throw_invalid("request_id",
                  fmt::format("has {} bytes, more than {}", request.request_id().size(), kMaxRequestIdBytes));
  const double lease = parse_lease(request.lease_seconds(), defaults.limits);
  return {parse_spec(request.spec(), defaults, worlds), request.request_id(), fingerprint(request.spec()) + worlds,
          lease};
}

}  // namespace

ScenePlan parse_spec(const pb::SceneSpec& spec, const SceneDefaults& defaults, uint32_t worlds) {
  if (spec.display_name().size() > kMaxNameBytes)
    throw_invalid("spec.display_name",
                  fmt::format("has {} bytes, more than {}", spec.display_name().size(), kMaxNameBytes));
  ScenePlan plan;
  plan.display_name = spec.display_name();
  SceneSpec& engine = plan.engine;
  engine.mode = parse_mode(spec.mode(), "spec.mode");
  engine.accuracy = parse_scene_accuracy(spec.accuracy(), defaults.limits.client.max_accuracy);
  parse_format(spec, engine);
  engine.thickness = spec.thickness();
  engine.delta = spec.delta();
  engine.min_separation = spec.min_separation();
  engine.rest_distance = spec.rest_distance();
  engine.report = parse<Report>(spec.report(), "spec.report").value_or(Report::kAll);
  engine.engine = parse<Engine>(spec.broad_phase_engine(), "spec.broad_phase_engine").value_or(Engine::kAuto);
  engine.reuse = parse<Reuse>(spec.reuse(), "spec.reuse").value_or(Reuse::kAuto);
  engine.worlds = worlds;
  engine.part_devices = parse_part_devices(spec, defaults);
  engine.expected[ListLengths::kContacts] = parse_expected_contacts(spec.expected_contacts());
  parse_kinds(spec, engine);
  plan.fields = parse_fields(spec, engine.mode);
  engine.fields = plan.fields.columns;
  engine.pair_states = plan.fields.pair_states;
  check_scene_options(engine, spec);
  engine.memory_budget = parse_budget(spec.memory_budget_bytes(), defaults.limits.max_scene_bytes);
  engine.threads = defaults.threads;
  const SceneSize size = check_sizes(spec, defaults.limits);
  if (worlds > 0) check_set_size(size, worlds, defaults.limits);
  check_first_frame(size.vertices, engine, defaults);
  plan.min_bytes = check_budget(engine, size, spec.memory_budget_bytes() > 0);
  parse_meshes(spec, plan);
  parse_exclusions(spec, plan);
  parse_place(spec, defaults, plan);
  return plan;
}

SceneRequest parse_scene(const pb::CreateSceneRequest& request, const SceneDefaults& defaults) {
  return parse_request(request, defaults, 0);
}

SceneRequest parse_scenes(const pb::CreateScenesRequest& request, const SceneDefaults& defaults) {
  if (request.count() == 0 || request.count() > kMaxWorlds)
    throw_invalid("count", fmt::format("is {}, but must be from 1 to {}", request.count(), kMaxWorlds));
  return parse_request(request, defaults, request.count());
}

}  // namespace collided::server
