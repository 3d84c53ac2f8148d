// The functions of collided.h.
#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>

#include "client/c/calls.hpp"
#include "client/c/spec.hpp"
#include "gpu/detector.hpp"
#include "gpu/stencil.hpp"

using namespace collided;

struct collided_scene {
  FieldSet fields;
  bool stencils;
  std::unique_ptr<Detector> detector;
  std::atomic_flag is_busy = {};
  bool has_frame = false;

  Device device() const { return device_of(detector->spec()); }
};

struct collided_result {
  Device device;
  FrameResult frame;
  std::byte* room;
  FieldSet fields;
  PerKind<std::vector<ContactVertices>> stencils, limit_stencils;
};

namespace {

/// The only call that uses a scene, while it lives.
class SceneUse {
 public:
  explicit SceneUse(collided_scene* scene) : scene_(*c::required(scene, "scene")), kept_(scene_.device()) {
    if (scene_.is_busy.test_and_set(std::memory_order_acquire))
      throw c::FailedPrecondition("scene is used by another call, which has not returned yet; one at a time");
  }
  ~SceneUse() { scene_.is_busy.clear(std::memory_order_release); }
  SceneUse(const SceneUse&) = delete;
  SceneUse& operator=(const SceneUse&) = delete;

  collided_scene* operator->() const { return &scene_; }

