// How the memory that a stream shares with the daemon is divided.

#include "client/cpp/transport/local/local_layout.hpp"

#include <algorithm>

namespace collided::client {

namespace {

constexpr uint64_t kPage = 4096;
constexpr uint64_t kMaxOutputBytes = uint64_t{1} << 30;
constexpr uint64_t kUpdateBytes = 256;  // of a mesh: its update's message and the padding of its arrays
constexpr uint64_t kMessageBytes = uint64_t{64} << 10;

uint64_t pages_of(uint64_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

}  // namespace

LocalLayout local_layout(const v1::SceneSpec& scene, uint32_t window, const LocalOptions& options) {
  const uint64_t position = scene.position_format() == v1::POSITION_FORMAT_F64 ? 24 : 12;
  const uint64_t positions = scene.mode() == v1::DETECTION_MODE_DCD ? 1 : 2;
  uint64_t bytes = kMessageBytes;
  for (const v1::MeshSpec& mesh : scene.meshes())
    bytes += mesh.vertex_count() * (positions * position + sizeof(uint32_t)) + kUpdateBytes;
  const bool is_device = !options.cuda_ipc_handle.empty();
  const uint64_t max_output = kMaxOutputBytes / window / kPage * kPage;
  return {window, is_device ? 0 : pages_of(bytes), window * std::min(pages_of(options.output_bytes), max_output)};
}

}  // namespace collided::client
