#include "tests/integration/model/scene_model.hpp"

#include <algorithm>

namespace collided::test {
namespace {

Positions moved(const Positions& rest, const std::array<double, 12>& m) {
  Positions moved = rest;
  for (size_t v = 0; v < rest.size(); ++v)
    for (size_t k = 0; k < 3; ++k)
      moved[v][k] = m[4 * k] * rest[v][0] + m[4 * k + 1] * rest[v][1] + m[4 * k + 2] * rest[v][2] + m[4 * k + 3];
  return moved;
}

/// The positions that an update brings, where the mesh has `before`.
Positions merged(const ModelUpdate& update, const Positions& brought, const Positions& before) {
  if (!update.sparse) return brought;
  Positions all = before;
  for (size_t i = 0; i < update.sparse->size(); ++i) all[(*update.sparse)[i]] = brought[i];
  return all;
}

bool share_a_vertex(const std::array<uint32_t, 4>& v, bool edges) {
  return v[0] == v[2] || v[0] == v[3] || v[1] == v[2] || (edges ? v[1] == v[3] : v[0] == v[1]);
}

}  // namespace

std::vector<Positions> point_of(const Way& way, double fraction) {
  if (fraction == 0) return way.from;
  std::vector<Positions> point = way.to;
  if (fraction == 1) return point;
  for (size_t m = 0; m < point.size(); ++m)
    for (size_t v = 0; v < point[m].size(); ++v)
      for (size_t k = 0; k < 3; ++k) {
        const double x = way.from[m][v][k], p = way.to[m][v][k];
        point[m][v][k] = static_cast<float>(x + fraction * (p - x));
      }
  return point;
}

SceneModel SceneModel::edited(const ModelFrame& frame) const {
  SceneModel after = *this;
  for (const ModelEdit& edit : frame.edits) {
    const size_t count = std::max<size_t>(after.meshes_.size(), edit.mesh + 1);
    after.meshes_.resize(count);
    after.now_.resize(count);
    after.rest_.resize(count);
    ModelMesh& mesh = after.meshes_[edit.mesh];
    const bool moves_alike = mesh.vertex_count == edit.as.vertex_count && mesh.motion == edit.as.motion;
    mesh = edit.as;
    if (!moves_alike) after.now_[edit.mesh].clear(), after.rest_[edit.mesh].clear();
  }
  if (!frame.edits.empty()) ++after.edit_count_, after.last_way_.reset();
  return after;
}

Way SceneModel::way_of(const ModelFrame& frame) const {
  Way way{now_, now_};
  if (frame.from_last) way.from = way.to = test::point_of(*last_way_, *frame.from_last);
  for (const ModelUpdate& update : frame.updates) {
    Positions &from = way.from[update.mesh], &to = way.to[update.mesh];
    const bool is_first = from.empty();
    const Positions before = from;
    if (update.matrix) {
      const Positions& rest = update.end.empty() ? rest_[update.mesh] : update.end;
      to = moved(rest, *update.matrix);
    } else {
      to = merged(update, update.end, before);
    }
    if (is_first) from = to;
    if (update.start) from = merged(update, *update.start, before);
  }
  return way;
}

void SceneModel::take_rest(const ModelUpdate& update) {
  if (meshes_[update.mesh].motion == MeshMotion::kRigid && !update.end.empty()) rest_[update.mesh] = update.end;
}

void SceneModel::apply(const ModelFrame& frame, const Way& way, double advanced) {
  const Way gone{way.from, test::point_of(way, advanced)};
  if (!frame.discrete) last_way_ = gone;
  if (frame.trial) return;
  for (const ModelUpdate& update : frame.updates) take_rest(update);
  last_frame_id_ = frame.id;
  now_ = gone.to;
}

bool SceneModel::may_touch(uint32_t mesh, uint32_t other) const {
  const auto motion = [&](uint32_t m) { return meshes_[m].motion; };
  if (mesh == other) return motion(mesh) == MeshMotion::kDeformable;
  return motion(mesh) != MeshMotion::kStatic || motion(other) != MeshMotion::kStatic;
}

Case SceneModel::case_of(const Way& way) const {
  Case c;
  for (const ModelMesh& mesh : meshes_)
    c.meshes.push_back({.vertex_count = mesh.vertex_count, .triangles = mesh.triangles, .motion = mesh.motion});
  c.start = way.from;
  c.end = way.to;
  return c;
}

template <class Take>
void SceneModel::each_pair(const Way& way, const Take& take) const {
  const CaseQueries queries(case_of(way));
  const Features& features = queries.features();
  const VertexTrianglePairs vertex_triangle(features);
  const auto put = [&](QueryKind kind, uint32_t first, uint32_t second) {
    const auto vertices = queries.vertices_of(kind, key_of(first, second));
    const auto mesh_of = [&](int i) { return features.mesh_of_vertex[vertices[i]]; };
    if (share_a_vertex(vertices, kind == QueryKind::kEdgeEdge) || !may_touch(mesh_of(0), mesh_of(2))) return;
    take(kind, queries.of_vertices(kind, vertices), key_of(first, second));
  };
  for (uint32_t v = 0; v < features.mesh_of_vertex.size(); ++v)
    for (uint32_t t = 0; t < features.triangles.size(); ++t)
      if (vertex_triangle.has(v, t)) put(QueryKind::kVertexTriangle, v, t);
  for (uint32_t e = 0; e < features.edges.size(); ++e)
    for (uint32_t f = e + 1; f < features.edges.size(); ++f) put(QueryKind::kEdgeEdge, e, f);
}

ModelContacts SceneModel::contacts(const Way& way, bool discrete) const {
  ModelContacts found;
  each_pair(way, [&](QueryKind kind, const Query& q, PairKey key) {
    ContactTimes& of_kind = kind == QueryKind::kEdgeEdge ? found.edge_edge : found.vertex_triangle;
    if (discrete) {
      if (judge_proximity(kind, {q.p[4], q.p[5], q.p[6], q.p[7]}, thickness_)) of_kind[key] = 1;
    } else if (const ExactImpact impact = judge_ccd(q, thickness_); impact.hit) {
      of_kind[key] = impact.upper.get_d() + 0x1p-52;  // get_d() cuts off
    }
  });
  return found;
}

bool SceneModel::starts_apart(const Way& way) const {
  bool is_apart = true;
  each_pair(way, [&](QueryKind kind, const Query& q, PairKey) {
    is_apart = is_apart && !judge_proximity(kind, {q.p[0], q.p[1], q.p[2], q.p[3]}, thickness_);
  });
  return is_apart;
}
bool SceneModel::meets(const Way& way, double distance) const {
  bool any = false;
  each_pair(way, [&](QueryKind kind, const Query& q, PairKey) {
    any = any || (!judge_proximity(kind, {q.p[0], q.p[1], q.p[2], q.p[3]}, distance) && judge_ccd(q, distance).hit);
  });
  return any;
}

uint64_t SceneModel::vertex_count() const {
  uint64_t count = 0;
  for (const ModelMesh& mesh : meshes_) count += mesh.vertex_count;
  return count;
}
uint64_t SceneModel::triangle_count() const {
  uint64_t count = 0;
  for (const ModelMesh& mesh : meshes_) count += mesh.triangles.size();
  return count;
}
uint64_t SceneModel::edge_count() const {
  Way still;
  for (const ModelMesh& mesh : meshes_) still.from.emplace_back(mesh.vertex_count);
  still.to = still.from;
  return CaseQueries(case_of(still)).features().edges.size();
}

}  // namespace collided::test
