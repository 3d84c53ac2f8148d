#pragma once
// What a scene is specified with, what a frame brings and what it answers with. No CUDA type appears here.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gpu/contact_set.hpp"
#include "gpu/device.hpp"
#include "gpu/errors.hpp"
#include "gpu/list_lengths.hpp"

namespace collided {

/// A limit that several scenes share. Thread-safe.
class MemoryQuota {
 public:
  virtual ~MemoryQuota() = default;
  /// Throws if `bytes` more would pass it; what it throws is what the frame or scene that asked is refused with.
  virtual void take(uint64_t bytes) = 0;
  virtual void give_back(uint64_t bytes) noexcept = 0;
};

/// Bytes taken from a quota; what is held at the end is given back. One thread at a time.
class MemoryHold {
 public:
  /// `quota` may be null: then nothing is counted.
  explicit MemoryHold(std::shared_ptr<MemoryQuota> quota) : quota_(std::move(quota)) {}
  MemoryHold(const MemoryHold&) = delete;
  MemoryHold& operator=(const MemoryHold&) = delete;
  ~MemoryHold() { resize(0); }

  uint64_t bytes() const { return bytes_; }
  /// Throws what the quota throws, and holds what it held then; never for fewer bytes.
  void resize(uint64_t bytes) {
    if (quota_ && bytes > bytes_) quota_->take(bytes - bytes_);
    if (quota_ && bytes < bytes_) quota_->give_back(bytes_ - bytes);
    bytes_ = bytes;
  }
  /// Takes over what `other` holds of the same quota.
  void absorb(MemoryHold& other) { bytes_ += std::exchange(other.bytes_, 0); }

