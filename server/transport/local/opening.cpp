// The first packet of a local stream.
#include "server/transport/local/opening.hpp"

#include <cstddef>
#include <string>

#include "proto/constants.hpp"
#include "server/convert/refuse.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

void check_bytes(const char* field, uint64_t bytes, uint64_t max) {
  if (bytes % pb::kPageBytes != 0)
    throw_invalid(field, fmt::format("is {}, but must be a multiple of {}", bytes, pb::kPageBytes));
  if (bytes > max)
    throw LimitExceeded(field,
                        fmt::format("{} is {}, but streams of this scene can use at most {}", field, bytes, max));
}

void check_handle(const pb::LocalOpen& open, const Scene& scene, bool is_allowed) {
  constexpr auto kField = "open.cuda_ipc_handle";
  const std::string& handle = open.cuda_ipc_handle();
  if (!is_allowed)
    throw FailedPrecondition(kField, fmt::format("{} is set, but the daemon runs without --cuda-ipc", kField));
  if (handle.size() != pb::kCudaIpcHandleBytes)
    throw_invalid(kField, fmt::format("has {} bytes, but a handle has {}", handle.size(), pb::kCudaIpcHandleBytes));
  if (scene.plan()->engine.backend != Backend::kCuda)
    throw FailedPrecondition(kField, fmt::format("{} is set, but scene {} is not on a GPU", kField, scene.id()));
  if (open.input_bytes() != 0)
    throw_invalid("open.input_bytes", fmt::format("is {}, but must be 0 with cuda_ipc_handle", open.input_bytes()));
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
  const uint64_t frame = pb::max_frame_input_bytes(count_vertices(spec), max_vertex_bytes(spec), spec.meshes.size());
  return window * (frame + pb::kPageBytes) + pb::kMaxEditInputBytes;
}

void check_region(const pb::LocalOpen& open, const std::vector<PassedFile>& files, const Scene& scene,
                  const OpeningRules& rules) {
  if (!open.cuda_ipc_handle().empty()) check_handle(open, scene, rules.cuda_ipc);
  check_bytes("open.input_bytes", open.input_bytes(), max_input_bytes(scene, rules.host.limits().max_window));
  check_bytes("open.output_bytes", open.output_bytes(), pb::kMaxOutputBytes);
  check_files(files, open.input_bytes() + open.output_bytes() > 0);
}

// Counted here, as pages that the daemon touches first are charged to the daemon.
std::unique_ptr<MemoryHold> hold_region(const pb::LocalOpen& open, const Scene& scene) {
  auto held = std::make_unique<MemoryHold>(scene.plan()->quota);
  held->resize(open.input_bytes() + open.output_bytes());
  return held;
}

std::shared_ptr<SharedRegion> map_region(const pb::LocalOpen& open, const std::vector<PassedFile>& files,
                                         const Scene& scene) {
  const Fd none;
  const Fd& file = files.empty() ? none : files.front().fd();
  const std::string& handle = open.cuda_ipc_handle();
  if (!handle.empty()) return SharedRegion::open(std::as_bytes(std::span(handle)), file, open.output_bytes());
  if (files.empty()) return nullptr;
  return SharedRegion::map(file, {open.input_bytes(), open.output_bytes()}, scene.plan()->engine.backend);
}

}  // namespace

Opening check_opening(const pb::LocalOpen& open, std::vector<PassedFile> files, const OpeningRules& rules) {
  if (open.version() != pb::kLocalVersion)
    throw_invalid("open.version", fmt::format("is {}, but this daemon speaks {}", open.version(), pb::kLocalVersion));
  Opening opening;
  opening.client = rules.authenticator.identify(open.token().empty() ? "" : "Bearer " + open.token(), "");
  rules.host.check_serving();
  opening.ticket = rules.host.usage().begin_stream(opening.client);
  opening.scene = rules.host.scenes().find(opening.client, open.open().scene_id());
  opening.terms = parse_open(open.open(), rules.host.limits());
  check_region(open, files, *opening.scene, rules);
  opening.region_bytes = hold_region(open, *opening.scene);
  opening.region = map_region(open, files, *opening.scene);
  return opening;
}

}  // namespace collided::server
