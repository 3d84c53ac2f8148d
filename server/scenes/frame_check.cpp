// The rules that a frame must meet before the engine sees it.
#include "server/scenes/frame_check.hpp"

#include <spdlog/fmt/fmt.h>

#include <string>
#include <vector>

#include "server/errors.hpp"

namespace collided::server {
namespace {

std::string update_path(size_t index, const char* field) { return fmt::format("frame.updates[{}].{}", index, field); }

void check_bytes(const ScenePlan& plan, uint32_t mesh, std::span<const std::byte> bytes, const std::string& field) {
  const bool wide = plan.engine.scalar == Scalar::kF64;
  const uint64_t vertices = plan.engine.meshes[mesh].vertex_count;
  const uint64_t expected = vertices * (wide ? 24 : 12);
  if (bytes.size() != expected)
    throw InvalidInput(
        field, fmt::format("{} has {} bytes, but the {} vertices of mesh \"{}\" in {} need {}", field, bytes.size(),
                           vertices, plan.meshes[mesh].name, wide ? "F64" : "F32", expected));
}

void check_update(const ScenePlan& plan, const MeshPositions& update, size_t index, bool first) {
  const auto& mesh = plan.engine.meshes[update.mesh];
  if (mesh.is_static && !first) {
    const std::string field = update_path(index, "mesh");
    throw FailedPrecondition(field, fmt::format("{} is {}, but mesh \"{}\" is static and took its positions with the "
                                                "first frame",
                                                field, update.mesh, plan.meshes[update.mesh].name));
  }
  check_bytes(plan, update.mesh, update.end, update_path(index, "positions"));
  if (update.start.empty()) return;
  const std::string field = update_path(index, "start_positions");
  if (plan.engine.mode != Mode::kCcd)
    throw InvalidInput(field, fmt::format("{} has {} bytes, but a DCD scene takes none", field, update.start.size()));
  check_bytes(plan, update.mesh, update.start, field);
}

}  // namespace

void check_frame_id(uint64_t frame_id, uint64_t last_frame_id) {
  if (frame_id == 0) throw InvalidInput("frame.frame_id", "frame.frame_id is 0, but ids start at 1");
  if (frame_id <= last_frame_id)
    throw FailedPrecondition("frame.frame_id",
                             fmt::format("frame.frame_id is {}, but must be greater than {}, the last frame applied",
                                         frame_id, last_frame_id));
}

void check_updates(const ScenePlan& plan, const FrameInput& frame, bool first) {
  const size_t meshes = plan.meshes.size();
  std::vector<bool> named(meshes, false);
  for (size_t i = 0; i < frame.updates.size(); ++i) {
    const uint32_t mesh = frame.updates[i].mesh;
    const std::string field = update_path(i, "mesh");
    if (mesh >= meshes)
      throw InvalidInput(field, fmt::format("{} is {}, but the scene has {} meshes", field, mesh, meshes));
    if (named[mesh]) throw InvalidInput(field, fmt::format("{} is {}, which came before in this frame", field, mesh));
    named[mesh] = true;
    check_update(plan, frame.updates[i], i, first);
  }
  for (size_t mesh = 0; first && mesh < meshes; ++mesh)
    if (!named[mesh])
      throw InvalidInput("frame.updates", fmt::format("frame.updates leaves out mesh {} \"{}\", but the first frame "
                                                      "must name every mesh",
                                                      mesh, plan.meshes[mesh].name));
}

}  // namespace collided::server