 private:
  const std::shared_ptr<MemoryQuota> quota_;
  uint64_t bytes_ = 0;
};

/// kBoth: of a scene, each of whose frames asks for one of them. Its thickness is that of discrete frames; continuous
/// ones take min_separation.
enum class Mode { kDcd, kCcd, kBoth };
/// From kGuarded on no contact of the given positions is missed and no time of impact is late.
enum class Accuracy { kCandidates, kFast, kGuarded, kCertified, kExact };
/// What a frame answers with: every contact; the earliest one (CCD from kGuarded on); whether there is one (from
/// kFast on).
enum class Report { kAll, kEarliestOnly, kAnyHit };
/// Numbers that positions have.
enum class Scalar { kF32, kF64 };
/// Bytes of one position.
constexpr uint64_t position_bytes(Scalar scalar) { return scalar == Scalar::kF64 ? 24 : 12; }

/// Broad phase: which triangle pairs are tested at all. The pairs found are the same. kAuto lets the scene choose by
/// measured times; kOctree is the two-stage adaptive octree grid of the paper, kTopDown and kBottomUp its
/// one-stage forms, kVss the uniform grid with virtual subdivision that it is compared with. kAllPairs builds nothing
/// and tests all triangles against each other, which takes small scenes the least time.
enum class Engine { kAuto, kOctree, kTopDown, kBottomUp, kUniformGrid, kTwoLevelGrid, kLbvh, kVss, kAllPairs };
constexpr Engine kLastEngine = Engine::kAllPairs;

/// Why a frame's engine was chosen: the spec names it; no comparison yet; none yet, and the octree's counters looked
/// wrong; it won the last comparison; a comparison is on.
enum class EngineReason { kAsked, kFirst, kCounters, kFaster, kTrial };

/// The engine that found a frame's pairs, never kAuto, and what the last comparison measured of each: milliseconds from
/// positions to candidates; 0 before the first.
struct EngineFacts {
  Engine engine = Engine::kOctree;
  EngineReason reason = EngineReason::kAsked;
  double octree_milliseconds = 0, lbvh_milliseconds = 0, all_pairs_milliseconds = 0;
};

/// Whether frames that resemble the last go by its list of neighbours: pairs of features that a search found close to
/// each other hold all candidates for as long as no vertex has moved far. What is found is the same. kAuto: where
/// measured times say that it pays, in scenes whose engine is kAuto. kOn: wherever it can be.
enum class Reuse { kAuto, kOn, kOff };
/// What a frame did with lists of neighbours: it searched for candidates, or for neighbours and found its candidates
/// among them, or found them among those of a frame before.
enum class ListUse { kNone, kMade, kReused };
/// Why: the spec says so; what the frame asks for needs a search (kAnyHit, triangle pairs); no comparison yet; a
/// comparison is on; it won or lost the last one; there was no room for the lists.
enum class ReuseReason { kAsked, kUnsuited, kFirst, kTrial, kFaster, kSlower, kNoRoom };

struct ReuseFacts {
  ListUse use = ListUse::kNone;
  ReuseReason reason = ReuseReason::kAsked;
  double margin = 0;    ///< of the lists; unit of the positions
  uint64_t frames = 0;  ///< since the lists were made
  /// What the last comparison measured, milliseconds a step: with lists, on average, and without; 0 before the first.
  double list_milliseconds = 0, search_milliseconds = 0;
};

/// How a mesh moves: any vertex in any frame; not after the first frame; as a whole, by transforms of the positions
/// that its first frame brought.
enum class MeshMotion { kDeformable, kStatic, kRigid };

/// Vertex indices are counted in the mesh. A mesh has one element or more, of any kinds. What a loose edge or point
/// shares with an element before it, in the order triangles, edges, points, is that element's: it adds nothing.
struct MeshSpec {
  uint32_t vertex_count = 0;
  std::vector<std::array<uint32_t, 3>> triangles = {};
  std::vector<std::array<uint32_t, 2>> edges = {};  ///< loose ones, such as the segments of a hair; of no triangle
  std::vector<uint32_t> points = {};                ///< loose ones, such as particles; of no triangle or edge
  MeshMotion motion = MeshMotion::kDeformable;
  uint32_t groups = 1;          ///< bits
  uint32_t collide_mask = ~0u;  ///< bits of groups it can touch
  bool self_contacts = true;
  /// Self contacts of features, triangles among them, that so many edges or fewer connect are left out; up to
  /// kMaxRings.
  uint32_t excluded_rings = 0;
  /// Self contacts of a vertex and a triangle, or of two edges, that are within SceneSpec::rest_distance in the first
  /// frame are left out.
  bool excludes_rest_pairs = false;
  /// What the mesh adds to the contact distance, h: >= 0, finite, unit of the positions. Meshes i and j are in contact
  /// within the real sum SceneSpec::thickness + h_i + h_j, a mesh and itself within thickness + 2 h. Continuous frames
  /// of scenes of both modes do not use it.
  double half_thickness = 0;
  /// The mesh bounds a volume: triangles alone, each edge used as often in one direction as in the other, and a volume
  /// above 0 in the first frame.
  bool solid = false;
};
constexpr uint32_t kMaxRings = 8;

/// Triangles, loose edges and loose points.
inline uint64_t count_elements(const MeshSpec& mesh) {
  return mesh.triangles.size() + mesh.edges.size() + mesh.points.size();
}

/// A box that positions are encoded in.
struct PositionBox {
  std::array<double, 3> lower{}, upper{};  ///< finite, lower <= upper
};

/// What a scene needs; stages and buffers exist only for what is asked for here.
struct SceneSpec {
  Device device = {};
  Mode mode = Mode::kCcd;
  Accuracy accuracy = Accuracy::kCertified;
  Scalar scalar = Scalar::kF32;
  Engine engine = Engine::kAuto;
  Reuse reuse = Reuse::kAuto;
  double thickness = 0;  ///< >= 0, finite, unit of the positions; MeshSpec::half_thickness adds to it
  double delta = 0;      ///< tolerance of CCD from kGuarded on, unit of the positions; 0: relative to each pair's size
  /// CCD: distance that FrameInput::advance keeps; >= 0, finite, unit of the positions.
  double min_separation = 0;
  /// Of MeshSpec::excludes_rest_pairs; >= 0, finite, unit of the positions. 0: each mesh's own contact distance, which
  /// is thickness + 2 MeshSpec::half_thickness.
  double rest_distance = 0;
  /// Pairs of meshes that never touch, in any order, each once; a mesh and itself are one, too.
  std::vector<std::array<uint32_t, 2>> excluded_meshes;
  /// If there is one, positions come as 16-bit fixed point in it (positions/quantized.hpp); the scalar is kF32.
  std::optional<PositionBox> quantized_in;
  Report report = Report::kAll;
  /// Which kinds are wanted, one or more. Vertex-triangle contacts are also those of a loose point and a loose edge or
  /// another point (search/loose_elements.hpp). Of triangles, in DCD: those of the frame that intersect; thickness
  /// plays no part. In CCD, at kCandidates alone: those whose boxes overlap. Vertices in solids, in DCD: of a vertex
  /// and the triangle of another mesh, in which it is, that is nearest to it; `distance` is minus the depth.
  PerKind<bool> kinds = {.vertex_triangle = true, .edge_edge = true};
  /// What contacts are to have, where the level computes it. Elements, toi and flags are always there.
  FieldSet fields = {ContactField::kElements, ContactField::kToi, ContactField::kDistance, ContactField::kFlags};
  /// Frames of DCD tell how each pair of meshes, one of them solid, lies to each other (FrameResult::pair_states).
  bool pair_states = false;
  uint64_t memory_budget = 0;                 ///< bytes on the backend; 0: no limit but the device's
  std::shared_ptr<MemoryQuota> memory_quota;  ///< that counts it too, and memory on the host; may be empty
  int threads = 0;                            ///< CPU threads; 0: all cores
  ListLengths expected = {};                  ///< where there is no room for so much, lists begin as without it
  std::shared_ptr<KnownLengths> known;        ///< of scenes alike: the scene expects and tells them; may be empty
  /// Empty: the scene is one, on `device`. Else it is divided into so many shards, up to kMaxShards: shard k is on
  /// part_devices[k], and `device` is not asked. They are of one backend; several may be on one device, and CPU threads
  /// are shared out among all. Each shard has all positions, and finds the contacts of some regions of space; what a
  /// frame answers is the same. `memory_budget` is then each shard's. Not with sets of worlds, lists of neighbours
  /// (`reuse`) and ContactRoom.
  std::vector<Device> part_devices = {};
  /// 0: the scene is one. Else it is a set of so many worlds, up to kMaxWorlds: each has all the meshes, stored once,
  /// and positions of its own, and none touches another. A frame names mesh m of world w as w * meshes.size() + m.
  uint32_t worlds = 0;
  std::vector<MeshSpec> meshes;
};
/// Whether some mesh is a solid.
inline bool has_solids(const SceneSpec& spec) {
  return std::any_of(spec.meshes.begin(), spec.meshes.end(), [](const MeshSpec& mesh) { return mesh.solid; });
}
constexpr uint32_t kMaxWorlds = 1u << 16;
constexpr size_t kMaxShards = 64;
/// That the scene is on, or its first shard.
inline const Device& device_of(const SceneSpec& spec) {
  return spec.part_devices.empty() ? spec.device : spec.part_devices.front();
}
/// 1 of a scene that is one.
inline uint32_t count_worlds(const SceneSpec& spec) { return std::max(spec.worlds, 1u); }

/// A mesh as an edit wants it.
struct MeshEdit {
  uint32_t mesh = 0;  ///< its number; that of the last mesh and 1: it is added
  /// Without vertices and elements: the mesh is removed. Without elements: it keeps those that it has, and as many
  /// vertices.
  MeshSpec spec = {};
};

/// Changes of what a scene is made of. Meshes keep their numbers: where one is removed, a mesh without vertices stays,
/// which a later edit may fill. Scene-wide ids are counted anew.
struct SceneEdit {
  std::vector<MeshEdit> meshes = {};  ///< each once
  /// Pairs of meshes that never touch from here on, or may touch again. Those of a mesh that is removed go with it.
  std::vector<std::array<uint32_t, 2>> excluded = {}, included = {};
  double rest_distance = 0;  ///< >= 0, finite, unit of the positions; 0: the scene's stays
};

/// Bytes of one position as frames bring it.
constexpr uint64_t position_bytes(const SceneSpec& spec) { return spec.quantized_in ? 6 : position_bytes(spec.scalar); }

/// New positions of one mesh: packed xyz of the scene's scalar type (uint16 each where they are quantized), of all its
/// vertices, or of those in `indices`. The bytes may lie in any memory that the backend reads: host memory (a slot's
/// own is the fastest), registered host memory, or, on CUDA, that of the device.
struct MeshPositions {
  uint32_t mesh = 0;
  std::span<const std::byte> start = {};    ///< t = 0 (CCD); empty: where the last frame left the mesh
  std::span<const std::byte> end = {};      ///< t = 1
  bool is_sparse = false;                   ///< only the vertices of `indices` change
  std::span<const std::byte> indices = {};  ///< uint32 each, strictly ascending, counted in the mesh
  /// Rigid meshes: float64[3][4] in host memory, the rows of [R | t], instead of positions; those of the first frame
  /// are transformed (positions/pose.hpp).
  std::span<const std::byte> transform = {};
  std::span<const std::byte> start_transform = {};  ///< at t = 0 (CCD); empty: where the last frame left the mesh
};

/// What goes its own fraction of the way in a frame that advances.
enum class AdvanceMode {
  kAllOrOne,   ///< the scene
  kPerMesh,    ///< each mesh
  kPerVertex,  ///< each vertex, but rigid meshes as a whole
};

/// Whose ways a frame that advances has shortened: meshes at kPerMesh, vertices (scene-wide ids) at kPerVertex.
struct ShortenedWays {
  std::vector<uint32_t> ids;      ///< ascending; of what moves
  std::vector<double> fractions;  ///< of each, in [0, 1)
};

/// What each pair that limits a way has (FrameResult::limits), whatever SceneSpec::fields says.
inline constexpr FieldSet kFieldsOfLimits = {ContactField::kElements, ContactField::kToi,     ContactField::kDistance,
                                             ContactField::kWeights,  ContactField::kNormals, ContactField::kFlags};

/// Room for the positions of one frame on their way to the backend. A scene makes as many as it has frames in flight.
/// Filling and sending one goes on while another frame is in work; one thread at a time.
class FrameSlot {
 public:
  virtual ~FrameSlot() = default;
  /// Host memory of at least `bytes`, aligned to 64, that the backend reads directly (pinned on CUDA). What was there
  /// before is lost. Throws ResourceExhausted.
  virtual std::span<std::byte> room(uint64_t bytes) = 0;
  /// Starts to bring the updates' bytes to the backend; they must stay as they are until the frame has been applied
  /// or the slot is sent anew. What the backend reads is what was there when it did: nothing is read twice. Throws
  /// InvalidInput where sizes do not fit the meshes, ResourceExhausted, DeviceError.
  virtual void send(const std::vector<MeshPositions>& updates) = 0;
};

/// Memory of the backend (on CUDA that of the device) that a frame's contacts are put into instead of being brought to
/// the host. Nobody else may use it until detect() has returned or thrown.
struct ContactRoom {
  static constexpr uint64_t kAlignment = 64;  ///< bytes; of the memory, and within it of each array

