#include "gpu/scene/edit.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "gpu/base/text.hpp"
#include "gpu/scene/rules.hpp"
#include "gpu/tables/exclusions.hpp"
#include "gpu/tables/solids.hpp"

namespace collided {
namespace {

using MeshPair = std::array<uint32_t, 2>;

bool is_removed(const MeshSpec& mesh) { return mesh.vertex_count == 0; }

/// Gives a mesh the elements that it has in the scene.
void fill_elements(const Topology& topology, size_t mesh, MeshSpec& out) {
  for (uint32_t i = topology.triangle_offset[mesh]; i < topology.triangle_offset[mesh + 1]; ++i) {
    auto corners = topology.triangles[i];
    for (uint32_t& vertex : corners) vertex -= topology.vertex_offset[mesh];
    if (corners[0] == corners[1])
      out.points.push_back(corners[0]);
    else if (corners[1] == corners[2])
      out.edges.push_back({corners[0], corners[1]});
    else
      out.triangles.push_back(corners);
  }
}

/// Takes an edit's changes, one after the other.
class Editor {
 public:
  explicit Editor(const SceneSpec& spec) {
    out_.spec = spec;
    out_.first.assign(spec.meshes.size(), false);
    out_.begins_at_rest.assign(spec.meshes.size(), false);
    out_.new_solids.assign(spec.meshes.size(), false);
    changed_.assign(spec.meshes.size(), false);
    needs_start_.assign(spec.meshes.size(), false);
  }

  void change_mesh(size_t i, const MeshEdit& edit) {
    const std::string field = "edit.meshes[" + text(i) + "]";
    std::vector<MeshSpec>& meshes = out_.spec.meshes;
    if (edit.mesh > meshes.size())
      throw InvalidInput(field + ".mesh", field + ".mesh is " + text(edit.mesh) + "; the scene has " +
                                              text(meshes.size()) + " meshes, and one more is added with that number");
    if (edit.mesh == meshes.size()) add_number();
    if (changed_[edit.mesh])
      throw InvalidInput(field + ".mesh", field + ".mesh is " + text(edit.mesh) + ", which the edit has twice");
    changed_[edit.mesh] = true;
    if (is_removed(edit.spec))
      remove(edit, field);
    else
      replace(edit, field);
  }

  void exclude(size_t i, const MeshPair& pair) {
    const std::string field = "edit.excluded[" + text(i) + "]";
    check_pair(field, pair);
    if (find(pair) != out_.spec.excluded_meshes.end())
      throw InvalidInput(field, field + " is " + name_of(pair) + ", which are excluded already");
    out_.spec.excluded_meshes.push_back(pair);
  }
  void include(size_t i, const MeshPair& pair) {
    const std::string field = "edit.included[" + text(i) + "]";
    check_pair(field, pair);
    const auto found = find(pair);
    if (found == out_.spec.excluded_meshes.end())
      throw InvalidInput(field, field + " is " + name_of(pair) + ", which are not excluded");
    out_.spec.excluded_meshes.erase(found);
  }

  /// `updates`: of the edit's frame.
  void see(const std::vector<MeshPositions>& updates, bool is_ccd) {
    for (size_t i = 0; i < updates.size(); ++i) {
      const uint32_t mesh = updates[i].mesh;
      if (mesh >= changed_.size() || !changed_[mesh]) continue;
      if (is_ccd && needs_start_[mesh] && updates[i].start.empty()) {
        const std::string field = "updates[" + text(i) + "].start";
        throw InvalidInput(field, field + " is empty, but with this frame mesh " + text(mesh) +
                                      " gets another number of vertices, and nothing tells where they begin");
      }
      const bool is_whole = !updates[i].end.empty() && !updates[i].is_sparse;
      if (is_whole && out_.spec.meshes[mesh].motion != MeshMotion::kDeformable) {
        out_.first[mesh] = out_.begins_at_rest[mesh] = true;
        out_.new_solids[mesh] = out_.spec.meshes[mesh].solid;
      }
    }
  }

  /// A mesh that could not touch itself before has no rest pairs yet.
  EditedScene finish(const SceneSpec& before, const Topology& topology, double rest_distance) {
    const std::vector<MeshRule> then = mesh_rules(before), now = mesh_rules(out_.spec);
    for (size_t mesh = 0; mesh < then.size(); ++mesh)
      if (then[mesh].has_self_contacts < now[mesh].has_self_contacts) out_.begins_at_rest[mesh] = true;
    if (rest_distance != 0) out_.spec.rest_distance = rest_distance;
    check_rest_distance(out_.spec);
    if (std::all_of(out_.spec.meshes.begin(), out_.spec.meshes.end(), is_removed))
      throw InvalidInput("edit.meshes", "edit.meshes leaves the scene without a mesh");
    check_new_solids(topology);
    for (size_t mesh = 0; out_.changes_features && mesh < out_.spec.meshes.size(); ++mesh)
      if (MeshSpec& kept = out_.spec.meshes[mesh]; !is_removed(kept) && count_elements(kept) == 0)
        fill_elements(topology, mesh, kept);
    return std::move(out_);
  }

