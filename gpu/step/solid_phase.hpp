#pragma once
// Vertices in solids, after a step that has found the rest: a hierarchy over the solids' triangles, a ray from each
// vertex that may be in one, and the nearest triangle of each that is.

#include <algorithm>
#include <vector>

#include "gpu/engines/lbvh/lbvh_phase.hpp"
#include "gpu/exact/nearest.hpp"
#include "gpu/exact/poll.hpp"
#include "gpu/exact/rays.hpp"
#include "gpu/solids/gather.hpp"
#include "gpu/solids/nearest.hpp"
#include "gpu/state/level_needs.hpp"

namespace collided {

/// What the phase keeps on the backend.
template <Executor Exec, class Real>
struct SolidBuffers {
  explicit SolidBuffers(Exec& exec)
      : bounds(exec, kPart),
        boxes(exec, kPart),
        bvh(exec, kPart),
        top(exec, kPart),
        parts(exec, kPart),
        counts(exec, kPart),
        inside{{exec, kPart}, {exec, kPart}},
        doubtful(exec, kPart),
        open(exec, kPart),
        on(exec, kPart),
        rivals(exec, kPart),
        points(exec, kPart),
        columns(exec) {}

  Buffer<Box<Real>, Exec> bounds;  ///< of all solids
  Buffer<Box<float>, Exec> boxes;  ///< of each triangle
  BvhBuffers<Exec> bvh;
  Buffer<uint32_t, Exec> top;  ///< the root's left child
  Buffer<SolidPart, Exec> parts;
  Buffer<SolidCounts, Exec> counts;
  Buffer<uint64_t, Exec> inside[2];  ///< pairs of a vertex and a solid; the second is room to sort in
  Buffer<uint64_t, Exec> doubtful, open, on;
  Buffer<Rival, Exec> rivals;
  Buffer<Vec3<Real>, Exec> points;  ///< of rivals
  ColumnBuffers<Exec> columns;

 private:
  static constexpr const char* kPart = "solids";
};

template <Executor Exec, class Real>
class SolidPhase {
 public:
  SolidPhase(Exec& exec, const SceneSpec& spec, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), spec_(spec), scene_(scene), buffers_(exec) {}

  /// Finds all vertices in solids, and the triangles that are nearest to them. Nothing is found of these at kAnyHit.
  /// Returns how many there are.
  uint64_t find(const LevelNeeds& needs, FrameCounts& counts) {
    needs_ = needs;
    found_ = {};
    on_.clear();
    if (triangles().empty() || vertices().empty()) return 0;
    exec_.stage("inside", [&] {
      build();
      look();
      counts.exact_decisions += found_.doubtful;
      counts.inside_out = found_.inside_out;
    });
    if (!needs.is_any_hit()) exec_.stage("depths", [&] { counts.exact_decisions += find_depths(); });
    return found_.inside;
  }
  /// Vertices that are on solids, in any order (pack_ids: a vertex, a solid's number); of frames that tell states.
  const std::vector<uint64_t>& on() const { return on_; }
  /// Returns what was found, in canonical order, as contacts.
  ContactColumns columns() const { return buffers_.columns.columns(needs_.fields_of(ContactKind::kVertexSolid)); }

  /// Gives back what a scene of another size needed.
  void release() { buffers_ = SolidBuffers<Exec, Real>(exec_); }

 private:
  Span<const SolidTriangle> triangles() const { return scene_.topology.solid_triangles.all(); }
  Span<const MeshVertex> vertices() const { return scene_.topology.solid_vertices.all(); }
  const Vec3<Real>* positions() const { return scene_.end.data(); }
  Span<const uint32_t> first_places() const { return scene_.topology.solid_places.all(); }
  SolidTree<Real> tree() const {
    return {positions(), triangles(), buffers_.bvh.nodes.all(), buffers_.parts.all(), buffers_.top.data()};
  }