  std::span<std::byte> memory = {};  ///< empty: contacts are brought to the host
  FieldSet fields = {};              ///< that are put there, of those that the answer has
  bool stencils = false;             ///< uint32[4]: the vertices of both features, which triangle pairs do not have
  /// So many of the first contacts of each kind are brought to the host all the same (FrameResult::first).
  uint64_t first_on_host = 0;
};

/// Describes a frame that was given up: what it had found by then, and which meshes go far.
struct FrameProgress {
  /// A mesh that goes farther in the step than its edges are long: what it costs is not its contacts, but its way.
  struct FarMesh {
    uint32_t mesh = 0;
    double way = 0;   ///< about the longest of a vertex
    double edge = 0;  ///< about the mean length of an edge
  };

  uint64_t pairs = 0, candidates = 0, contacts = 0;  ///< of triangles, of features, of all kinds
  std::vector<FarMesh> far_meshes;                   ///< the farthest for its edges first, at most kMaxFarMeshes
  static constexpr size_t kMaxFarMeshes = 3;
};

/// Of a set of worlds each world's frame counts or is refused by itself: its first frame must name all its meshes;
/// worlds that a frame does not name are not stepped, and stay where they are.
struct FrameInput {
  std::vector<MeshPositions> updates;    ///< the first frame must name every mesh; empty if `slot` brings them
  std::shared_ptr<FrameSlot> slot = {};  ///< of the same scene, with positions that were sent; may be empty
  /// What the scene is made of changes before the frame, if the frame counts; then `slot` is empty, and slots made
  /// before are of no use any more. Meshes that are added, or get another number of vertices or another motion, have
  /// their first positions here, as in a first frame; in CCD deformable ones that were there before also say where they
  /// begin. Static and rigid meshes that are replaced may have first positions again. Not in a scene's first frame.
  std::shared_ptr<const SceneEdit> edit = {};
  std::optional<Mode> mode = {};          ///< kDcd or kCcd; the scene's if absent, and kCcd where that is kBoth
  std::optional<Accuracy> accuracy = {};  ///< for this frame alone; the scene's if absent
  std::optional<double> delta = {};
  std::optional<Report> report = {};
  /// earliest_toi, kEarliestOnly and kAnyHit leave out contacts that come no closer (kFlagSeparating). CCD from
  /// kGuarded on.
  bool ignore_separating = false;
  /// Go only as far towards the frame's positions as is certified: features keep min_separation, and those that start
  /// closer come no closer (narrow/floors.hpp). The contacts are those of the whole way. Implies ignore_separating. CCD
  /// from kCertified on, of both kinds of features.
  bool advance = false;
  AdvanceMode advance_mode = AdvanceMode::kAllOrOne;  ///< with `advance` alone
  bool limits = false;                                ///< answer with what limits the way; with `advance` alone
  /// Answer, and leave the scene as it was.
  bool trial = false;
  /// CCD: begin this far along the way of the last frame, in [0, 1], that of a trial too, by the formula of
  /// positions/blend.hpp. Meshes that the frame does not name stay there.
  std::optional<double> start_fraction = {};
  /// Whether to give the frame up; may be empty. The thread that called detect() asks, and no other: before each stage,
  /// and after about 8 ms of work within one. If it returns true (Cancelled) or throws, the frame ends and the scene is
  /// as it was. On CPU cores it may take its time: nothing of the frame goes on meanwhile.
  std::function<bool()> cancelled = {};
  /// Filled in where the search for contacts was given up, or found no memory; may be null.
  FrameProgress* progress = nullptr;
  /// Bytes that the caller will hold for each contact of the answer, beside the result's own: counted with it.
  uint64_t bytes_beside_contact = 0;
  /// Where the contacts stay; those that do not fit come to the host.
  ContactRoom room = {};
  /// A stream (cudaStream_t) of the scene's CUDA device. The frame begins after the work that the stream holds now,
  /// which may write the updates' positions or read `room`; the calling thread need not wait for it. Null: no such work
  /// is left. It is refused with `slot`, in a scene in parts and on CPU cores.
  void* stream = nullptr;
};

/// Vertices of a scene: `first` (scene-wide), first + stride, and so on, `count` of them.
struct VertexSample {
  uint64_t first = 0, stride = 1, count = 0;

