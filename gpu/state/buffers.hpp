#pragma once
// Everything that a scene keeps on its backend but what engines build (each has its own). Arrays of stages that the
// scene does not have stay empty.

#include <array>
#include <utility>

#include "gpu/base/half_thickness.hpp"
#include "gpu/base/mesh_turns.hpp"
#include "gpu/boxes/measure.hpp"
#include "gpu/contacts/columns.hpp"
#include "gpu/contacts/order.hpp"
#include "gpu/contacts/place.hpp"
#include "gpu/contacts/solid_meshes.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/narrow/certified_ccd.hpp"
#include "gpu/narrow/floors.hpp"
#include "gpu/narrow/surfaces.hpp"
#include "gpu/search/elementary.hpp"
#include "gpu/search/excluded_pairs.hpp"
#include "gpu/state/settings.hpp"
#include "gpu/state/state.hpp"
#include "gpu/types.hpp"

namespace collided {

/// What lists have room for, or have room for beyond what grows with the triangles, in the first step of a scene:
/// enough for most scenes, and no more than the few triangles of a small one make.
inline uint64_t first_length(uint64_t triangles) { return min(64 + 24 * triangles, uint64_t{1024}); }

/// A list that is not there yet begins with this length, or with what is expected and a quarter more.
template <class List>
void begin_list(List& list, uint64_t length, uint64_t expected) {
  if (list.capacity() == 0) list.allocate(max(length, ListLengths::with_reserve(expected)));
}

/// Topology, as resident arrays.
template <Executor Exec>
struct ResidentTopology {
  explicit ResidentTopology(Exec& exec)
      : triangles(exec, "triangles"),
        triangle_edges(exec, "edges"),
        edges(exec, "edges"),
        owned(exec, "ownership"),
        mesh_of_triangle(exec, "pair_filter"),
        rules(exec, "pair_filter"),
        excluded_meshes(exec, "pair_filter"),
        first_vertex(exec, "half_thickness"),
        half_thickness(exec, "half_thickness"),
        ring_begin(exec, "rings"),
        ring_vertices(exec, "rings"),
        neighbour_begin(exec, "advance"),
        neighbours(exec, "advance"),
        group_of(exec, "advance"),
        rest_pairs(exec, "rest_pairs"),
        fan_begin(exec, "fans"),
        fan_elements(exec, "fans"),
        solid_triangles(exec, "solids"),
        solid_places(exec, "solids"),
        solid_vertices(exec, "solids") {}

  PairFilter filter() const {
    return {mesh_of_triangle.data(), rules.data(), {excluded_meshes.all()}, shape.is_one() ? 0 : shape.triangles};
  }
  VertexRings rings() const { return {ring_begin.all(), ring_vertices.all()}; }
  /// The ends of each vertex's edges.
  VertexRings joined() const { return {neighbour_begin.all(), neighbours.all()}; }
  HalfThicknesses halves() const {
    return {first_vertex.data(), half_thickness.data(), static_cast<uint32_t>(half_thickness.capacity()),
            shape.is_one() ? 0 : shape.vertices};
  }
  MeshesOfVertices meshes() const {
    return {first_vertex.data(), static_cast<uint32_t>(first_vertex.capacity()), shape.vertices};
  }
  Fans fans() const { return {fan_begin.all(), fan_elements.all(), corners(), shape}; }
  ExcludedPairs excluded_pairs() const { return {rings(), {rest_pairs.all()}}; }

  // Of all worlds.
  uint64_t triangle_count() const { return shape.worlds * triangles.capacity(); }
  WorldTable<Triangle> corners() const { return {triangles.all(), shape.worlds, shape.vertices}; }
  WorldTable<Triangle> sides() const { return {triangle_edges.all(), shape.worlds, shape.edges}; }
  WorldTable<EdgePair> edge_ends() const { return {edges.all(), shape.worlds, shape.vertices}; }

