// The kinds of contacts as the protocol has them.
#include "server/convert/kinds.hpp"

#include <vector>

#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

// What the protocol does not have of a kind is null.
struct Kind {
  using SetCount = void (pb::FrameCounts::*)(uint64_t);
  using SetBytes = void (pb::ContactBytes::*)(uint32_t);

  pb::ContactKind message;
  SetBytes set_bytes;
  SetCount set_candidates, set_survivors, set_contacts;
};

constexpr PerKind<Kind> kKinds{
    .vertex_triangle = {pb::CONTACT_KIND_VERTEX_TRIANGLE, &pb::ContactBytes::set_vertex_triangle,
                        &pb::FrameCounts::set_candidates_vertex_triangle,
                        &pb::FrameCounts::set_survivors_vertex_triangle,
                        &pb::FrameCounts::set_contacts_vertex_triangle},
    .edge_edge = {pb::CONTACT_KIND_EDGE_EDGE, &pb::ContactBytes::set_edge_edge,
                  &pb::FrameCounts::set_candidates_edge_edge, &pb::FrameCounts::set_survivors_edge_edge,
                  &pb::FrameCounts::set_contacts_edge_edge},
    .triangle_triangle = {pb::CONTACT_KIND_TRIANGLE_TRIANGLE, &pb::ContactBytes::set_triangle_triangle, nullptr,
                          nullptr, &pb::FrameCounts::set_contacts_triangle_triangle},
    .edge_triangle = {pb::CONTACT_KIND_EDGE_TRIANGLE, &pb::ContactBytes::set_edge_triangle, nullptr, nullptr,
                      &pb::FrameCounts::set_contacts_edge_triangle},
    .vertex_solid = {pb::CONTACT_KIND_VERTEX_SOLID, &pb::ContactBytes::set_vertex_solid, nullptr, nullptr,
                     &pb::FrameCounts::set_contacts_vertex_solid}};

bool& wanted(SceneSpec& engine, pb::ContactKind message, int index) {
  bool* found = nullptr;
  std::vector<pb::ContactKind> usable;
  for_each_kind(
      [&](ContactKind, const Kind& kind, bool& is_wanted) {
        usable.push_back(kind.message);
        if (kind.message == message) found = &is_wanted;
      },
      kKinds, engine.kinds);
  if (found == nullptr) throw_unknown(fmt::format("spec.kinds[{}]", index), message, usable);
  return *found;
}

}  // namespace

void parse_kinds(const pb::SceneSpec& spec, SceneSpec& engine) {
  if (spec.kinds().empty()) return;
  engine.kinds = {};
  for (int i = 0; i < spec.kinds_size(); ++i) wanted(engine, spec.kinds(i), i) = true;
}

void fill_kinds(const SceneSpec& engine, pb::SceneSpec* out) {
  for_each_kind(
      [&](ContactKind, const Kind& kind, bool is_wanted) {
        if (is_wanted) out->add_kinds(kind.message);
      },
      kKinds, engine.kinds);
}

pb::ContactKind to_message(ContactKind kind) { return value_of(kKinds, kind).message; }

void fill_counts_of_kinds(const FrameCounts& counts, pb::FrameCounts* out) {
  const auto set = [&](Kind::SetCount setter, uint64_t count) {
    if (setter != nullptr) (out->*setter)(count);
  };
  for_each_kind(
      [&](ContactKind, const Kind& kind, uint64_t candidates, uint64_t survivors, uint64_t contacts) {
        set(kind.set_candidates, candidates);
        set(kind.set_survivors, survivors);
        set(kind.set_contacts, contacts);
      },
      kKinds, counts.candidates, counts.survivors, counts.contacts);
}

void fill_bytes_of_kinds(const PerKind<uint32_t>& bytes, pb::ContactBytes* out) {
  for_each_kind([&](ContactKind, const Kind& kind, uint32_t of_kind) { (out->*kind.set_bytes)(of_kind); }, kKinds,
                bytes);
}

}  // namespace collided::server
