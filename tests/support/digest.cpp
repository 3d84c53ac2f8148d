#include "tests/support/digest.hpp"

#include <cstring>

namespace collided::test {
namespace {

constexpr uint64_t kFnvOffset = 14695981039346656037ull;
constexpr uint64_t kFnvPrime = 1099511628211ull;

uint64_t mix(uint64_t hash, const void* data, size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * kFnvPrime;
  return hash;
}

// The length is hashed, too: two arrays must not pass for one.
template <class T>
uint64_t mix(uint64_t hash, const Column<T>& values) {
  const uint64_t size = values.size();
  hash = mix(hash, &size, sizeof size);
  return values.empty() ? hash : mix(hash, values.data(), size * sizeof(T));
}

template <class T>
bool same(const Column<T>& a, const Column<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

// Normals come last, and only where there are some: digests of results without them are those of the time before they
// were there.
uint64_t digest(const ContactSet& c, uint64_t seed) {
  const uint64_t before = mix(mix(mix(mix(mix(seed, c.elements), c.toi), c.distance), c.weights), c.flags);
  return c.normals.empty() ? before : mix(before, c.normals);
}

uint64_t digest(const FrameResult& result) {
  return digest(result.edge_edge, digest(result.vertex_triangle, kFnvOffset));
}

bool same_bytes(const ContactSet& a, const ContactSet& b) {
  bool all = true;
  for_each_field([&](ContactField, const auto& x, const auto& y) { all = all && same(x, y); }, a, b);
  return all;
}

bool same_contacts(const FrameResult& a, const FrameResult& b) {
  return same_bytes(a.vertex_triangle, b.vertex_triangle) && same_bytes(a.edge_edge, b.edge_edge);
}

}  // namespace collided::test