  WorldShape shape;  ///< the tables are of one world, but for `owned`, which searches read most
  Buffer<Triangle, Exec> triangles;
  Buffer<Triangle, Exec> triangle_edges;
  Buffer<EdgePair, Exec> edges;
  Buffer<uint8_t, Exec> owned;
  Buffer<uint32_t, Exec> mesh_of_triangle;
  Buffer<MeshRule, Exec> rules;
  uint32_t branches = 0;                   ///< as count_branches() says
  IdleMeshes idle;                         ///< by mesh of one world
  Buffer<uint64_t, Exec> excluded_meshes;  ///< slots of a KeySet
  Buffer<uint32_t, Exec> first_vertex;     ///< of each mesh of one world; scenes with thick meshes or features
  Buffer<double, Exec> half_thickness;     ///< of each mesh; scenes with thick meshes
  Buffer<uint32_t, Exec> ring_begin;
  Buffer<uint32_t, Exec> ring_vertices;
  Buffer<uint32_t, Exec> neighbour_begin;  ///< of each vertex; scenes that advance have these three
  Buffer<uint32_t, Exec> neighbours;
  AdvanceMode groups_are_of = {};
  Buffer<uint32_t, Exec> group_of;    ///< of each vertex the first of those that share its fraction, or kStands
  Buffer<uint64_t, Exec> rest_pairs;  ///< slots of a KeySet, those of the first frame
  Buffer<uint32_t, Exec> fan_begin;   ///< of each vertex; scenes that tell features have these two
  Buffer<uint32_t, Exec> fan_elements;
  SolidMeshes solids;  ///< on the host; scenes that look into solids have these four (SolidTables)
  Buffer<SolidTriangle, Exec> solid_triangles;
  Buffer<uint32_t, Exec> solid_places;
  Buffer<MeshVertex, Exec> solid_vertices;
};

/// Candidates of one kind on their way through the narrow phase.
template <Executor Exec>
struct CandidateBuffers {
  explicit CandidateBuffers(Exec& exec)
      : kept(exec, "candidates"), screened(exec, "candidates"), resumable(exec, "candidates") {}

  Buffer<uint64_t, Exec> kept;             ///< that the filter keeps
  Buffer<uint64_t, Exec> screened;         ///< those of them that no fixed direction keeps apart
  Buffer<ResumableQuery, Exec> resumable;  ///< those of them that float has not told apart
};

/// Makes buffers for each kind of features.
template <class Buffers, Executor Exec>
std::array<Buffers, kFeatureKinds> make_per_kind(Exec& exec) {
  static_assert(kFeatureKinds == 2);
  return {Buffers(exec), Buffers(exec)};
}

/// Pairs of one kind that ways are shortened for: those that no plane parts whatever their fractions.
template <Executor Exec>
struct BlockingPairs {
  explicit BlockingPairs(Exec& exec)
      : pairs(exec, "advance"), starts(exec, "advance"), filtered(exec, "advance"), failed(exec, "advance") {}

  /// For so many pairs.
  void allocate(uint64_t count) {
    starts.allocate(count);
    filtered.allocate(count);
    failed.allocate(count);
  }

  Buffer<uint64_t, Exec> pairs;
  Buffer<StartDistance, Exec> starts;
  Buffer<uint64_t, Exec> filtered;  ///< those of them that may be contacts
  Buffer<uint64_t, Exec> failed;    ///< places in `pairs`, in the round
};

/// Holds how far vertices go. Arrays of groups have a place for each vertex (base/groups.hpp).
template <Executor Exec>
struct FractionBuffers {
  explicit FractionBuffers(Exec& exec)
      : clearances(exec, "advance"),
        shares(exec, "advance"),
        fractions(exec, "advance"),
        changed_in(exec, "advance"),
        shortened(exec, "advance") {}

  void allocate(uint64_t vertices) {
    clearances.allocate(vertices);
    shares.allocate(vertices);
    fractions.allocate(vertices);
    changed_in.allocate(vertices);
    shortened.allocate(vertices);
  }

  Buffer<uint64_t, Exec> clearances;  ///< of each vertex (floors.hpp), as bits of a double
  Buffer<uint64_t, Exec> shares;      ///< the least that the round proposes, likewise
  Buffer<double, Exec> fractions;
  Buffer<uint32_t, Exec> changed_in;  ///< the last round that changed it, from 1 on
  Buffer<ShortenedWay, Exec> shortened;
};

/// Contacts of all kinds as they are found. Candidates at kCandidates have keys alone.
template <Executor Exec, class Real>
struct ContactBuffers {
  explicit ContactBuffers(Exec& exec) : keys(exec, "keys"), data(exec, "contacts") {}

  Buffer<uint64_t, Exec> keys;
  Buffer<ContactData<Real>, Exec> data;
};

/// Pairs that limit the ways of a frame, as contacts: as they were found, and in canonical order. Frames that ask for
/// them have them.
template <Executor Exec>
struct LimitBuffers {
  explicit LimitBuffers(Exec& exec)
      : keys(exec, "advance"), data(exec, "advance"), normals(exec, "advance"), columns(exec), order(exec) {}

  void reserve(uint64_t count, const OrderPlan& plan, const IdCounts& ids) {
    keys.ensure(count);
    data.ensure(count);
    normals.ensure(count);
    columns.reserve(keys.capacity(), kFieldsOfLimits);
    reserve_order<Exec>(order, plan, ids, keys.capacity(), true);
  }

