#include "gpu/tables/fans.hpp"

namespace collided {
namespace {

/// use(vertex) for each vertex in whose fan the element is.
template <class Use>
void for_each_vertex(const std::array<uint32_t, 3>& element, const Use& use) {
  const auto& [a, b, c] = element;
  if (a == b) return;  // a loose point
  use(a), use(b);
  if (c != b) use(c);  // else a loose edge
}

}  // namespace

FanTables make_fans(const Topology& topology, MemoryHold& making, Asks& asks) {
  constexpr size_t kAtATime = 1u << 14;
  const auto& elements = topology.triangles;
  const uint64_t vertices = uint64_t{topology.vertex_count} + 1, most = 3 * elements.size();
  making.resize(making.bytes() + (vertices + most) * sizeof(uint32_t));
  FanTables out;
  out.begin.assign(vertices, 0);
  for (size_t i = 0; i < elements.size(); ++i) {
    if (i % kAtATime == 0) asks.ask_if_due();
    for_each_vertex(elements[i], [&](uint32_t v) { ++out.begin[v]; });
  }
  for (size_t v = 1; v < out.begin.size(); ++v) out.begin[v] += out.begin[v - 1];
  out.elements.resize(out.begin.back());
  // From the last element on, so that each fan is ascending.
  for (size_t i = elements.size(); i-- > 0;) {
    if (i % kAtATime == 0) asks.ask_if_due();
    for_each_vertex(elements[i], [&](uint32_t v) { out.elements[--out.begin[v]] = static_cast<uint32_t>(i); });
  }
  return out;
}

}  // namespace collided
