// Packed little-endian arrays to vectors.

#include "client/cpp/contacts.hpp"

#include <bit>
#include <cstring>
#include <string>

#include "client/cpp/transport/frame_transport.hpp"

namespace collided::client {

// The wire is little-endian, like every machine that this library is built for, so arrays are copied as they are.
static_assert(std::endian::native == std::endian::little);

namespace {

constexpr int kDataLoss = 15;

// Of the numbers of fields 0 and 9 are none, and the states of pairs of meshes are no column.
static_assert(kColumnCount + 3 == v1::ContactField_ARRAYSIZE, "a field of contacts has no column");

/// visit(name, bytes in the message, range in shared memory, array of each of `structs`) for each column.
template <class Visit, class... Structs>
void for_each_array(const v1::ContactChunk& chunk, const Visit& visit, Structs&... structs) {
  const v1::SharedArrays& shared = chunk.shared();
  visit("elements", chunk.elements(), shared.elements(), structs.elements...);
  visit("stencils", chunk.stencils(), shared.stencils(), structs.stencils...);
  visit("toi", chunk.toi(), shared.toi(), structs.toi...);
  visit("distance", chunk.distance(), shared.distance(), structs.distance...);
  visit("weights", chunk.weights(), shared.weights(), structs.weights...);
  visit("normals", chunk.normals(), shared.normals(), structs.normals...);
  visit("flags", chunk.flags(), shared.flags(), structs.flags...);
  visit("features", chunk.features(), shared.features(), structs.features...);
  visit("signed_distances", chunk.signed_distances(), shared.signed_distances(), structs.signed_distances...);
}

/// Arrays of one chunk, in the message or in shared memory.
class Arrays {
 public:
  Arrays(Contacts& contacts, const v1::ContactChunk& chunk, const FrameTransport* transport)
      : chunk_(chunk), transport_(transport), before_(contacts.count) {}

  template <class T>
  void append(const char* field, const std::string& own, const v1::SharedRange& range, std::vector<T>& out) const {
    std::span<const std::byte> bytes = std::as_bytes(std::span(own));
    if (range.size() > 0 && transport_ != nullptr) bytes = transport_->shared(range);
    if (bytes.empty() && out.empty()) return;
    if (bytes.size() != chunk_.count() * sizeof(T) || out.size() != before_)
      throw Error(kDataLoss, std::string("contacts.") + field + " has " + std::to_string(bytes.size()) + " bytes for " +
                                 std::to_string(chunk_.count()) + " contacts; it needs " +
                                 std::to_string(chunk_.count() * sizeof(T)));
    if (reinterpret_cast<uintptr_t>(bytes.data()) % alignof(T) == 0) {  // no entry is written twice
      const T* const first = reinterpret_cast<const T*>(bytes.data());
      out.insert(out.end(), first, first + chunk_.count());
      return;
    }
    out.resize(before_ + chunk_.count());
    std::memcpy(out.data() + before_, bytes.data(), bytes.size());
  }

