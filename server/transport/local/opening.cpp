// The first packet of a local stream.
#include "server/transport/local/opening.hpp"

#include <cstddef>
#include <string>

#include "proto/constants.hpp"
#include "server/errors.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

void check_bytes(const char* field, uint64_t bytes, uint64_t max) {
  if (bytes % pb::kPageBytes != 0)
    throw_invalid(field, fmt::format("is {}, but must be a multiple of {}", bytes, pb::kPageBytes));
  if (bytes > max)
    throw LimitExceeded(field,
                        fmt::format("{} is {}, but streams of this scene can use at most {}", field, bytes, max));
}

// An empty handle is none.
void check_handle(const char* field, const std::string& handle, bool is_allowed) {
  if (handle.empty()) return;
  if (!is_allowed)
    throw FailedPrecondition(field, fmt::format("{} is set, but the daemon runs without --cuda-ipc", field));
  if (handle.size() != pb::kCudaIpcHandleBytes)
    throw_invalid(field, fmt::format("has {} bytes, but a handle has {}", handle.size(), pb::kCudaIpcHandleBytes));
}

void check_scene(const char* field, const std::string& handle, const Scene& scene) {
  if (handle.empty()) return;
  const auto plan = scene.plan();
  if (plan->engine.worlds > 0)
    throw FailedPrecondition(
        field, fmt::format("{} is set, but scene {} is a set, whose positions and contacts are in the host's memory",
                           field, scene.id()));
  if (is_sharded(plan->engine))
    throw FailedPrecondition(
        field,
        fmt::format("{} is set, but scene {} is in parts on several devices (spec.part_devices), whose positions "
                    "and contacts are in the host's memory",
                    field, scene.id()));
  if (plan->engine.device.backend != Backend::kCuda)
    throw FailedPrecondition(field, fmt::format("{} is set, but scene {} is not on a GPU: it lives on {}", field,
                                                scene.id(), to_string(plan->engine.device)));
}

// Of what the client has on the device instead of in the file.
void check_device_sizes(const pb::LocalOpen& open, uint32_t window) {
  if (!open.cuda_ipc_handle().empty() && open.input_bytes() != 0)
    throw_invalid("open.input_bytes", fmt::format("is {}, but must be 0 with cuda_ipc_handle", open.input_bytes()));
  if (!open.output_cuda_ipc_handle().empty() && open.output_bytes() < window * pb::kPageBytes)
    throw_invalid(
        "open.output_bytes",
        fmt::format("is {}, but must be {} or more with output_cuda_ipc_handle: {} for each frame of the window",
                    open.output_bytes(), window * pb::kPageBytes, pb::kPageBytes));
}

// Of the output region, in the file.
uint64_t output_in_file(const pb::LocalOpen& open) {
  return open.output_cuda_ipc_handle().empty() ? open.output_bytes() : 0;
}

void check_files(const std::vector<PassedFile>& files, bool is_needed) {
  const size_t wanted = is_needed ? 1 : 0;
  if (files.size() != wanted)
    throw_invalid("open.file",
                  fmt::format("was passed {} times, but must be passed {} times for these sizes: it is the memfd",
                              files.size(), wanted));
}

// With a page to spare for each frame, and room for edits.
uint64_t max_input_bytes(const Scene& scene, uint32_t window) {
  const auto plan = scene.plan();
  const SceneSpec& spec = plan->engine;
  const uint64_t worlds = count_worlds(spec);
  const uint64_t frame =
      pb::max_frame_input_bytes(worlds * count_vertices(spec), max_vertex_bytes(spec), worlds * spec.meshes.size());
  return window * (frame + pb::kPageBytes) + pb::kMaxEditInputBytes;
}

void check_region(const pb::LocalOpen& open, const std::vector<PassedFile>& files, const Opening& opening,
                  const OpeningRules& rules) {
  constexpr auto kInput = "open.cuda_ipc_handle", kOutput = "open.output_cuda_ipc_handle";
  const Scene& scene = *opening.scene;
  check_handle(kInput, open.cuda_ipc_handle(), rules.cuda_ipc);
  check_handle(kOutput, open.output_cuda_ipc_handle(), rules.cuda_ipc);
  check_device_sizes(open, opening.terms.window);
  check_bytes("open.input_bytes", open.input_bytes(), max_input_bytes(scene, rules.host.limits().max_window));
  check_bytes("open.output_bytes", open.output_bytes(), pb::kMaxOutputBytes);
  check_files(files, open.input_bytes() + output_in_file(open) > 0);
  check_scene(kInput, open.cuda_ipc_handle(), scene);
  check_scene(kOutput, open.output_cuda_ipc_handle(), scene);
}

// Counted here, as pages that the daemon touches first are charged to the daemon. The client's device memory is not.
std::unique_ptr<MemoryHold> hold_region(const pb::LocalOpen& open, const Scene& scene) {
  auto held = std::make_unique<MemoryHold>(scene.plan()->quota);
  held->resize(open.input_bytes() + output_in_file(open));
  return held;
}

std::shared_ptr<SharedRegion> map_region(const pb::LocalOpen& open, const std::vector<PassedFile>& files,
                                         const Scene& scene) {
  const Fd none;
  const Fd& file = files.empty() ? none : files.front().fd();
  const std::string &input = open.cuda_ipc_handle(), &output = open.output_cuda_ipc_handle();
  if (files.empty() && input.empty() && output.empty()) return nullptr;
  const RegionSize in_file{open.input_bytes(), output_in_file(open)};
  const Device device = scene.plan()->engine.device;
  auto region = input.empty() ? SharedRegion::map(file, in_file, device)
                              : SharedRegion::open(std::as_bytes(std::span(input)), device, file, in_file.output);
  if (!output.empty()) region->open_output(std::as_bytes(std::span(output)), device, open.output_bytes());
  return region;
}

}  // namespace

Opening check_opening(const pb::LocalOpen& open, std::vector<PassedFile> files, const OpeningRules& rules,
                      const Origin& origin) {
  if (open.version() != pb::kLocalVersion)
    throw_invalid("open.version", fmt::format("is {}, but this daemon speaks {}", open.version(), pb::kLocalVersion));
  Opening opening;
  opening.client = rules.authenticator.identify(open.token().empty() ? "" : "Bearer " + open.token(), "", origin);
  rules.host.check_serving();
  opening.scene = rules.host.scenes().find(opening.client, open.open().scene_id());
  opening.ticket = rules.host.begin_stream(opening.client, *opening.scene, open.open().resume_token());
  opening.terms = parse_open(open.open(), rules.host.limits());
  check_region(open, files, opening, rules);
  opening.region_bytes = hold_region(open, *opening.scene);
  opening.region = map_region(open, files, *opening.scene);
  return opening;
}

}  // namespace collided::server