 private:
  static std::string name_of(const MeshPair& pair) { return "meshes " + text(pair[0]) + " and " + text(pair[1]); }

  void add_number() {
    out_.spec.meshes.emplace_back();
    out_.first.push_back(false);
    out_.begins_at_rest.push_back(false);
    out_.new_solids.push_back(false);
    changed_.push_back(false);
    needs_start_.push_back(false);
  }

  void remove(const MeshEdit& edit, const std::string& field) {
    MeshSpec& mesh = out_.spec.meshes[edit.mesh];
    if (is_removed(mesh))
      throw InvalidInput(field, field + " removes mesh " + text(edit.mesh) + ", which the scene does not have");
    if (count_elements(edit.spec) != 0)
      throw InvalidInput(field + ".spec.vertex_count", field + ".spec.vertex_count is 0, but the mesh has elements");
    mesh = {};
    out_.changes_features = true;
    std::erase_if(out_.spec.excluded_meshes,
                  [&](const MeshPair& pair) { return pair[0] == edit.mesh || pair[1] == edit.mesh; });
  }

  void replace(const MeshEdit& edit, const std::string& field) {
    check_mesh(out_.spec, edit.spec, field + ".spec");
    MeshSpec& mesh = out_.spec.meshes[edit.mesh];
    const bool keeps_elements = count_elements(edit.spec) == 0;
    if (keeps_elements && edit.spec.vertex_count != mesh.vertex_count)
      throw InvalidInput(field + ".spec.triangles", field + ".spec.triangles is empty, and the mesh has " +
                                                        text(mesh.vertex_count) + " vertices, not " +
                                                        text(edit.spec.vertex_count) + ": its elements cannot stay");
    const bool moves = edit.spec.vertex_count != mesh.vertex_count || edit.spec.motion != mesh.motion;
    out_.first[edit.mesh] = moves;
    needs_start_[edit.mesh] =
        moves && !is_removed(mesh) && mesh.motion == edit.spec.motion && mesh.motion == MeshMotion::kDeformable;
    const bool has_own_distance = out_.spec.rest_distance == 0;
    const bool changes_distance = has_own_distance && edit.spec.half_thickness != mesh.half_thickness;
    out_.begins_at_rest[edit.mesh] = moves || !keeps_elements || !mesh.excludes_rest_pairs || changes_distance;
    out_.changes_features |= !keeps_elements;
    out_.new_solids[edit.mesh] = edit.spec.solid && (moves || !keeps_elements || !mesh.solid);
    mesh = edit.spec;
    fields_[edit.mesh] = field + ".spec";
  }
  void check_new_solids(const Topology& topology) const {
    for (const auto& [number, field] : fields_) {
      if (!out_.new_solids[number]) continue;
      MeshSpec mesh = out_.spec.meshes[number];
      if (count_elements(mesh) == 0) fill_elements(topology, number, mesh);
      check_solid(mesh, field);
    }
  }

  void check_pair(const std::string& field, const MeshPair& pair) const {
    for (const uint32_t mesh : pair)
      if (mesh >= out_.spec.meshes.size() || is_removed(out_.spec.meshes[mesh]))
        throw InvalidInput(field, field + " is " + name_of(pair) + ", but the scene has no mesh " + text(mesh));
  }
  std::vector<MeshPair>::iterator find(const MeshPair& pair) {
    return std::find_if(out_.spec.excluded_meshes.begin(), out_.spec.excluded_meshes.end(), [&](const MeshPair& other) {
      return std::minmax(pair[0], pair[1]) == std::minmax(other[0], other[1]);
    });
  }

  EditedScene out_;
  std::vector<bool> changed_, needs_start_;
  std::map<uint32_t, std::string> fields_;  ///< of meshes that are replaced, where the edit has them
};

}  // namespace

EditedScene edit_scene(const SceneSpec& spec, const Topology& topology, const FrameInput& frame, bool is_ccd) {
  const SceneEdit& edit = *frame.edit;
  Editor editor(spec);
  for (size_t i = 0; i < edit.meshes.size(); ++i) editor.change_mesh(i, edit.meshes[i]);
  for (size_t i = 0; i < edit.included.size(); ++i) editor.include(i, edit.included[i]);
  for (size_t i = 0; i < edit.excluded.size(); ++i) editor.exclude(i, edit.excluded[i]);
  editor.see(frame.updates, is_ccd);
  EditedScene edited = editor.finish(spec, topology, edit.rest_distance);
  check_distances(edited.spec, settings_of(edited.spec, frame));
  return edited;
}

}  // namespace collided
