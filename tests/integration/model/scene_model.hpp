#pragma once
// What a scene is and answers, one frame after the other, by the definitions: no code of the engine, every pair of
// features put to the exact judge.

#include <map>
#include <optional>

#include "tests/support/case_queries.hpp"

namespace collided::test {

using Corners = std::array<uint32_t, 3>;

struct ModelMesh {
  MeshMotion motion = MeshMotion::kDeformable;
  uint32_t vertex_count = 0;  ///< 0: removed
  std::vector<Corners> triangles;
};

/// New positions of a mesh, as a client means them.
struct ModelUpdate {
  uint32_t mesh = 0;
  std::optional<std::vector<uint32_t>> sparse;
  std::optional<std::array<double, 12>> matrix;  ///< of a rigid mesh, beside its positions in its first frame
  std::optional<Positions> start;
  Positions end;
};

struct ModelEdit {
  uint32_t mesh = 0;
  ModelMesh as;  ///< without vertices: it is removed
};

struct ModelFrame {
  uint64_t id = 0;
  bool discrete = false;
  bool trial = false, advance = false;
  std::optional<double> from_last;
  std::vector<ModelUpdate> updates;
  std::vector<ModelEdit> edits;
};

/// Where the vertices of each mesh begin and end.
struct Way {
  std::vector<Positions> from, to;
};

/// The contacts, and a time of each that is no earlier than the true one.
using ContactTimes = std::map<PairKey, double>;
struct ModelContacts {
  ContactTimes vertex_triangle, edge_edge;
};

class SceneModel {
 public:
  SceneModel(std::vector<ModelMesh> meshes, double thickness) : thickness_(thickness), meshes_(std::move(meshes)) {
    now_.resize(meshes_.size());
    rest_.resize(meshes_.size());
  }

  const std::vector<ModelMesh>& meshes() const { return meshes_; }
  uint64_t last_frame_id() const { return last_frame_id_; }
  uint64_t edit_count() const { return edit_count_; }
  bool had_a_frame() const { return last_frame_id_ > 0; }
  bool has_way() const { return last_way_.has_value(); }
  /// Whether the mesh awaits its first positions.
  bool awaits(uint32_t mesh) const { return now_[mesh].empty(); }

  /// The scene as the frame's edit leaves it.
  SceneModel edited(const ModelFrame& frame) const;
  /// Of an edited scene.
  Way way_of(const ModelFrame& frame) const;
  ModelContacts contacts(const Way& way, bool discrete) const;
  double thickness() const { return thickness_; }
  /// Whether no two features are within the thickness at the start.
  bool starts_apart(const Way& way) const;
  /// Whether any two features that are not within a distance at the start come within it.
  bool meets(const Way& way, double distance) const;
  /// The frame was answered; `advanced`: how far the scene went.
  void apply(const ModelFrame& frame, const Way& way, double advanced = 1);
  /// The frame was refused.
  void refuse() { last_way_.reset(); }

  uint64_t vertex_count() const;
  uint64_t triangle_count() const;
  uint64_t edge_count() const;

 private:
  void take_rest(const ModelUpdate& update);
  bool may_touch(uint32_t mesh, uint32_t other) const;
  Case case_of(const Way& way) const;
  /// The pairs that are tested, to `take`(kind, query, key).
  template <class Take>
  void each_pair(const Way& way, const Take& take) const;

  double thickness_;
  std::vector<ModelMesh> meshes_;
  std::vector<Positions> now_, rest_;  ///< empty: none yet
  uint64_t last_frame_id_ = 0, edit_count_ = 0;
  std::optional<Way> last_way_;
};

/// A point of a way, by the formula of client/STEPPING.md for F32.
std::vector<Positions> point_of(const Way& way, double fraction);

}  // namespace collided::test