  bool operator==(const VertexSample&) const = default;
};

struct StageTime {
  std::string stage;
  double milliseconds = 0;
};

struct FrameCounts {
  uint64_t cells = 0, leaves = 0;
  uint32_t top_level = 0, base_level = 0;
  uint64_t registrations = 0, tests = 0, pairs = 0;
  PerKind<uint64_t> candidates, contacts;
  PerKind<uint64_t> survivors;  ///< left by the coplanarity filter (from kGuarded on)
  uint64_t exact_decisions = 0;
  /// With `pair_states`: pairs of a vertex and another mesh, a solid, whose winding number there is below 0, because a
  /// part of the mesh is inside out.
  uint64_t inside_out = 0;
};

/// Says how two meshes lie to each other, of which at least one is a solid. A vertex is inside a solid if it is on none
/// of its triangles and the winding number there is 1 or more.
/// - kTouching: the meshes have a point in common. Two solids have no common volume. If one is no solid, no triangles
///   go through each other.
/// - kOverlapping: the meshes meet in more than that. Or a vertex of one is inside the other, and neither of the states
///   below holds.
/// - kFirstInside, kSecondInside: the surfaces have no point in common. All vertices of this mesh are inside the other
///   one, and none of the other's is inside this one.
enum class PairState { kTouching, kOverlapping, kFirstInside, kSecondInside };

/// Two meshes that are not apart, as positions of the frame have them. Decided exactly.
struct MeshPairState {
  static constexpr uint32_t kNoVertex = ~0u;

