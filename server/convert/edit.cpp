// Edits of a scene from the protocol to the engine.
#include "server/convert/edit.hpp"

#include <algorithm>
#include <string>

#include "server/convert/meshes.hpp"
#include "server/convert/wire_bounds.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

std::string path_of(int index) { return fmt::format("frame.edit.meshes[{}]", index); }

// Elements come with the edit, all of them.
void check_triangle_count(const pb::MeshSpec& mesh, size_t triangles, const std::string& path) {
  if (mesh.triangle_count() > 0 && mesh.triangle_count() != triangles)
    throw_invalid(path + ".triangle_count",
                  fmt::format("is {}, but {}.triangles has {}: UploadMesh is for new scenes alone",
                              mesh.triangle_count(), path, triangles));
}

MeshEdit parse_mesh_edit(const pb::MeshEdit& edit, const std::string& path) {
  MeshEdit out{edit.mesh(), {}};
  if (!edit.has_spec()) return out;
  if (!edit.spec().name().empty()) check_mesh_name(edit.spec().name(), path + ".spec.name");
  out.spec = parse_mesh(edit.spec(), path + ".spec");
  check_triangle_count(edit.spec(), out.spec.triangles.size(), path + ".spec");
  return out;
}

/// What the scene will be, as far as names and numbers go; the engine decides about the rest.
class Outcome {
 public:
  explicit Outcome(const ScenePlan& plan) {
    for (size_t i = 0; i < plan.meshes.size(); ++i)
      meshes_.push_back({plan.meshes[i].name, plan.engine.meshes[i].vertex_count, plan.meshes[i].triangles,
                         plan.meshes[i].edges + plan.meshes[i].points});
  }

  void take(const pb::MeshEdit& edit, const MeshEdit& parsed, const std::string& path) {
    if (edit.mesh() > meshes_.size())
      throw_invalid(path + ".mesh", fmt::format("is {}, but the scene has {} meshes, and one more is added as {}",
                                                edit.mesh(), meshes_.size(), meshes_.size()));
    if (edit.mesh() == meshes_.size()) meshes_.emplace_back();
    Mesh& mesh = meshes_[edit.mesh()];
    if (!edit.has_spec()) {
      mesh = {};
      return;
    }
    if (!edit.spec().name().empty()) mesh.name = edit.spec().name();
    if (mesh.name.empty()) throw_invalid(path + ".spec.name", "is empty, but a new mesh needs a name");
    mesh.vertices = parsed.spec.vertex_count;
    if (count_elements(parsed.spec) == 0) return;
    mesh.triangles = parsed.spec.triangles.size();
    mesh.loose = parsed.spec.edges.size() + parsed.spec.points.size();
  }

  void check(const pb::SceneEdit& edit, const Limits& limits) const {
    SceneSize size;
    for (const Mesh& mesh : meshes_)
      size.vertices += mesh.vertices, size.triangles += mesh.triangles, size.loose += mesh.loose;
    check_sizes(meshes_.size(), size, limits, "frame.edit.meshes");
    for (int i = 0; i < edit.meshes_size(); ++i) check_name(edit.meshes(i).mesh(), path_of(i));
  }

 private:
  struct Mesh {
    std::string name;
    uint64_t vertices = 0, triangles = 0, loose = 0;
  };

  void check_name(uint32_t edited, const std::string& path) const {
    const std::string& name = meshes_[edited].name;
    const auto has_name = [&](const Mesh& mesh) { return mesh.name == name; };
    if (!name.empty() && std::count_if(meshes_.begin(), meshes_.end(), has_name) > 1)
      throw_invalid(path + ".spec.name", fmt::format("is \"{}\", which another mesh already has", name));
  }

  std::vector<Mesh> meshes_;
};

EditedMesh edited_mesh(const pb::MeshEdit& edit, const MeshSpec& spec) {
  const bool keeps_elements = edit.has_spec() && count_elements(spec) == 0;
  return {edit.mesh(),           edit.spec().name(), keeps_elements,
          spec.triangles.size(), spec.edges.size(),  spec.points.size()};
}

std::vector<std::array<uint32_t, 2>> parse_pairs(const google::protobuf::RepeatedPtrField<pb::MeshPair>& pairs) {
  std::vector<std::array<uint32_t, 2>> out;
  for (const auto& pair : pairs) out.push_back({pair.first(), pair.second()});
  return out;
}

}  // namespace

uint64_t element_bytes(const pb::SceneEdit& edit) {
  uint64_t bytes = 0;
  for (const auto& mesh : edit.meshes())
    bytes += mesh.spec().triangles().size() + mesh.spec().edges().size() + mesh.spec().points().size();
  return bytes;
}

ParsedEdit parse_edit(const pb::SceneEdit& edit, const ScenePlan& plan, const Limits& limits) {
  if (edit.meshes_size() > static_cast<int>(kMaxEditedMeshes))
    throw LimitExceeded("frame.edit.meshes", fmt::format("frame.edit.meshes has {} entries, more than the limit of {}",
                                                         edit.meshes_size(), kMaxEditedMeshes));
  ParsedEdit out;
  SceneEdit engine;
  Outcome outcome(plan);
  for (int i = 0; i < edit.meshes_size(); ++i) {
    engine.meshes.push_back(parse_mesh_edit(edit.meshes(i), path_of(i)));
    outcome.take(edit.meshes(i), engine.meshes.back(), path_of(i));
    out.meshes.push_back(edited_mesh(edit.meshes(i), engine.meshes.back().spec));
  }
  outcome.check(edit, limits);
  engine.excluded = parse_pairs(edit.exclude_meshes());
  engine.included = parse_pairs(edit.include_meshes());
  out.engine = std::make_shared<const SceneEdit>(std::move(engine));
  return out;
}

}  // namespace collided::server