 private:
  collided_scene& scene_;
  const KeptCudaDevice kept_;
};

template <size_t N>
void copy_text(const std::string& text, char (&to)[N]) {
  const size_t length = std::min(text.size(), N - 1);
  std::copy_n(text.begin(), length, to);
  to[length] = 0;
}

void write_device(const DeviceInfo& device, collided_device_info* to) {
  collided_device_info info{};
  copy_text(to_string(device.device), info.id);
  copy_text(device.name, info.name);
  info.memory_bytes = device.memory_bytes;
  c::write_structure(to, info, "info");
}

using Stencils = PerKind<std::vector<ContactVertices>>;

std::vector<ContactVertices> make_stencils(ContactKind kind, const ContactSet& set, const Topology& topology) {
  std::vector<ContactVertices> stencils;
  const FindVertices vertices = stencil_finder(kind);
  if (vertices == nullptr) return stencils;
  stencils.reserve(set.size());
  for (const auto& elements : set.elements) stencils.push_back(vertices(elements, topology));
  return stencils;
}

Stencils make_stencils(const PerKind<ContactSet>& contacts, const Topology& topology) {
  Stencils all;
  for_each_kind([&](ContactKind kind, const ContactSet& set,
                    std::vector<ContactVertices>& stencils) { stencils = make_stencils(kind, set, topology); },
                contacts, all);
  return all;
}

std::unique_ptr<collided_result> detect(const SceneUse& scene, FrameInput frame) {
  if (scene->stencils) frame.bytes_beside_contact = sizeof(ContactVertices);
  if (!frame.room.memory.empty()) {
    check_device_memory(scene->device(), frame.room.memory, "room");
    frame.room.fields = scene->fields;
    frame.room.stencils = scene->stencils;
  }
  auto result = std::make_unique<collided_result>();
  result->device = scene->device();
  result->fields = scene->fields;
  result->room = frame.room.memory.data();
  result->frame = scene->detector->detect(frame);
  if (!frame.trial) scene->has_frame = true;
  const Topology& topology = scene->detector->topology();
  if (scene->stencils) result->stencils = make_stencils(result->frame, topology);
  result->limit_stencils = make_stencils(result->frame.limits, topology);
  return result;
}

/// `values` has something for each field; find(field, that) is where a field's numbers are, or null if it has none.
template <class PerFields, class Find>
collided_contacts columns_of(uint64_t count, const PerFields& values, const Find& find) {
  collided_contacts contacts{};
  contacts.count = count;
  for_each_field([&]<class Number>(ContactField field, const auto& value,
                                   const Number*& to) { to = static_cast<const Number*>(find(field, value)); },
                 values, contacts);
  return contacts;
}

/// On the host, with those of these fields that there are.
collided_contacts contacts_of(const ContactSet& set, const std::vector<ContactVertices>& stencils, FieldSet fields) {
  const auto find = [&](ContactField field, const auto& column) -> const void* {
    return column.empty() || !fields.has(field) ? nullptr : column.data();
  };
  collided_contacts contacts = columns_of(set.size(), set, find);
  contacts.stencils = stencils.empty() ? nullptr : stencils.front().data();
  return contacts;
}
collided_contacts contacts_of(const collided_result& result, ContactKind kind) {
  const ContactSet& set = value_of(static_cast<const PerKind<ContactSet>&>(result.frame), kind);
  return contacts_of(set, value_of(result.stencils, kind), result.fields);
}
collided_contacts limits_of(const collided_result& result, ContactKind kind) {
  return contacts_of(value_of(result.frame.limits, kind), value_of(result.limit_stencils, kind), kFieldsOfLimits);
}

collided_contacts contacts_in_room_of(const collided_result& result, ContactKind kind) {
  const PlacedContacts& placed = value_of(result.frame.placed, kind);
  const auto at = [&](const ArrayRange& range) -> const void* {
    return range.bytes == 0 ? nullptr : result.room + range.offset;
  };
  collided_contacts contacts =
      columns_of(placed.count, placed, [&](ContactField, const ArrayRange& range) { return at(range); });
  contacts.stencils = static_cast<const uint32_t*>(at(placed.stencils));
  return contacts;
}

/// The kind that a caller names by its enumerator. Throws InvalidInput.
ContactKind parse_kind(int32_t kind) {
  if (kind < 1 || kind > static_cast<int32_t>(kContactKinds))
    throw InvalidInput("kind",
                       "kind is " + std::to_string(kind) + "; it must be from 1 to " + std::to_string(kContactKinds));
  return static_cast<ContactKind>(kind - 1);
}

void fill_counts(const FrameCounts& counts, collided_facts& facts) {
  facts.cells = counts.cells;
  facts.leaves = counts.leaves;
  facts.registrations = counts.registrations;
  facts.tests = counts.tests;
  facts.pairs = counts.pairs;
  facts.exact_decisions = counts.exact_decisions;
  facts.top_level = counts.top_level;
  facts.base_level = counts.base_level;
  for_each_kind(
      [&](ContactKind kind, uint64_t candidates, uint64_t survivors, uint64_t contacts) {
        const auto k = static_cast<size_t>(kind);
        if (k >= std::size(facts.contacts)) return;  // it came later, and has a member of its own
        facts.candidates[k] = candidates;
        facts.survivors[k] = survivors;
        facts.contacts[k] = contacts;
      },
      counts.candidates, counts.survivors, counts.contacts);
  facts.edge_triangle_contacts = counts.contacts.edge_triangle;
  facts.vertex_solid_contacts = counts.contacts.vertex_solid;
  facts.inside_out = counts.inside_out;
}

collided_facts facts_of(const FrameResult& result) {
  collided_facts facts{};
  facts.contact_count = count_contacts(result);
  facts.earliest_toi = result.earliest_toi;
  facts.advanced = result.advanced.value_or(1);
  facts.any_contact = result.any_contact;
  facts.input_resolution = result.input_resolution;
  facts.step_milliseconds = result.step_milliseconds;
  facts.stage_count = static_cast<uint32_t>(result.stages.size());
  facts.unused_option_count = static_cast<uint32_t>(result.unused_options.size());
  facts.replays = result.replays;
  facts.allocations = result.allocations;
  facts.graph_launches = result.graph_launches;
  facts.broad_phase_engine = c::enumerator_of(result.broad_phase.engine);
  fill_counts(result.counts, facts);
  facts.mesh_pair_count = result.pair_states.size();
  facts.way = result.way;
  const ShortenedWays& shortened = result.shortened;
  facts.shortened_count = shortened.ids.size();
  if (!shortened.ids.empty()) {
    facts.shortened_ids = shortened.ids.data();
    facts.shortened_fractions = shortened.fractions.data();
  }
  return facts;
}

int32_t enumerator_of(PairState state) {
  switch (state) {
    case PairState::kTouching:
      return COLLIDED_PAIR_TOUCHING;
    case PairState::kOverlapping:
      return COLLIDED_PAIR_OVERLAPPING;
    case PairState::kFirstInside:
      return COLLIDED_PAIR_FIRST_INSIDE;
    case PairState::kSecondInside:
      return COLLIDED_PAIR_SECOND_INSIDE;
  }
  return 0;
}

collided_mesh_pair pair_of(const MeshPairState& state) {
  static_assert(MeshPairState::kNoVertex == UINT32_MAX, "collided.h says so");
  collided_mesh_pair pair{};
  pair.first = state.first;
  pair.second = state.second;
  pair.state = enumerator_of(state.state);
  pair.first_inside = state.first_inside;
  pair.second_inside = state.second_inside;
  pair.deepest = state.deepest;
  pair.depth = state.depth;
  return pair;
}

template <class T>
const T& at(const std::vector<T>& values, uint64_t index) {
  if (index >= values.size())
    throw InvalidInput("index",
                       "index is " + std::to_string(index) + ", but there are " + std::to_string(values.size()));
  return values[index];
}

/// Returns where the caller wants an object, and sets it to null until the object exists.
template <class T>
T** output(T** to, const char* field) {
  *c::required(to, field) = nullptr;
  return to;
}

}  // namespace

collided_status collided_device_count(uint32_t* count) {
  return c::guarded([&] { *c::required(count, "count") = static_cast<uint32_t>(list_devices().size()); });
}

collided_status collided_device(uint32_t index, collided_device_info* info) {
  return c::guarded([&] { write_device(at(list_devices(), index), info); });
}

collided_status collided_scene_create(const collided_scene_spec* spec, collided_scene** to) {
  return c::guarded([&] {
    output(to, "scene");
    c::Spec parsed = c::parse_spec(spec);
    auto scene = std::make_unique<collided_scene>(parsed.fields, parsed.stencils);
    const KeptCudaDevice kept(parsed.engine.device);
    scene->detector = Detector::create(std::move(parsed.engine));
    *to = scene.release();
  });
}