  Buffer<uint64_t, Exec> keys;
  Buffer<ContactData<double>, Exec> data;  ///< precise whatever the positions are
  Buffer<Normal, Exec> normals;
  ColumnBuffers<Exec> columns;
  OrderBuffers<Exec> order;
};

/// Of meshes that move as a whole.
template <Executor Exec, class Real>
struct RigidBuffers {
  explicit RigidBuffers(Exec& exec)
      : rest(exec, "rigid"),
        bounds(exec, "rigid"),
        first_vertex(exec, "rigid"),
        deviations(exec, "rigid"),
        turns(exec, "rigid") {}

  Buffer<Vec3<Real>, Exec> rest;        ///< the positions that are transformed, of one mesh after the other
  Buffer<Box<Real>, Exec> bounds;       ///< of each mesh's
  Buffer<uint32_t, Exec> first_vertex;  ///< of every mesh of the scene; CCD only
  Buffer<double, Exec> deviations;      ///< likewise (Deviations)
  Buffer<MeshTurn, Exec> turns;         ///< likewise, on the ways that meshes go; of frames that advance
};

/// Of a set of worlds.
template <Executor Exec>
struct WorldBuffers {
  explicit WorldBuffers(Exec& exec)
      : frame(exec, "worlds"), bounds(exec, "worlds"), extents(exec, "worlds"), filters(exec, "worlds") {}

  void reserve(uint32_t worlds) {
    frame.allocate(worlds);
    bounds.allocate(worlds);
    extents.allocate(worlds);
    filters.allocate(worlds);
  }

  Buffer<uint8_t, Exec> frame;        ///< what the frame does with each (kStepsWorld)
  Buffer<Box<float>, Exec> bounds;    ///< of each one's triangles in the step
  Buffer<uint64_t, Exec> extents;     ///< of the triangles, as in StepState
  Buffer<FilterScale, Exec> filters;  ///< likewise
  uint64_t stepped = 0;               ///< worlds in the frame
};

/// What stays from frame to frame: what the scene is made of, and where it is.
template <Executor Exec, class Real>
struct ResidentBuffers {
  explicit ResidentBuffers(Exec& exec)
      : topology(exec),
        start(exec, "start_positions"),
        end(exec, "positions"),
        last_good(exec, "last_good"),
        target(exec, "advance"),
        rigid(exec),
        worlds(exec) {}

  SteppedWorlds stepped_worlds() const { return {worlds.frame.data(), topology.shape.triangles}; }

  ResidentTopology<Exec> topology;
  Buffer<Vec3<Real>, Exec> start;  ///< CCD only
  Buffer<Vec3<Real>, Exec> end;
  Buffer<Vec3<Real>, Exec> last_good;  ///< `end` of the last good frame: DCD, and CCD where a step begins elsewhere
  Buffer<Vec3<Real>, Exec> target;     ///< where the frame wants to go; frames that advance
  RigidBuffers<Exec, Real> rigid;
  WorldBuffers<Exec> worlds;
};

/// What a step works with. It begins anew with each step, but for the boxes and records of static meshes.
template <Executor Exec, class Real>
struct WorkBuffers {
  explicit WorkBuffers(Exec& exec)
      : boxes(exec, "boxes"),
        records(exec, "records"),
        paths(exec, "records"),
        inflations(exec, "records"),
        state(exec, "counters"),
        triangle_pairs(exec, "pairs"),
        edge_tests(exec, "pairs"),
        candidates(make_per_kind<CandidateBuffers<Exec>>(exec)),
        blocking(make_per_kind<BlockingPairs<Exec>>(exec)),
        ways(exec),
        limits(exec),
        contacts(exec),
        earliest(exec),
        normals(exec, "contacts"),
        columns(exec),
        order(exec),
        pair_keys(exec, "covering"),
        pair_slots(exec, "covering"),
        room(exec, "contacts"),
        layout(exec, "contacts"),
        exact_keys(exec, "exact"),
        exact_points(exec, "exact"),
        exact_halves(exec, "exact"),
        exact_ids(exec, "exact"),
        sample(exec, "watched_positions") {}