 private:
  const v1::ContactChunk& chunk_;
  const FrameTransport* transport_;
  uint64_t before_;
};

/// A count that no array confirms must not make callers reserve memory for nothing.
constexpr uint64_t kMaxBareCount = 1 << 24;

void check_distance(v1::ContactKind kind, double distance) {
  const bool is_depth = kind == v1::CONTACT_KIND_VERTEX_SOLID;
  if (!(is_depth ? distance <= 0 : distance >= 0))
    throw Error(kDataLoss, "contacts.distance has " + std::to_string(distance) + "; it must be 0 or " +
                               (is_depth ? "less" : "more"));
}

void check_numbers(v1::ContactKind kind, const Contacts& contacts, uint64_t first) {
  for (size_t i = first; i < contacts.toi.size(); ++i)
    if (!(contacts.toi[i] >= 0 && contacts.toi[i] <= 1))
      throw Error(kDataLoss, "contacts.toi has " + std::to_string(contacts.toi[i]) + "; it must be in [0, 1]");
  for (size_t i = first; i < contacts.distance.size(); ++i) check_distance(kind, contacts.distance[i]);
  bool is_bare = true;
  for_each_column([&](v1::ContactField, auto column) { is_bare &= (contacts.*column).empty(); });
  if (is_bare && contacts.count > kMaxBareCount)
    throw Error(kDataLoss, "contacts.count is " + std::to_string(contacts.count) +
                               " in all without any array; it must be " + "at most " + std::to_string(kMaxBareCount));
}

}  // namespace

void append(Contacts& contacts, const v1::ContactChunk& chunk, const FrameTransport* transport) {
  if (chunk.count() == 0) throw Error(kDataLoss, "contacts.count is 0; a chunk has 1 contact or more");
  const Arrays arrays(contacts, chunk, transport);
  const uint64_t before = contacts.count;
  for_each_array(
      chunk,
      [&](const char* field, const std::string& own, const v1::SharedRange& range, auto& out) {
        arrays.append(field, own, range, out);
      },
      contacts);
  arrays.append("worlds", chunk.worlds(), chunk.shared().worlds(), contacts.worlds);
  contacts.count += chunk.count();
  check_numbers(chunk.kind(), contacts, before);
}

Contacts kept(const Contacts& contacts) {
  std::vector<size_t> places;
  for (size_t i = 0; i < contacts.count; ++i)
    if (contacts.flags.empty() || (contacts.flags[i] & v1::CONTACT_FLAG_COVERED) == 0) places.push_back(i);
  Contacts out;
  out.count = places.size();
  const auto copy = [&](auto column) {
    if ((contacts.*column).empty()) return;
    for (const size_t i : places) (out.*column).push_back((contacts.*column)[i]);
  };
  for_each_column([&](v1::ContactField, auto column) { copy(column); });
  copy(&Contacts::worlds);
  return out;
}

SceneSize size_of(const v1::SceneSpec& spec) {
  SceneSize size{.meshes = static_cast<uint64_t>(spec.meshes_size())};
  for (const v1::MeshSpec& mesh : spec.meshes()) {
    size.vertices += mesh.vertex_count();
    size.elements += uint64_t{mesh.triangle_count()} + mesh.edge_count() + mesh.point_count();
  }
  return size;
}

void check_ids(v1::ContactKind kind, const Contacts& contacts, uint64_t first, const SceneSize& size) {
  const auto check = [](const char* field, uint32_t id, uint64_t limit, const char* what) {
    if (id < limit) return;
    throw Error(kDataLoss, std::string("contacts.") + field + " names " + std::to_string(id) + "; the scene has " +
                               std::to_string(limit) + what);
  };
  for (size_t i = first; i < contacts.stencils.size(); ++i)
    for (const uint32_t vertex : contacts.stencils[i]) check("stencils", vertex, size.vertices, " vertices");
  for (size_t i = first; i < contacts.elements.size(); ++i) {
    const auto [a, b] = contacts.elements[i];
    const bool is_edges = kind == v1::CONTACT_KIND_EDGE_EDGE;
    const auto check_edge = [&](uint32_t id) { check("elements", id, 3 * size.elements, " edges at most"); };
    const auto check_element = [&](uint32_t id) { check("elements", id, size.elements, " elements"); };
    if (kind == v1::CONTACT_KIND_VERTEX_TRIANGLE || kind == v1::CONTACT_KIND_VERTEX_SOLID)
      check("elements", a, size.vertices, " vertices");
    else
      is_edges || kind == v1::CONTACT_KIND_EDGE_TRIANGLE ? check_edge(a) : check_element(a);
    is_edges ? check_edge(b) : check_element(b);
  }
}

DeviceContacts on_device(const v1::ContactChunk& chunk, uint64_t bytes) {
  DeviceContacts contacts;
  contacts.count = chunk.count();
  const auto name = [&](const char* field, const std::string&, const v1::SharedRange& range, DeviceArray& array,
                        const auto& on_host) {
    array = {range.offset(), range.size()};
    const uint64_t width = sizeof(on_host[0]);
    const bool fits = array.bytes <= bytes && array.offset <= bytes - array.bytes;
    if (array.bytes == 0 || (fits && array.bytes == contacts.count * width)) return;
    throw Error(kDataLoss,
                std::string("contacts.shared.") + field + " has " + std::to_string(array.bytes) + " bytes at offset " +
                    std::to_string(array.offset) + " for " + std::to_string(contacts.count) + " contacts; it needs " +
                    std::to_string(contacts.count * width) + ", and the output region has " + std::to_string(bytes));
  };
  const Contacts types;
  for_each_array(chunk, name, contacts, types);
  return contacts;
}

}  // namespace collided::client
