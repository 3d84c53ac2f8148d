// The layout of the memory that a stream shares with the daemon.

#include "client/cpp/transport/local/local_layout.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <string>

#include "client/cpp/error.hpp"
#include "client/cpp/positions.hpp"
#include "proto/constants.hpp"

namespace collided::client {

namespace {

constexpr uint64_t kMaxVertices = uint64_t{1} << 40;

}  // namespace

LocalLayout local_layout(const v1::Scene& scene, uint32_t window, const LocalOptions& options) {
  const v1::SceneSpec& spec = scene.spec();
  const uint64_t position = position_bytes(spec.position_format());
  const uint64_t positions = spec.mode() == v1::DETECTION_MODE_DCD ? 1 : 2;
  const uint64_t worlds = std::max(scene.worlds(), 1u);
  uint64_t vertices = 0;
  for (const v1::MeshSpec& mesh : spec.meshes()) vertices += mesh.vertex_count();
  if (vertices > kMaxVertices / worlds)  // as the daemon tells it, and so large that its bytes would overflow
    throw Error(grpc::RESOURCE_EXHAUSTED, "the scene has " + std::to_string(vertices) + " vertices in each of " +
                                              std::to_string(worlds) + " worlds, more than shared memory can hold");
  const uint64_t bytes = v1::max_frame_input_bytes(worlds * vertices, positions * position,
                                                   worlds * static_cast<uint64_t>(spec.meshes_size()));
  const bool is_device = !options.cuda_ipc_handle.empty();
  const uint64_t max_output = v1::kMaxOutputBytes / window / v1::kPageBytes * v1::kPageBytes;
  const uint64_t max_edit = v1::kMaxEditInputBytes / window / v1::kPageBytes * v1::kPageBytes;
  const uint64_t edit = std::min(v1::whole_pages(options.edit_bytes), max_edit);
  return {window, is_device ? 0 : bytes + edit, window * std::min(v1::whole_pages(options.output_bytes), max_output),
          !options.output_cuda_ipc_handle.empty()};
}

}  // namespace collided::client
