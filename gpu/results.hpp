#pragma once
// From a step that is over to the frame's result on the host: download, exact decisions, what the report wants.

#include <algorithm>
#include <vector>

#include "gpu/contact_sets.hpp"
#include "gpu/level_needs.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/scene_buffers.hpp"

namespace collided {

template <class Exec, class Real>
class Results {
 public:
  Results(Exec& exec, const SceneSpec& spec, const FeatureRanks& ranks, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), spec_(spec), ranks_(ranks), scene_(scene) {}

  void collect(const StepState& step, const LevelNeeds& needs, FrameResult& result) {
    needs_ = needs;
    result_ = &result;
    if (needs_.is_any_hit() && (!needs_.is_exact() || step.shortcut.has_contact != 0)) {
      result.any_contact = step.shortcut.has_contact != 0;
      return;
    }
    exec_.stage("download", [&] { download(needs_.is_earliest_only() ? step.earliest : step.contacts); });
    if (needs_.is_exact()) exec_.stage("exact", [&] { settle_all(); });
    report();
  }

 private:
  void download(uint64_t count) {
    const uint64_t key_bytes = count * sizeof(uint64_t),
                   data_bytes = needs_.has_data() ? count * sizeof(ContactData<Real>) : 0;
    std::byte* host = exec_.host_memory(key_bytes + data_bytes);
    exec_.download_async(host, scene_.order.sorted_keys.data(), key_bytes);
    exec_.download_async(host + key_bytes, scene_.sorted.data(), data_bytes);
    exec_.wait();
    const auto* keys = reinterpret_cast<const uint64_t*>(host);
    const auto* data = reinterpret_cast<const ContactData<Real>*>(host + key_bytes);
    const auto below = [&](uint32_t rank) {
      return static_cast<uint64_t>(std::lower_bound(keys, keys + count, uint64_t{rank} << 32) - keys);
    };
    const uint64_t edges = below(ranks_.first_edge);
    const uint64_t triangles = spec_.triangle_triangle ? below(ranks_.first_triangle) : count;
    take(result_->vertex_triangle, keys, data, 0, edges, 0);
    take(result_->edge_edge, keys, data, edges, triangles, ranks_.first_edge);
    take(result_->triangle_triangle, keys, data, triangles, count, ranks_.first_triangle);
  }

  void take(ContactSet& out, const uint64_t* keys, const ContactData<Real>* data, uint64_t from, uint64_t to,
            uint32_t first_rank) {
    const uint64_t n = to - from;
    out.elements.resize(n);
    for (uint64_t i = 0; i < n; ++i)
      out.elements[i] = {first_id(keys[from + i]) - first_rank, second_id(keys[from + i])};
    const bool is_triangles = &out == &result_->triangle_triangle;
    if (is_triangles ? !needs_.tests_triangles() : !needs_.has_narrow_phase()) return;
    out.flags.resize(n);
    for (uint64_t i = 0; i < n; ++i) out.flags[i] = data[from + i].flags;
    if (is_triangles) return;
    out.distance.resize(n);
    for (uint64_t i = 0; i < n; ++i) out.distance[i] = data[from + i].distance;
    if (needs_.is_ccd) {
      out.toi.resize(n);
      for (uint64_t i = 0; i < n; ++i) out.toi[i] = data[from + i].toi;
    }
    if (!spec_.weights) return;
    out.weights.resize(n);
    for (uint64_t i = 0; i < n; ++i) out.weights[i] = {data[from + i].w0, data[from + i].w1};
  }

  // EXACT: what is left open goes to the host's exact arithmetic.
  void settle_all() {
    settle(result_->vertex_triangle, [&](const auto& keys) {
      return decide_features(VertexTriangle{scene_.topology.triangles.all()}, true, keys);
    });
    settle(result_->edge_edge,
           [&](const auto& keys) { return decide_features(EdgeEdge{scene_.topology.edges.all()}, false, keys); });
    settle(result_->triangle_triangle, [&](const auto& keys) { return decide_triangles(keys); });
  }
  template <class Decide>
  void settle(ContactSet& set, const Decide& decide) {
    if (needs_.is_any_hit() && result_->any_contact) return;
    const std::vector<size_t> places = undecided(set);
    result_->counts.exact_decisions += places.size();
    if (!places.empty()) {
      std::vector<uint64_t> keys;
      for (const size_t i : places) keys.push_back(pack_ids(set.elements[i][0], set.elements[i][1]));
      apply(set, places, decide(keys));
    }
    result_->any_contact = result_->any_contact || set.size() > 0;
  }

  template <class Kind>
  std::vector<ExactAnswer> decide_features(const Kind& kind, bool vertex_triangle, const std::vector<uint64_t>& keys) {
    const auto points = gather<8>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      exec_.for_each("gather_points", keys.size(),
                     GatherPoints<Real, Kind>{scene_.positions_at_start(), scene_.end.data(), kind, resident, out});
    });
    return decide_exactly(question(vertex_triangle), points);
  }
  std::vector<ExactAnswer> decide_triangles(const std::vector<uint64_t>& keys) {
    const auto corners = gather<6>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      exec_.for_each("gather_corners", keys.size(),
                     GatherCorners<Real>{scene_.end.data(), scene_.topology.triangles.all(), resident, out});
    });
    return decide_triangles_exactly(question(false), corners);
  }
  ExactQuestion question(bool vertex_triangle) const {
    return {vertex_triangle, needs_.is_ccd, spec_.thickness, spec_.threads, exec_.cancelled};
  }

  /// Brings the points of some pairs, n each, to the host.
  template <size_t n, class Run>
  std::vector<std::array<Vec3<double>, n>> gather(const std::vector<uint64_t>& keys, const Run& run) {
    scene_.exact_keys.ensure(keys.size());
    scene_.exact_points.ensure(n * keys.size());
    exec_.upload(scene_.exact_keys.data(), keys.data(), keys.size() * sizeof(uint64_t));
    run(scene_.exact_keys.span(keys.size()), scene_.exact_points.span(n * keys.size()));
    std::vector<Vec3<Real>> host(n * keys.size());
    exec_.download(host.data(), scene_.exact_points.data(), host.size() * sizeof(Vec3<Real>));
    std::vector<std::array<Vec3<double>, n>> out(keys.size());
    for (size_t i = 0; i < host.size(); ++i) out[i / n][i % n] = convert<double>(host[i]);
    return out;
  }

  void report() {
    FrameResult& r = *result_;
    const uint64_t features = r.vertex_triangle.size() + r.edge_edge.size();
    if (needs_.has_narrow_phase())
      r.counts.contacts_vt = r.vertex_triangle.size(), r.counts.contacts_ee = r.edge_edge.size();
    if (needs_.tests_triangles()) r.counts.contacts_tt = r.triangle_triangle.size();
    r.any_contact = r.counts.contacts_tt > 0 || (needs_.has_narrow_phase() && features > 0);
    if (needs_.is_earliest_only()) keep_earliest(r);
    if (needs_.is_any_hit()) {
      r.vertex_triangle = r.edge_edge = r.triangle_triangle = {};
      return;
    }
    r.earliest_toi = std::min(earliest_toi(r.vertex_triangle), earliest_toi(r.edge_edge));
  }

  Exec& exec_;
  const SceneSpec& spec_;
  const FeatureRanks& ranks_;
  SceneBuffers<Exec, Real>& scene_;
  LevelNeeds needs_;
  FrameResult* result_ = nullptr;
};

}  // namespace collided
