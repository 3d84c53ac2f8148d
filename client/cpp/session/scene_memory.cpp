// Where the last answered frame has left a scene, by the daemon's own formulas.

#include "client/cpp/session/scene_memory.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <cstring>
#include <utility>

#include "client/cpp/positions.hpp"

namespace collided::client {

namespace {

[[noreturn]] void throw_impossible(const char* what) {
  throw Error(grpc::DATA_LOSS, std::string("the daemon has applied a frame ") + what);
}

template <class Real>
std::span<Real> reals(std::span<std::byte> bytes) {
  return {reinterpret_cast<Real*>(bytes.data()), bytes.size() / sizeof(Real)};
}
template <class Real>
std::span<const Real> reals(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const Real*>(bytes.data()), bytes.size() / sizeof(Real)};
}

/// Moves positions in `format` as far to `target` as the frame did. Their first vertex is `vertex`, scene-wide.
void move_bytes(std::span<std::byte> from, std::span<const std::byte> target, const FrameAdvance& advance,
                uint32_t mesh, uint32_t vertex, v1::PositionFormat format) {
  if (is_double(format))
    move_along(reals<double>(from), reals<double>(target), advance, mesh, vertex);
  else
    move_along(reals<float>(from), reals<float>(target), advance, mesh, vertex);
}

constexpr RigidMatrix kAtRest{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// Where the entries of a sparse update are in their mesh. Throws Error where they are not in it.
std::vector<size_t> places_of(const Bytes& indices, size_t stride, size_t mesh_bytes) {
  std::vector<size_t> places;
  for (size_t at = 0; at + sizeof(uint32_t) <= indices.size(); at += sizeof(uint32_t)) {
    uint32_t index = 0;
    std::memcpy(&index, &indices[at], sizeof(index));
    places.push_back(index * stride);
    if (places.back() + stride > mesh_bytes) throw_impossible("of a vertex that its mesh has not");
  }
  return places;
}

Bytes gather(const Bytes& all, const std::vector<size_t>& places, size_t stride) {
  Bytes some(places.size() * stride);
  for (size_t i = 0; i < places.size(); ++i) std::memcpy(&some[i * stride], &all[places[i]], stride);
  return some;
}

void scatter(const Bytes& some, const std::vector<size_t>& places, size_t stride, Bytes& all) {
  for (size_t i = 0; i < places.size(); ++i) std::memcpy(&all[places[i]], &some[i * stride], stride);
}

}  // namespace

SceneMemory::SceneMemory(const v1::SceneSpec& spec, std::span<const MeshInput> meshes)
    : mode_(spec.mode()), format_(spec.position_format()) {
  uint32_t first_vertex = 0;
  for (const MeshInput& mesh : meshes) {
    meshes_.push_back({&mesh, first_vertex, {}, {}});
    first_vertex += mesh.vertex_count;
  }
}

size_t SceneMemory::stride() const { return position_bytes(format_); }

void SceneMemory::apply(OwnedFrame&& frame, const FrameOutput& answer) {
  if (frame.options.trial) return;
  const bool is_first = !first_;
  if (is_first) first_ = frame;
  for (OwnedUpdate& update : frame.updates) {
    if (update.mesh >= meshes_.size()) throw_impossible("of a mesh that the scene has not");
    Mesh& mesh = meshes_[update.mesh];
    if (mesh.input->is_rigid)
      move_body(mesh, update, answer, is_first);
    else if (!mesh.input->is_static)
      move_vertices(mesh, update, answer);
  }
}

void SceneMemory::move_body(Mesh& mesh, const OwnedUpdate& update, const FrameOutput& answer, bool is_first) const {
  if (!update.transform) return;
  const RigidMatrix here = is_first ? *update.transform : mesh.pose.value_or(kAtRest);
  const double fraction = answer.advance.of_body(update.mesh, mesh.first_vertex, mesh.input->vertex_count);
  mesh.pose = answer.done.has_advanced()
                  ? pose_along(update.start_transform.value_or(here), *update.transform, fraction)
                  : *update.transform;
}

void SceneMemory::move_vertices(Mesh& mesh, OwnedUpdate& update, const FrameOutput& answer) const {
  const bool is_sparse = !update.indices.empty();
  const std::vector<size_t> places = places_of(update.indices, stride(), mesh.positions.size());
  if (is_sparse && update.positions.size() != places.size() * stride())
    throw_impossible("with another number of positions than of indices");
  if (answer.done.has_advanced()) {
    Bytes way = std::move(update.start_positions);
    if (way.empty()) way = is_sparse ? gather(mesh.positions, places, stride()) : mesh.positions;
    // In its first frame a mesh without start positions stands still.
    if (!way.empty()) go(mesh, update, places, answer.advance, way), update.positions = std::move(way);
  }
  if (is_sparse) return scatter(update.positions, places, stride(), mesh.positions);
  if (update.positions.size() != mesh.input->vertex_count * stride())
    throw_impossible("with another number of positions than its mesh has vertices");
  mesh.positions = std::move(update.positions);
}

void SceneMemory::go(const Mesh& mesh, const OwnedUpdate& update, const std::vector<size_t>& places,
                     const FrameAdvance& advance, Bytes& way) const {
  if (way.size() != update.positions.size()) throw_impossible("with another number of positions at its start");
  const auto move = [&](size_t at, size_t bytes, size_t vertex) {
    move_bytes(std::span(way).subspan(at, bytes), std::span(update.positions).subspan(at, bytes), advance, update.mesh,
               mesh.first_vertex + static_cast<uint32_t>(vertex), format_);
  };
  if (update.indices.empty()) return move(0, way.size(), 0);
  for (size_t i = 0; i < places.size(); ++i) move(i * stride(), stride(), places[i] / stride());
}

std::vector<FrameUpdate> SceneMemory::updates(bool is_new) const {
  const bool has_start = mode_ == v1::DETECTION_MODE_CCD;
  std::vector<FrameUpdate> out;
  for (uint32_t i = 0; i < meshes_.size(); ++i) {
    const Mesh& mesh = meshes_[i];
    const bool is_at_rest = mesh.input->is_rigid && !mesh.pose;
    if (mesh.input->is_static || (is_at_rest && is_new)) continue;
    FrameUpdate update{.mesh = i, .positions = mesh.positions};
    if (mesh.input->is_rigid) update.transform = is_at_rest ? &kAtRest : &*mesh.pose;
    if (has_start) update.start_positions = update.positions, update.start_transform = update.transform;
    out.push_back(update);
  }
  return out;
}

/// It stands still, so that it costs little, and meets nothing on a way that nobody went.
FrameOptions SceneMemory::options() const {
  if (mode_ == v1::DETECTION_MODE_DCD_AND_CCD) return {.mode = v1::DETECTION_MODE_DCD};
  return {};
}

}  // namespace collided::client