  void build() {
    const uint64_t count = triangles().size();
    buffers_.bounds.allocate(1);
    buffers_.boxes.allocate(count);
    buffers_.bvh.reserve(count, false);
    buffers_.top.allocate(1);
    buffers_.parts.allocate(first_places().size());
    const ExtentOfSolid<Real> extent{positions(), triangles()};
    exec_.reduce_into("bound_solids", count, extent, empty_box<Real>(), JoinBoxes{}, buffers_.bounds.data());
    const SolidKeyBits bits(count, first_places().size());
    const PlaceSolids<Real> place{extent,
                                  first_places(),
                                  buffers_.bounds.data(),
                                  bits,
                                  buffers_.boxes.all(),
                                  buffers_.bvh.keys[0].span(count),
                                  buffers_.bvh.triangles[0].span(count),
                                  buffers_.bvh.meeting.all()};
    exec_.for_each("place_solids", count, place);
    const int sorted = exec_.sort_pairs("sort_solids", bits.all(),
                                        {buffers_.bvh.keys[0].span(count), buffers_.bvh.keys[1].span(count),
                                         buffers_.bvh.triangles[0].span(count), buffers_.bvh.triangles[1].span(count)});
    const BvhSplits splits{buffers_.bvh.keys[sorted].all(), static_cast<uint32_t>(count)};
    exec_.for_each("join_solids", count,
                   BuildHierarchy{splits,
                                  buffers_.bvh.triangles[sorted].all(),
                                  buffers_.boxes.all(),
                                  buffers_.bvh.meeting.all(),
                                  buffers_.bvh.nodes.all(),
                                  {},
                                  {},
                                  buffers_.top.data()});
    exec_.for_each("find_parts", first_places().size(),
                   FindParts<Real>{place, splits, buffers_.bvh.nodes.all(), buffers_.top.data(), buffers_.parts.all()});
  }

  /// Fills inside_ in order.
  void look() {
    buffers_.counts.allocate(1);
    do {
      buffers_.inside[0].ensure(max(found_.inside, uint64_t{1}));
      buffers_.doubtful.ensure(max(found_.doubtful, uint64_t{1}));
      buffers_.open.ensure(max(found_.open, uint64_t{1}));
      buffers_.on.ensure(max(found_.on, uint64_t{1}));
      exec_.fill_zero(buffers_.counts.data(), sizeof(SolidCounts));
      const SolidLists lists = this->lists();
      exec_.for_each("find_inside", vertices().size(),
                     FindInside<Real>{tree(), vertices(), scene_.topology.filter(), lists});
      exec_.for_each("decide_inside", Counted{&buffers_.counts.data()->doubtful, buffers_.doubtful.capacity()},
                     DecideInside<Real>{tree(), buffers_.doubtful.all(), lists});
      exec_.download(&found_, buffers_.counts.data(), sizeof(found_));
    } while (found_.inside > buffers_.inside[0].capacity() || found_.doubtful > buffers_.doubtful.capacity() ||
             found_.open > buffers_.open.capacity() || found_.on > buffers_.on.capacity());
    bring_on();
    if (found_.open > 0) decide_open();
    sort();
  }
  SolidLists lists() const {
    SolidCounts* counts = buffers_.counts.data();
    return {{buffers_.inside[0].all(), &counts->inside},
            {buffers_.doubtful.all(), &counts->doubtful},
            {buffers_.open.all(), &counts->open},
            {buffers_.on.all(), &counts->on},
            &counts->inside_out};
  }
  void bring_on() {
    on_.resize(needs_.tells_states ? found_.on : 0);
    if (!on_.empty()) exec_.download(on_.data(), buffers_.on.data(), on_.size() * sizeof(on_[0]));
  }
  void sort() {
    const uint64_t count = found_.inside;
    sorted_ = 0;
    if (count == 0) return;
    buffers_.inside[1].ensure(count);
    const int bits = 32 + std::bit_width(std::max(scene_.topology.shape.vertices, 2u) - 1);
    sorted_ =
        exec_.sort_pairs("sort_inside", bits, {buffers_.inside[0].span(count), buffers_.inside[1].span(count), {}, {}});
  }

  /// The host decides where exponents are too far apart for numbers of fixed size.
  void decide_open() {
    std::vector<uint64_t> open(found_.open), inside(found_.inside);
    std::vector<Vec3<Real>> positions(scene_.topology.shape.vertices);
    MemoryHold held(spec_.memory_quota);
    held.resize((open.size() * 2 + inside.size()) * sizeof(uint64_t) + positions.size() * sizeof(positions[0]));
    exec_.download(open.data(), buffers_.open.data(), open.size() * sizeof(open[0]));
    exec_.download(inside.data(), buffers_.inside[0].data(), inside.size() * sizeof(inside[0]));
    exec_.download(positions.data(), this->positions(), positions.size() * sizeof(positions[0]));
    for (const uint64_t pair : open) {
      bool is_on = false;
      const int winding = winding_of(first_id(pair), second_id(pair), positions, is_on);
      if (is_on) on_.push_back(pair);
      if (winding > 0) inside.push_back(pair);
      if (winding < 0) ++found_.inside_out;
    }
    found_.inside = inside.size();
    buffers_.inside[0].ensure(inside.size());
    exec_.upload(buffers_.inside[0].data(), inside.data(), inside.size() * sizeof(inside[0]));
    exec_.wait();
  }
  /// Returns 0 for a vertex on the solid.
  int winding_of(uint32_t vertex, uint32_t solid, const std::vector<Vec3<Real>>& positions, bool& is_on) {
    const Topology& topology = *scene_.topology.solids.topology;
    const uint32_t mesh = scene_.topology.solids.solids[solid];
    const exact::PollScope poll([&] { exec_.asks().ask(); });
    int winding = 0;
    for (uint32_t i = topology.triangle_offset[mesh]; i < topology.triangle_offset[mesh + 1]; ++i) {
      const auto& t = topology.triangles[i];
      const uint32_t ids[4] = {vertex, t[0], t[1], t[2]};
      Vec3<double> points[4];
      for (int k = 0; k < 4; ++k) points[k] = convert<double>(positions[ids[k]]);
      const RayVerdict verdict = exact_ray(points, ids);
      if (is_on = verdict.is_on; is_on) return 0;
      winding += verdict.crossing;
    }
    return winding;
  }

