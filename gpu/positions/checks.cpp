#include "gpu/positions/checks.hpp"

#include "gpu/base/text.hpp"
#include "gpu/positions/format.hpp"

namespace collided {
namespace {

std::string name_of(size_t update) { return "updates[" + text(update) + "]"; }

/// `of`: the vertices, in words.
void check_bytes(const std::string& field, std::span<const std::byte> bytes, uint64_t vertices, Scalar scalar,
                 const std::string& of) {
  const uint64_t want = vertices * position_bytes(scalar);
  if (bytes.size() == want) return;
  std::string what = field + " has " + text(bytes.size()) + " bytes; " + name_of(scalar) + " positions of " +
                     text(vertices) + " vertices" + of + " are " + text(want);
  const Scalar other = scalar == Scalar::kF64 ? Scalar::kF32 : Scalar::kF64;
  if (bytes.size() == vertices * position_bytes(other))
    what += "; " + text(bytes.size()) + " is what " + name_of(other) + " positions take, and the scene is of " +
            name_of(scalar);
  throw InvalidInput(field, what);
}

/// Of the vertices that an update has positions for.
uint64_t checked_count(const MeshSpec& mesh, const MeshPositions& update, const std::string& field) {
  const std::string name = field + ".indices";
  const size_t bytes = update.indices.size();
  if (!update.is_sparse) {
    if (bytes != 0) throw InvalidInput(name, name + " has " + text(bytes) + " bytes, but the update is not sparse");
    return mesh.vertex_count;
  }
  if (bytes % sizeof(uint32_t) != 0)
    throw InvalidInput(name, name + " has " + text(bytes) + " bytes, which is no multiple of 4: an index has 4");
  const uint64_t count = bytes / sizeof(uint32_t);
  if (count > mesh.vertex_count)
    throw InvalidInput(name, name + " names " + text(count) + " vertices, the mesh has " + text(mesh.vertex_count));
  return count;
}

void check_update(const SceneSpec& spec, const MeshPositions& update, const std::string& field) {
  if (update.mesh >= spec.meshes.size())
    throw InvalidInput(field + ".mesh", field + ".mesh is " + text(update.mesh) + ", the scene has " +
                                            text(spec.meshes.size()) + " meshes");
  const MeshSpec& mesh = spec.meshes[update.mesh];
  const uint64_t count = checked_count(mesh, update, field);
  const std::string of = update.is_sparse ? " that indices names" : " of mesh " + text(update.mesh);
  check_bytes(field + ".end", update.end, count, spec.scalar, of);
  if (update.start.empty()) return;
  if (spec.mode == Mode::kDcd) throw InvalidInput(field + ".start", field + ".start is given, but the scene is DCD");
  if (mesh.motion == MeshMotion::kStatic)
    throw InvalidInput(field + ".start", field + ".start is given, but the mesh is static");
  check_bytes(field + ".start", update.start, count, spec.scalar, of);
}

}  // namespace

void check_updates(const SceneSpec& spec, const std::vector<MeshPositions>& updates) {
  std::vector<bool> named(spec.meshes.size(), false);
  for (size_t i = 0; i < updates.size(); ++i) {
    const std::string field = name_of(i);
    check_update(spec, updates[i], field);
    if (named[updates[i].mesh])
      throw InvalidInput(field + ".mesh", field + ".mesh " + text(updates[i].mesh) + " comes twice in the frame");
    named[updates[i].mesh] = true;
  }
}

void check_turn(const SceneSpec& spec, const std::vector<SentMesh>& meshes, bool first) {
  std::vector<bool> named(spec.meshes.size(), false);
  for (size_t i = 0; i < meshes.size(); ++i) {
    const uint32_t mesh = meshes[i].mesh;
    if (!first && spec.meshes[mesh].motion == MeshMotion::kStatic)
      throw InvalidInput(name_of(i) + ".mesh",
                         name_of(i) + ".mesh " + text(mesh) +
                             " is static: its positions come with the first frame alone. Leave it out of later frames, "
                             "or create the scene with a deformable mesh");
    if (first && meshes[i].is_sparse)
      throw InvalidInput(name_of(i) + ".indices", name_of(i) + ".indices are given for mesh " + text(mesh) +
                                                      ", whose first positions must be those of all vertices");
    named[mesh] = true;
  }
  for (size_t mesh = 0; first && mesh < named.size(); ++mesh)
    if (!named[mesh])
      throw InvalidInput("updates",
                         "updates: the first frame must name every mesh, mesh " + text(mesh) + " is missing");
}

void refuse_index(const UpdatePlace& place, uint32_t index, uint32_t vertex_count) {
  const std::string field = name_of(place.update) + ".indices";
  throw InvalidInput(field, field + ": entry " + text(place.position) + " is " + text(index) + "; entries for mesh " +
                                text(place.mesh) + " must be above the one before and below " + text(vertex_count));
}

void refuse_coordinate(const UpdatePlace& place, bool is_end, const BadCoordinate& bad) {
  const std::string field = name_of(place.update) + (is_end ? ".end" : ".start");
  throw InvalidInput(field, field + ": mesh " + text(place.mesh) + ", vertex " + text(bad.vertex) + ", coordinate " +
                                "xyz"[bad.coordinate] + " is " + text(bad.value) + "; it must be finite and at most " +
                                text(bad.limit) + " in magnitude");
}

}  // namespace collided
