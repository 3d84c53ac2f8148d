// How two meshes, one of them a solid, lie to each other, in words and as JSON.

#include "client/app/report/pair_states.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "client/app/report/numbers.hpp"

namespace collided::cli {

namespace {

using client::MeshPair;
using Direction = std::array<float, 3>;

bool has_deepest(const MeshPair& pair) { return pair.deepest != MeshPair::kNoVertex; }

/// The shortest way out for the deepest vertex, as its contact with the other mesh has it.
std::optional<Direction> way_out(const MeshPair& pair, const PairPlace& place) {
  const client::Contacts& contacts = place.output.vertex_solid;
  if (!has_deepest(pair) || contacts.elements.empty() || contacts.normals.empty()) return {};
  const size_t other = place.scene.mesh_of_vertex(pair.deepest) == pair.first ? pair.second : pair.first;
  const auto is_deepest = [&](const std::array<uint32_t, 2>& elements) {
    return elements[0] == pair.deepest && place.scene.mesh_of_element(elements[1]) == other;
  };
  const auto found = std::ranges::find_if(contacts.elements, is_deepest);
  if (found == contacts.elements.end()) return {};
  return contacts.normals[static_cast<size_t>(found - contacts.elements.begin())];
}

std::string vertices_text(uint32_t count, const std::string& mesh, const std::string& other) {
  return count_text(count) + (count == 1 ? " vertex of " : " vertices of ") + mesh + " inside " + other;
}

std::string deepest_text(const MeshPair& pair, const PairPlace& place) {
  const size_t mesh = place.scene.mesh_of_vertex(pair.deepest);
  std::string text = "; the deepest, vertex " + std::to_string(pair.deepest - place.scene.first_vertex(mesh)) + " of " +
                     place.meshes[mesh].name + ", is " + format_double("%.6g", pair.depth) + " below the surface";
  if (const auto out = way_out(pair, place))
    text += "; out along (" + format_double("%.6g", (*out)[0]) + ", " + format_double("%.6g", (*out)[1]) + ", " +
            format_double("%.6g", (*out)[2]) + ")";
  return text;
}

const char* word_of(v1::MeshPairState state) {
  switch (state) {
    case v1::MESH_PAIR_STATE_TOUCHING:
      return "touching";
    case v1::MESH_PAIR_STATE_OVERLAPPING:
      return "overlapping";
    case v1::MESH_PAIR_STATE_FIRST_INSIDE:
      return "first_inside";
    case v1::MESH_PAIR_STATE_SECOND_INSIDE:
      return "second_inside";
    default:
      return "unspecified";
  }
}

}  // namespace

std::string state_text(const MeshPair& pair, const PairPlace& place) {
  const std::string &first = place.meshes[pair.first].name, &second = place.meshes[pair.second].name;
  if (pair.state == v1::MESH_PAIR_STATE_FIRST_INSIDE) return first + " is inside " + second;
  if (pair.state == v1::MESH_PAIR_STATE_SECOND_INSIDE) return second + " is inside " + first;
  return first + " and " + second + (pair.state == v1::MESH_PAIR_STATE_TOUCHING ? " touch" : " overlap");
}

std::string inside_text(const MeshPair& pair, const PairPlace& place) {
  const std::string &first = place.meshes[pair.first].name, &second = place.meshes[pair.second].name;
  std::string text;
  if (pair.first_inside > 0) text = vertices_text(pair.first_inside, first, second);
  if (pair.second_inside > 0) text += (text.empty() ? "" : ", ") + vertices_text(pair.second_inside, second, first);
  return text.empty() ? "" : "\n  " + text + (has_deepest(pair) ? deepest_text(pair, place) : "");
}

Json state_json(const MeshPair& pair, const PairPlace& place) {
  Json out = {
      {"state", word_of(pair.state)}, {"inside_count", {pair.first_inside, pair.second_inside}}, {"deepest", nullptr}};
  if (!has_deepest(pair)) return out;
  const size_t mesh = place.scene.mesh_of_vertex(pair.deepest);
  const auto direction = way_out(pair, place);
  out["deepest"] = {{"mesh", place.meshes[mesh].name},
                    {"vertex", pair.deepest - place.scene.first_vertex(mesh)},
                    {"depth", pair.depth},
                    {"direction", direction ? Json(*direction) : Json(nullptr)}};
  return out;
}

}  // namespace collided::cli