void collided_scene_free(collided_scene* scene) {
  if (scene == nullptr) return;
  const KeptCudaDevice kept(scene->device());
  delete scene;
}

collided_status collided_scene_topology(collided_scene* scene, collided_topology* to) {
  return c::guarded([&] {
    const Topology& topology = SceneUse(scene)->detector->topology();
    collided_topology out{};
    out.elements = topology.triangles.empty() ? nullptr : topology.triangles.front().data();
    out.edges = topology.edges.empty() ? nullptr : topology.edges.front().data();
    out.vertex_offsets = topology.vertex_offset.data();
    out.element_offsets = topology.triangle_offset.data();
    out.vertex_count = topology.vertex_count;
    out.element_count = topology.triangles.size();
    out.edge_count = topology.edges.size();
    out.mesh_count = topology.vertex_offset.size() - 1;
    c::write_structure(to, out, "topology");
  });
}

collided_status collided_scene_memory(collided_scene* scene, uint64_t* bytes) {
  return c::guarded([&] {
    uint64_t sum = 0;
    for (const MemoryPart& part : SceneUse(scene)->detector->memory()) sum += part.bytes;
    *c::required(bytes, "bytes") = sum;
  });
}

collided_status collided_scene_device(collided_scene* scene, collided_device_info* info) {
  return c::guarded([&] { write_device(SceneUse(scene)->detector->device(), info); });
}

collided_status collided_scene_positions(collided_scene* scene, uint32_t mesh, void* to, uint64_t bytes) {
  return c::guarded([&] {
    const SceneUse use(scene);
    c::required(to, "to");
    const std::vector<uint32_t>& offsets = use->detector->topology().vertex_offset;
    if (mesh >= offsets.size() - 1)
      throw InvalidInput("mesh", "mesh is " + std::to_string(mesh) + ", the scene has " +
                                     std::to_string(offsets.size() - 1) + " meshes");
    const uint64_t count = offsets[mesh + 1] - offsets[mesh];
    const uint64_t want = count * position_bytes(use->detector->spec().scalar);
    if (bytes != want)
      throw InvalidInput("bytes", "bytes is " + std::to_string(bytes) + ", but the positions of the " +
                                      std::to_string(count) + " vertices of mesh " + std::to_string(mesh) + " are " +
                                      std::to_string(want));
    if (!use->has_frame) throw c::FailedPrecondition("scene has had no frame yet, so that its vertices are nowhere");
    use->detector->read_positions({offsets[mesh], 1, count}, {static_cast<std::byte*>(to), bytes});
  });
}

collided_status collided_detect(collided_scene* scene, const collided_frame* frame, collided_result** to) {
  return c::guarded([&] {
    output(to, "result");
    *to = detect(SceneUse(scene), c::parse_frame(frame)).release();
  });
}

void collided_result_free(collided_result* result) {
  if (result == nullptr) return;
  const KeptCudaDevice kept(result->device);
  delete result;
}

collided_status collided_result_contacts(const collided_result* result, int32_t kind, collided_contacts* contacts) {
  return c::guarded([&] {
    c::required(result, "result");
    c::write_structure(contacts, contacts_of(*result, parse_kind(kind)), "contacts");
  });
}

collided_status collided_result_contacts_in_room(const collided_result* result, int32_t kind,
                                                 collided_contacts* contacts) {
  return c::guarded([&] {
    c::required(result, "result");
    c::write_structure(contacts, contacts_in_room_of(*result, parse_kind(kind)), "contacts");
  });
}

collided_status collided_result_limits(const collided_result* result, int32_t kind, collided_contacts* limits) {
  return c::guarded([&] {
    c::required(result, "result");
    c::write_structure(limits, limits_of(*result, parse_kind(kind)), "limits");
  });
}

collided_status collided_result_facts(const collided_result* result, collided_facts* facts) {
  return c::guarded([&] { c::write_structure(facts, facts_of(c::required(result, "result")->frame), "facts"); });
}

collided_status collided_result_mesh_pair(const collided_result* result, uint64_t index, collided_mesh_pair* pair) {
  return c::guarded(
      [&] { c::write_structure(pair, pair_of(at(c::required(result, "result")->frame.pair_states, index)), "pair"); });
}

collided_status collided_result_stage(const collided_result* result, uint32_t index, const char** name,
                                      double* milliseconds) {
  return c::guarded([&] {
    const StageTime& stage = at(c::required(result, "result")->frame.stages, index);
    c::required(milliseconds, "milliseconds");
    *c::required(name, "name") = stage.stage.c_str();
    *milliseconds = stage.milliseconds;
  });
}

collided_status collided_result_unused_option(const collided_result* result, uint32_t index, const char** name) {
  return c::guarded(
      [&] { *c::required(name, "name") = at(c::required(result, "result")->frame.unused_options, index).c_str(); });
}
