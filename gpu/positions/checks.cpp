#include "gpu/positions/checks.hpp"

#include <cmath>
#include <cstring>

#include "gpu/base/text.hpp"
#include "gpu/positions/format.hpp"

namespace collided {
namespace {

std::string name_of(size_t update) { return "updates[" + text(update) + "]"; }
const MeshSpec& mesh_of(const SceneSpec& spec, uint32_t mesh) { return spec.meshes[mesh % spec.meshes.size()]; }

/// `of`: the vertices, in words.
void check_bytes(const std::string& field, std::span<const std::byte> bytes, uint64_t vertices, const SceneSpec& spec,
                 const std::string& of) {
  const uint64_t want = vertices * position_bytes(spec);
  if (bytes.size() == want) return;
  const std::string format = spec.quantized_in ? "Q16" : name_of(spec.scalar);
  std::string what = field + " has " + text(bytes.size()) + " bytes; " + format + " positions of " + text(vertices) +
                     " vertices" + of + " are " + text(want);
  for (const Scalar other : {Scalar::kF32, Scalar::kF64})
    if (bytes.size() == vertices * position_bytes(other))
      what +=
          "; " + text(bytes.size()) + " is what " + name_of(other) + " positions take, and the scene is of " + format;
  throw InvalidInput(field, what);
}

// A rigid motion.

constexpr double kMaxDefect = 1e-4;           ///< what single-precision rotations have is a thousandth of it
constexpr double kOfPosesOnTheWay = 0x1p-40;  ///< what pose_along() may add

Pose pose_of(std::span<const std::byte> bytes) {
  Pose pose;
  std::memcpy(pose.rows.data(), bytes.data(), sizeof(pose.rows));
  return pose;
}

void check_pose(const std::string& field, std::span<const std::byte> bytes) {
  if (bytes.size() != sizeof(Pose::rows))
    throw InvalidInput(field, field + " has " + text(bytes.size()) + " bytes; the rows of [R | t] are 12 float64, " +
                                  text(sizeof(Pose::rows)) + " bytes");
  const Pose pose = pose_of(bytes);
  for (size_t i = 0; i < pose.rows.size(); ++i)
    if (!std::isfinite(pose.rows[i]))
      throw InvalidInput(field, field + ": entry " + text(i) + " is " + text(pose.rows[i]) + "; it must be finite");
  if (const double defect = rotation_defect(pose); !(defect <= kMaxDefect + kOfPosesOnTheWay))
    throw InvalidInput(field, field + ": R is no rotation: R^T R is " + text(defect) + " from I, which may be " +
                                  text(kMaxDefect) + " at most");
  if (!(determinant(pose) > 0)) throw InvalidInput(field, field + ": R is a reflection: its determinant is -1, not 1");
}

void check_transforms(const SceneSpec& spec, const MeshPositions& update, const std::string& field) {
  const std::string of = "; " + name_of_mesh(spec, update.mesh) + " is not rigid";
  const bool is_rigid = mesh_of(spec, update.mesh).motion == MeshMotion::kRigid;
  if (!is_rigid && !update.transform.empty())
    throw InvalidInput(field + ".transform", field + ".transform is given" + of);
  if (!is_rigid && !update.start_transform.empty())
    throw InvalidInput(field + ".start_transform", field + ".start_transform is given" + of);
  if (!update.transform.empty()) check_pose(field + ".transform", update.transform);
  if (update.start_transform.empty()) return;
  if (spec.mode == Mode::kDcd)
    throw InvalidInput(field + ".start_transform", field + ".start_transform is given, but the scene is DCD");
  if (update.transform.empty())
    throw InvalidInput(field + ".start_transform", field + ".start_transform is given without a transform at t = 1");
  check_pose(field + ".start_transform", update.start_transform);
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

/// Whether it fits for sure: as most updates, which then cost no words.
bool fits_plainly(const SceneSpec& spec, const MeshPositions& update) {
  if (update.mesh >= spec.meshes.size() * count_worlds(spec)) return false;
  const MeshSpec& mesh = mesh_of(spec, update.mesh);
  const uint64_t bytes = mesh.vertex_count * position_bytes(spec);
  return mesh.motion == MeshMotion::kDeformable && bytes > 0 && update.end.size() == bytes && !update.is_sparse &&
         update.indices.empty() && update.transform.empty() && update.start_transform.empty() &&
         (update.start.empty() || (spec.mode != Mode::kDcd && update.start.size() == bytes));
}

void check_update(const SceneSpec& spec, const MeshPositions& update, const std::string& field) {
  if (update.mesh >= spec.meshes.size() * count_worlds(spec))
    throw InvalidInput(field + ".mesh", field + ".mesh is " + text(update.mesh) + ", the scene has " +
                                            text(spec.meshes.size() * count_worlds(spec)) + " meshes");
  const MeshSpec& mesh = mesh_of(spec, update.mesh);
  if (mesh.vertex_count == 0)
    throw InvalidInput(field + ".mesh", field + ".mesh is " + text(update.mesh) + ", which was removed");
  check_transforms(spec, update, field);
  if (mesh.motion == MeshMotion::kRigid && update.is_sparse)
    throw InvalidInput(field + ".indices",
                       field + ".indices are given, but mesh " + text(update.mesh) + " is rigid and moves as a whole");
  if (mesh.motion == MeshMotion::kRigid && update.end.empty() && update.start.empty()) return;
  const uint64_t count = checked_count(mesh, update, field);
  const std::string of = update.is_sparse ? " that indices names" : " of " + name_of_mesh(spec, update.mesh);
  check_bytes(field + ".end", update.end, count, spec, of);
  if (update.start.empty()) return;
  if (spec.mode == Mode::kDcd) throw InvalidInput(field + ".start", field + ".start is given, but the scene is DCD");
  if (mesh.motion == MeshMotion::kStatic)
    throw InvalidInput(field + ".start", field + ".start is given, but the mesh is static");
  if (mesh.motion == MeshMotion::kRigid)
    throw InvalidInput(field + ".start", field +
                                             ".start is given, but the mesh is rigid: start_transform says where it "
                                             "begins");
  check_bytes(field + ".start", update.start, count, spec, of);
}

}  // namespace

std::string name_of_mesh(const SceneSpec& spec, uint32_t mesh) {
  if (spec.worlds == 0) return "mesh " + text(mesh);
  return "world " + text(mesh / spec.meshes.size()) + ", mesh " + text(mesh % spec.meshes.size());
}

void check_updates(const SceneSpec& spec, const std::vector<MeshPositions>& updates) {
  std::vector<bool> named(spec.meshes.size() * count_worlds(spec), false);
  for (size_t i = 0; i < updates.size(); ++i) {
    if (!fits_plainly(spec, updates[i])) check_update(spec, updates[i], name_of(i));
    if (named[updates[i].mesh])
      throw InvalidInput(name_of(i) + ".mesh",
                         name_of(i) + ".mesh " + text(updates[i].mesh) + " comes twice in the frame");
    named[updates[i].mesh] = true;
  }
}

namespace {

/// Positions come with the first frame alone, transforms with every other.
void check_rigid_turn(const std::string& field, const SentMesh& sent, bool first) {
  if (first && !sent.has_positions)
    throw InvalidInput(field + ".end", field + ".end is empty, but mesh " + text(sent.mesh) +
                                           " is rigid, and its first frame brings the positions that are transformed");
  if (!first && sent.has_positions)
    throw InvalidInput(field + ".end", field + ".end is given, but mesh " + text(sent.mesh) +
                                           " is rigid: its positions come with its first frame alone, and later frames "
                                           "bring transforms");
  if (!first && !sent.has_transform)
    throw InvalidInput(field + ".transform", field + ".transform is empty; leave mesh " + text(sent.mesh) +
                                                 " out of the frame if it does not move");
}

}  // namespace

std::vector<RigidMove> moves_of(const std::vector<MeshPositions>& updates) {
  std::vector<RigidMove> moves;
  for (size_t i = 0; i < updates.size(); ++i) {
    if (updates[i].transform.empty()) continue;
    moves.push_back({i, updates[i].mesh, {}, pose_of(updates[i].transform)});
    if (!updates[i].start_transform.empty()) moves.back().start = pose_of(updates[i].start_transform);
  }
  return moves;
}

void check_turn(const SceneSpec& spec, const std::vector<SentMesh>& meshes, const FirstMeshes& first) {
  std::vector<bool> named(spec.meshes.size(), false);
  for (size_t i = 0; i < meshes.size(); ++i) {
    const uint32_t mesh = meshes[i].mesh;
    if (!first[mesh] && spec.meshes[mesh].motion == MeshMotion::kStatic)
      throw InvalidInput(name_of(i) + ".mesh",
                         name_of(i) + ".mesh " + text(mesh) +
                             " is static: its positions come with its first frame alone. Leave it out of later frames, "
                             "or create the scene with a deformable mesh");
    if (spec.meshes[mesh].motion == MeshMotion::kRigid) check_rigid_turn(name_of(i), meshes[i], first[mesh]);
    if (first[mesh] && meshes[i].is_sparse)
      throw InvalidInput(name_of(i) + ".indices", name_of(i) + ".indices are given for mesh " + text(mesh) +
                                                      ", whose first positions must be those of all vertices");
    named[mesh] = true;
  }
  for (size_t mesh = 0; mesh < named.size(); ++mesh)
    if (first[mesh] && !named[mesh])
      throw InvalidInput("updates",
                         "updates: a mesh's first frame must have its positions, mesh " + text(mesh) + " is missing");
}

void refuse_index(const UpdatePlace& place, uint32_t index, uint32_t vertex_count) {
  const std::string field = name_of(place.update) + ".indices";
  throw InvalidInput(field, field + ": entry " + text(place.position) + " is " + text(index) + "; entries for " +
                                place.mesh + " must be above the one before and below " + text(vertex_count));
}

void refuse_coordinate(const UpdatePlace& place, bool is_end, const BadCoordinate& bad) {
  const std::string field = name_of(place.update) + (is_end ? ".end" : ".start");
  throw InvalidInput(field, field + ": " + place.mesh + ", vertex " + text(bad.vertex) + ", coordinate " +
                                "xyz"[bad.coordinate] + " is " + text(bad.value) + "; it must be finite and at most " +
                                text(bad.limit) + " in magnitude");
}

}  // namespace collided
