#include "gpu/scene/known_lengths.hpp"

#include <functional>
#include <string_view>

#include "gpu/contacts/kinds.hpp"

namespace collided {
namespace {

class Hash {
 public:
  template <class T>
  void add(const T* values, size_t count) {
    const std::string_view bytes(reinterpret_cast<const char*>(values), count * sizeof(T));
    value_ = value_ * 0x9e3779b97f4a7c15u + std::hash<std::string_view>{}(bytes);
  }
  template <class... T>
  void add_each(T... values) {
    (add(&values, 1), ...);
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0;
};

}  // namespace

ListLengths KnownLengths::of(uint64_t scene) const {
  const std::lock_guard lock(mutex_);
  for (const Known& known : known_)
    if (known.scene == scene) return known.lengths;
  return {};
}

void KnownLengths::learn(uint64_t scene, const ListLengths& lengths) {
  const std::lock_guard lock(mutex_);
  std::erase_if(known_, [&](const Known& known) { return known.scene == scene; });
  if (known_.size() == kMost) known_.pop_back();
  known_.push_front({scene, lengths});
}

uint64_t hash_of_scene(const SceneSpec& spec, const Topology& topology) {
  Hash hash;
  hash.add(topology.triangles.data(), topology.triangles.size());
  hash.add(topology.edges.data(), topology.edges.size());
  hash.add_each(topology.vertex_count, spec.worlds, spec.device.backend, spec.mode, spec.accuracy, spec.scalar,
                spec.engine, spec.report, spec.thickness, spec.delta, spec.min_separation, spec.kinds.vertex_triangle,
                spec.kinds.edge_edge, spec.kinds.triangle_triangle, kinds_looked_for(spec).edge_triangle);
  for (const MeshSpec& mesh : spec.meshes) hash.add_each(mesh.half_thickness);
  return hash.value();
}

void expect_known_lengths(SceneSpec& spec, const Topology& topology) {
  if (spec.known) spec.expected.include(spec.known->of(hash_of_scene(spec, topology)));
}

}  // namespace collided