  Buffer<Box<float>, Exec> boxes;
  Buffer<TriangleRecord<Real>, Exec> records;
  Buffer<Path<Real>, Exec> paths;  ///< of each vertex, where records do not have them
  Buffer<Real, Exec> inflations;   ///< of each triangle's boxes; scenes with meshes that may turn or are thick
  Buffer<StepState, Exec> state;
  Buffer<uint64_t, Exec> triangle_pairs;                         ///< of one kind after the other
  Buffer<uint64_t, Exec> edge_tests;                             ///< PackedEdges; frames that test crossings
  std::array<CandidateBuffers<Exec>, kFeatureKinds> candidates;  ///< of each kind
  std::array<BlockingPairs<Exec>, kFeatureKinds> blocking;       ///< likewise; frames that advance
  FractionBuffers<Exec> ways;                                    ///< frames that advance
  LimitBuffers<Exec> limits;                                     ///< frames that ask for them
  ContactBuffers<Exec, Real> contacts;
  ContactBuffers<Exec, Real> earliest;  ///< EARLIEST_ONLY
  Buffer<Normal, Exec> normals;         ///< of the contacts as they were found
  ColumnBuffers<Exec> columns;          ///< in canonical order
  OrderBuffers<Exec> order;
  Buffer<uint64_t, Exec> pair_keys;    ///< of each contact (narrow/covering.hpp); frames that tell features
  Buffer<uint32_t, Exec> pair_slots;   ///< likewise
  Buffer<Span<std::byte>, Exec> room;  ///< where contacts stay; frames that have such memory
  Buffer<ContactLayout, Exec> layout;  ///< of those there
  Buffer<uint64_t, Exec> exact_keys;
  Buffer<Vec3<Real>, Exec> exact_points;
  Buffer<PairHalves, Exec> exact_halves;  ///< of the keys; scenes with thick meshes
  Buffer<uint32_t, Exec> exact_ids;
  Buffer<Vec3<Real>, Exec> sample;  ///< positions on their way to those who watch the scene
};

template <Executor Exec, class Real>
struct SceneBuffers : ResidentBuffers<Exec, Real>, WorkBuffers<Exec, Real> {
  explicit SceneBuffers(Exec& exec) : ResidentBuffers<Exec, Real>(exec), WorkBuffers<Exec, Real>(exec), share(exec) {}

  ResidentShare<Exec> share;

  SceneSize size(uint64_t triangles) const {
    StepState* state = this->state.data();
    return {this->boxes.span(triangles), &state->bounds, &state->extents, share.data()};
  }
  PairFilter pair_filter() const {
    PairFilter filter = this->topology.filter();
    if (share.is_shard()) filter.own = {share.data(), this->boxes.data()};
    return filter;
  }

  /// Runs after the scene and its worlds are measured, because bounds are those of all triangles.
  void leave_out_idle(Exec& exec, uint64_t triangles) {
    if (this->topology.idle.has_any())
      exec.for_each("leave_out_idle", triangles, LeaveOutIdle{this->topology.filter(), this->boxes.span(triangles)});
  }

  ListLengths expected;

  void reserve_boxes(uint64_t triangles, uint64_t vertices) {
    this->boxes.allocate(triangles);
    this->records.allocate(triangles);
    if (kRoundsBoxes<Real>) this->paths.allocate(vertices);
    if (have_inflations()) this->inflations.allocate(triangles);
  }

  /// Nothing is expected any more: lists begin anew with what most scenes need.
  void expect_nothing(Exec& exec) {
    expected = {};
    this->triangle_pairs = {exec, "pairs"};
    this->candidates = make_per_kind<CandidateBuffers<Exec>>(exec);
    this->contacts = ContactBuffers<Exec, Real>(exec);
    this->earliest = ContactBuffers<Exec, Real>(exec);
  }

  TriangleRecords<Real> triangle_records() const { return {this->records.all(), this->paths.all()}; }

  /// Of each triangle's boxes; empty where all have the same, whatever an edit that was undone left there.
  Span<Real> triangle_inflations() const { return have_inflations() ? this->inflations.all() : Span<Real>{}; }

  /// In a frame of DCD; unknown where no features are told.
  Surfaces<Real> surfaces() const { return {this->end.data(), this->topology.fans()}; }

  /// At t = 0; in DCD the frame's own.
  const Vec3<Real>* positions_at_start(bool is_ccd) const { return is_ccd ? this->start.data() : this->end.data(); }

  /// Of the step in work; none in DCD, which looks at its end alone.
  Deviations deviations(bool is_ccd) const {
    if (!is_ccd) return {};
    const RigidBuffers<Exec, Real>& rigid = this->rigid;
    return {rigid.first_vertex.data(), rigid.deviations.data(), static_cast<uint32_t>(rigid.first_vertex.capacity())};
  }
  /// Returns the half thicknesses that count in a frame.
  HalfThicknesses halves(const FrameSettings& settings) const {
    return settings.differs_by_pair() ? this->topology.halves() : HalfThicknesses{};
  }
  /// Returns how meshes turn on the part of their ways that they go.
  MeshTurns turns() const {
    const RigidBuffers<Exec, Real>& rigid = this->rigid;
    const uint64_t meshes = rigid.turns.capacity() > 0 ? rigid.first_vertex.capacity() : 0;
    return {rigid.first_vertex.data(), rigid.turns.data(), static_cast<uint32_t>(meshes)};
  }

 private:
  bool have_inflations() const {
    return this->rigid.deviations.capacity() > 0 || this->topology.half_thickness.capacity() > 0;
  }
};

}  // namespace collided