  /// Returns how many vertices the host had to decide of.
  uint64_t find_depths() {
    const uint64_t count = found_.inside;
    if (count == 0) return 0;
    buffers_.columns.reserve(buffers_.inside[0].capacity(), needs_.fields_of(ContactKind::kVertexSolid));
    do {
      buffers_.rivals.ensure(needs_.is_exact() ? max(found_.rivals, uint64_t{1}) : 0);
      exec_.fill_zero(&buffers_.counts.data()->rivals, sizeof(uint64_t));
      exec_.for_each_group("find_nearest", {nullptr, count}, find_nearest());
      if (!needs_.is_exact()) return 0;
      exec_.download(&found_, buffers_.counts.data(), sizeof(found_));
      found_.inside = count;
    } while (found_.rivals > buffers_.rivals.capacity());
    return found_.rivals > 0 ? decide_rivals() : 0;
  }
  FindNearest<Real> find_nearest() const {
    return {tree(),    buffers_.bounds.data(), buffers_.inside[sorted_].span(found_.inside),
            columns(), needs_.is_exact(),      {buffers_.rivals.all(), &buffers_.counts.data()->rivals}};
  }
  uint64_t decide_rivals() {
    const uint64_t count = found_.rivals;
    std::vector<Rival> rivals(count), nearest;
    std::vector<Vec3<Real>> points(4 * count);
    std::vector<uint64_t> order(count);
    MemoryHold held(spec_.memory_quota);
    held.resize(count * (2 * sizeof(Rival) + 4 * sizeof(Vec3<Real>) + sizeof(uint64_t)));
    buffers_.points.ensure(points.size());
    exec_.for_each("gather_rivals", count,
                   GatherRivals<Real>{tree(), buffers_.inside[sorted_].span(found_.inside), buffers_.rivals.span(count),
                                      buffers_.points.span(points.size())});
    exec_.download(rivals.data(), buffers_.rivals.data(), count * sizeof(Rival));
    exec_.download(points.data(), buffers_.points.data(), points.size() * sizeof(points[0]));
    for (uint64_t k = 0; k < count; ++k) order[k] = k;
    std::sort(order.begin(), order.end(), [&](uint64_t a, uint64_t b) {
      return rivals[a].pair != rivals[b].pair ? rivals[a].pair < rivals[b].pair : rivals[a].place < rivals[b].place;
    });
    const exact::PollScope poll([&] { exec_.asks().ask(); });
    for (uint64_t first = 0; first < count;) {
      uint64_t end = first + 1;
      while (end < count && rivals[order[end]].pair == rivals[order[first]].pair) ++end;
      nearest.push_back(rivals[order[first + nearest_of(points, {order.data() + first, end - first})]]);
      first = end;
    }
    exec_.upload(buffers_.rivals.data(), nearest.data(), nearest.size() * sizeof(Rival));
    exec_.wait();
    exec_.for_each("put_nearest", nearest.size(),
                   PutNearest<Real>{find_nearest(), buffers_.rivals.span(nearest.size())});
    return nearest.size();
  }
  /// Returns which of the rivals, whose points these are, is the nearest, the first of several.
  static size_t nearest_of(const std::vector<Vec3<Real>>& points, std::span<const uint64_t> rivals) {
    std::vector<std::array<Vec3<double>, 3>> triangles;
    for (const uint64_t rival : rivals) {
      const Vec3<Real>* of = points.data() + 4 * rival;
      triangles.push_back({convert<double>(of[1]), convert<double>(of[2]), convert<double>(of[3])});
    }
    return collided::nearest_of(convert<double>(points[4 * rivals[0]]), triangles);
  }

  Exec& exec_;
  const SceneSpec& spec_;
  SceneBuffers<Exec, Real>& scene_;
  SolidBuffers<Exec, Real> buffers_;
  LevelNeeds needs_;
  SolidCounts found_;
  std::vector<uint64_t> on_;
  int sorted_ = 0;  ///< which of the buffers holds the pairs in order
};

}  // namespace collided
