// Says in sentences which meshes touch.

#include "client/app/report/touching.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "client/app/report/frame_line.hpp"
#include "client/app/report/meetings.hpp"
#include "client/app/report/numbers.hpp"
#include "client/app/report/pair_states.hpp"

namespace collided::cli {

namespace {

using Pair = std::pair<size_t, size_t>;

/// Contacts between two meshes, or of a mesh with itself.
struct Found {
  client::PerKind<uint64_t> counts;
  MeetingCounts meetings;
  std::vector<size_t> crossings;            ///< the first edge-triangle contacts, at most kMaxListed
  const client::MeshPair* state = nullptr;  ///< if they are not apart, and one is a solid
};

/// The distance up to which two meshes are in contact; a mesh and itself, if both are the same.
double contact_distance(const Touching& touching, const Pair& pair) {
  return touching.spec.thickness() + touching.meshes[pair.first].half_thickness +
         touching.meshes[pair.second].half_thickness;
}

/// The meshes of both features.
Pair meshes_of(v1::ContactKind kind, const client::Contacts& contacts, size_t i, const client::SceneFeatures& scene) {
  switch (kind) {
    case v1::CONTACT_KIND_TRIANGLE_TRIANGLE:
      return {scene.mesh_of_element(contacts.elements[i][0]), scene.mesh_of_element(contacts.elements[i][1])};
    case v1::CONTACT_KIND_EDGE_TRIANGLE:
      return {scene.mesh_of_edge(contacts.elements[i][0]), scene.mesh_of_element(contacts.elements[i][1])};
    default:
      const size_t second = kind == v1::CONTACT_KIND_EDGE_EDGE ? 2 : 1;
      return {scene.mesh_of_vertex(contacts.stencils[i][0]), scene.mesh_of_vertex(contacts.stencils[i][second])};
  }
}

/// Contacts between any two meshes, and how they lie to each other.
std::map<Pair, Found> find_pairs(const Touching& touching) {
  std::map<Pair, Found> pairs;
  const bool is_exact = touching.spec.accuracy() == v1::ACCURACY_EXACT;
  const auto add = [&](v1::ContactKind kind, const client::Contacts& contacts, auto count) {
    const bool is_crossing = kind == v1::CONTACT_KIND_EDGE_TRIANGLE;
    const bool is_near = kind == v1::CONTACT_KIND_VERTEX_TRIANGLE || kind == v1::CONTACT_KIND_EDGE_EDGE;
    const bool has_stencils = is_near || kind == v1::CONTACT_KIND_VERTEX_SOLID;
    const size_t known = has_stencils ? contacts.stencils.size() : contacts.elements.size();
    for (size_t i = 0; i < known; ++i) {
      const auto [a, b] = meshes_of(kind, contacts, i, touching.scene);
      const Pair pair = std::minmax(a, b);
      Found& found = pairs[pair];
      ++(found.counts.*count);
      if (is_crossing && found.crossings.size() < kMaxListed) found.crossings.push_back(i);
      const bool is_surely_near = is_exact && contact_distance(touching, pair) == 0;
      if (is_crossing || (is_surely_near && is_near)) found.meetings.add(kind, contacts, i);
    }
  };
  client::for_each_kind(add, touching.output,
                        client::PerKind<uint64_t client::PerKind<uint64_t>::*>{
                            &client::PerKind<uint64_t>::vertex_triangle, &client::PerKind<uint64_t>::edge_edge,
                            &client::PerKind<uint64_t>::triangle_triangle, &client::PerKind<uint64_t>::edge_triangle,
                            &client::PerKind<uint64_t>::vertex_solid});
  for (const client::MeshPair& state : touching.output.pairs)
    pairs[{state.first, client::checked_id("mesh", state.second, touching.meshes.size())}].state = &state;
  return pairs;
}

uint64_t sum_of(const client::PerKind<uint64_t>& found) {
  uint64_t sum = 0;
  client::for_each_kind([&](v1::ContactKind, uint64_t count) { sum += count; }, found);
  return sum;
}

std::string plural(uint64_t count, const std::string& noun) {
  return count_text(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string counts_text(const client::PerKind<uint64_t>& found) {
  std::string kinds;
  const auto add = [&](uint64_t count, const std::string& kind) {
    if (count > 0) kinds += (kinds.empty() ? "" : ", ") + count_text(count) + " " + kind;
  };
  add(found.vertex_triangle, "vertex-triangle");
  add(found.edge_edge, "edge-edge");
  add(found.triangle_triangle, "triangle-triangle");
  add(found.edge_triangle, "edge-triangle");
  add(found.vertex_solid, "vertex-solid");
  return plural(sum_of(found), "contact") + " (" + kinds + ")";
}

std::string thickness_text(double distance) {
  return distance > 0 ? " at a thickness of " + format_double("%.6g", distance) : "";
}

std::string distance_text(const Touching& touching, const Pair& pair) {
  return thickness_text(contact_distance(touching, pair));
}

/// Those of all pairs, which may differ.
std::string distances_text(const Touching& touching) {
  if (touching.meshes.size() == 1) return distance_text(touching, {0, 0});
  if (touching.meshes.size() == 2) return distance_text(touching, {0, 1});
  const auto is_thick = [](const client::MeshInput& mesh) { return mesh.half_thickness > 0; };
  const std::string text = thickness_text(touching.spec.thickness());
  if (!std::ranges::any_of(touching.meshes, is_thick)) return text;
  return text + (text.empty() ? " at" : " and") + " half thicknesses of their own";
}

PairPlace place_of(const Touching& touching) { return {touching.meshes, touching.scene, touching.output}; }

std::string pair_text(const Touching& touching, const Pair& pair, bool touches) {
  const std::string& first = touching.meshes[pair.first].name;
  if (pair.first == pair.second) return first + (touches ? " touches itself" : " does not touch itself");
  return first + " and " + touching.meshes[pair.second].name + (touches ? " touch" : " do not touch");
}

/// A line on the edges of two meshes that go through triangles, if there are any.
std::string crossings_text(const Touching& touching, const Found& found) {
  if (found.crossings.empty()) return "";
  const client::Contacts& crossings = touching.output.edge_triangle;
  const MeetingPlace place{touching.meshes, touching.scene, touching.positions};
  return "\n  " + meetings_text(found.meetings) +
         "; the first: " + meeting_text(v1::CONTACT_KIND_EDGE_TRIANGLE, crossings, found.crossings[0], place);
}

struct Box {
  scenes::Vec3d lower{}, upper{};
  bool contains(const Box& o) const {
    for (size_t k = 0; k < 3; ++k)
      if (o.lower[k] < lower[k] || o.upper[k] > upper[k]) return false;
    return true;
  }
};

Box box_of(std::span<const scenes::Vec3d> positions) {
  Box box{positions.front(), positions.front()};
  for (const scenes::Vec3d& p : positions)
    for (size_t k = 0; k < 3; ++k)
      box.lower[k] = std::min(box.lower[k], p[k]), box.upper[k] = std::max(box.upper[k], p[k]);
  return box;
}

/// Says how two meshes that are not apart lie to each other, and what contacts they have.
std::string found_text(const Touching& touching, const Pair& pair, const Found& found) {
  const std::string head = found.state ? state_text(*found.state, place_of(touching)) : pair_text(touching, pair, true);
  const std::string contacts = sum_of(found.counts) > 0 ? ": " + counts_text(found.counts) : "";
  return head + distance_text(touching, pair) + contacts + crossings_text(touching, found) +
         (found.state ? inside_text(*found.state, place_of(touching)) : "");
}

/// Explains a missing contact that a newcomer may expect: meshes are surfaces, unless --solid names them.
std::string surfaces_text(const Touching& touching) {
  std::vector<Box> boxes;
  size_t at = 0;
  for (const client::MeshInput& mesh : touching.meshes) {
    boxes.push_back(box_of(touching.positions.subspan(at, mesh.vertex_count)));
    at += mesh.vertex_count;
  }
  for (size_t a = 0; a < boxes.size(); ++a)
    for (size_t b = 0; b < boxes.size(); ++b)
      if (a != b && boxes[a].contains(boxes[b]) && !touching.meshes[a].solid)
        return "; the box around " + touching.meshes[b].name + " is within that around " + touching.meshes[a].name +
               ", but meshes are surfaces: one wholly inside another has no contact; --solid looks inside";
  return "";
}

}  // namespace

Json touching_json(const Touching& touching) {
  Json out = Json::array();
  const MeetingPlace place{touching.meshes, touching.scene, touching.positions};
  for (const auto& [pair, found] : find_pairs(touching)) {
    Json& entry =
        out.emplace_back(Json{{"meshes", {touching.meshes[pair.first].name, touching.meshes[pair.second].name}},
                              {"contact_count", sum_of(found.counts)}});
    if (found.state) entry.update(state_json(*found.state, place_of(touching)));
    if (!asks_for_crossings(touching.spec)) continue;
    entry.update(meeting_counts_json(found.meetings));
    entry["crossings"] = Json::array();
    for (const size_t i : found.crossings)
      entry["crossings"].push_back(
          meeting_json(v1::CONTACT_KIND_EDGE_TRIANGLE, touching.output.edge_triangle, i, place));
  }
  return out;
}

std::string touching_text(const Touching& touching) {
  const size_t meshes = touching.meshes.size();
  const Pair all{0, meshes - 1};
  const std::string distance = distances_text(touching);
  if (!touching.output.done.any_contact() && touching.output.pairs.empty())
    return (meshes <= 2 ? pair_text(touching, all, false) : "none of the " + std::to_string(meshes) + " meshes touch") +
           distance + surfaces_text(touching);
  const auto pairs = find_pairs(touching);
  if (pairs.empty())  // only whether there is a contact was asked
    return (meshes <= 2 ? pair_text(touching, all, true) : "some of the " + std::to_string(meshes) + " meshes touch") +
           distance;
  std::string text;
  for (const auto& [pair, found] : pairs) text += (text.empty() ? "" : "\n") + found_text(touching, pair, found);
  const auto between = static_cast<size_t>(std::count_if(
      pairs.begin(), pairs.end(), [](const auto& pair) { return pair.first.first != pair.first.second; }));
  const size_t others = meshes * (meshes - 1) / 2 - between;
  if (meshes > 2 && others > 0)
    text +=
        others == 1 ? "\nthe other pair does not touch" : "\nthe other " + count_text(others) + " pairs do not touch";
  return text;
}

std::string step_text(const std::string& name, const Touching& touching) {
  const v1::FrameDone& done = touching.output.done;
  const v1::SceneSpec& spec = touching.spec;
  std::string text =
      name + (done.any_contact() ? ": there is contact" : ": there is no contact") + distances_text(touching);
  if (done.any_contact() && spec.report() != v1::REPORT_ANY_HIT) text += ", " + plural(done.contact_count(), "contact");
  if (done.any_contact() && has_times(done, spec))
    text += ", the first at " + format_double("%.6g", done.earliest_toi()) + " of the step";
  return text;
}

}  // namespace collided::cli