  uint32_t first = 0, second = 0;  ///< meshes, first < second
  PairState state = PairState::kTouching;
  uint32_t first_inside = 0, second_inside = 0;  ///< vertices of this mesh that are in the other
  uint32_t deepest = kNoVertex;                  ///< of these vertices (scene-wide id), the lowest of equal ones
  double depth = 0;                              ///< its distance from the other mesh's surface, unit of the positions
};

/// A world whose part of a frame is refused; it is as it was. `field`: of MeshPositions, or `updates`.
struct RefusedWorld {
  uint32_t world = 0;
  std::string field, what;
};
/// Of a frame of a set of worlds. The ids of its contacts are counted in each world.
struct WorldResults {
  PerKind<std::vector<uint64_t>> begin;  ///< of each world's contacts; one more entry at the end
  std::vector<RefusedWorld> refused;     ///< ascending
};

/// What a shard of a scene had of a frame.
struct ShardFacts {
  double share = 1;              ///< of the blocks of space, in [0, 1]
  double step_milliseconds = 0;  ///< as FrameResult has it; the scene's is that of the slowest shard
  uint64_t pairs = 0, contacts = 0;
};

/// Of triangle pairs it has elements and flags alone. With a ContactRoom the first contacts of all kinds together lie
/// there (`placed`), as many as fit, and the sets have the others.
struct FrameResult : PerKind<ContactSet> {
  PerKind<PlacedContacts> placed;
  PerKind<ContactSet> first;  ///< as ContactRoom::first_on_host asks
  std::vector<StageTime> stages;
  FrameCounts counts;
  uint32_t replays = 0;         ///< runs of the step, or of a part of it, that were too short of memory
  uint32_t allocations = 0;     ///< of memory on the backend
  uint32_t graph_launches = 0;  ///< CUDA graphs launched; 0 on the CPU
  /// From resident positions to contacts in canonical order, on the backend: all runs of the step, as in `stages`,
  /// without the time spent in FrameInput::cancelled on CPU cores.
  double step_milliseconds = 0;
  EngineFacts broad_phase;
  ReuseFacts reuse;
  double earliest_toi = 1;  ///< CCD; from kGuarded on no contact is earlier
  /// The least fraction of its way, in [0, 1], that anything went. Frames that ask to advance have it. Formulas of
  /// where vertices are then stand in positions/blend.hpp, those of rigid meshes in positions/pose.hpp.
  std::optional<double> advanced = {};
  /// Of such a frame: the sum of the lengths of all vertices' ways that were gone, divided by that of the whole ways;
  /// 1 if nothing moves. Within 2^-20 of the truth in scenes of up to a million vertices.
  double way = 1;
  ShortenedWays shortened = {};  ///< likewise; empty at kAllOrOne
  /// Of frames with FrameInput::limits: the pairs of features that the whole way would bring below their floors
  /// (narrow/floors.hpp), of each kind in canonical order, with all columns, on the host. `distance` is the floor, and
  /// `toi` the fraction of the whole way at which the pair comes to it, no later than in truth. The same in each mode.
  PerKind<ContactSet> limits;
  /// With SceneSpec::pair_states, in DCD: the pairs of meshes that may touch and are not apart, by `first` and
  /// `second`.
  std::vector<MeshPairState> pair_states;
  bool any_contact = false;
  WorldResults worlds;             ///< of a set of worlds
  std::vector<ShardFacts> shards;  ///< of a scene in parts. Counts of what was done (cells, tests) are of all together
  bool input_resolution = false;   ///< the input's own spacing is coarser than delta (0: than 1/1000 of most triangles)
  std::vector<std::string> unused_options;  ///< of the spec, that are set and had no effect on this frame
  /// The contacts' memory, within what the scene took of its memory_quota for answers; given back with the last copy.
  /// May be null.
  std::shared_ptr<const void> held = {};
};

/// All, wherever they lie.
inline size_t count_contacts(const FrameResult& result) {
  size_t count = count_contacts(static_cast<const PerKind<ContactSet>&>(result));
  for_each_kind([&](ContactKind, const PlacedContacts& placed) { count += placed.count; }, result.placed);
  return count;
}

struct MemoryPart {
  std::string part;
  uint64_t bytes = 0;
};

/// Scene-wide features: the vertices and elements of each mesh follow those of the meshes before it.
struct Topology {
  uint32_t vertex_count = 0;
  /// Elements: of each mesh its triangles, then its loose edges as (a, b, b), then its loose points as (a, a, a).
  std::vector<std::array<uint32_t, 3>> triangles;
  uint64_t loose_edges = 0, loose_points = 0;  ///< how many of them are such
  std::vector<std::array<uint32_t, 2>> edges;  ///< lower vertex first, sorted; the index is the edge's id
  std::vector<uint32_t> vertex_offset;         ///< of each mesh; one more entry at the end
  std::vector<uint32_t> triangle_offset;
};

inline bool has_loose_elements(const Topology& topology) { return topology.loose_edges + topology.loose_points > 0; }

/// Memory of others that a backend may read directly while this lives.
class SharedMemory {
 public:
  virtual ~SharedMemory() = default;
  virtual std::span<std::byte> bytes() const = 0;
};

}  // namespace collided
