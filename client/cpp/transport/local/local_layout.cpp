// The layout of the memory that a stream shares with the daemon.

#include "client/cpp/transport/local/local_layout.hpp"

#include <algorithm>

#include "client/cpp/positions.hpp"
#include "proto/constants.hpp"

namespace collided::client {

LocalLayout local_layout(const v1::Scene& scene, uint32_t window, const LocalOptions& options) {
  const v1::SceneSpec& spec = scene.spec();
  const uint64_t position = position_bytes(spec.position_format());
  const uint64_t positions = spec.mode() == v1::DETECTION_MODE_DCD ? 1 : 2;
  const uint64_t worlds = std::max(scene.worlds(), 1u);
  uint64_t vertices = 0;
  for (const v1::MeshSpec& mesh : spec.meshes()) vertices += mesh.vertex_count();
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
