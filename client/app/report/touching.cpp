// Says in sentences which meshes touch.

#include "client/app/report/touching.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "client/app/output/contact_points.hpp"
#include "client/app/report/frame_line.hpp"
#include "client/app/report/numbers.hpp"

namespace collided::cli {

namespace {

using Pair = std::pair<size_t, size_t>;

/// The mesh that an id belongs to. `ends`: the first id behind each mesh. Throws client::Error (DATA_LOSS) for an id
/// that the scene does not have.
size_t mesh_of(uint32_t id, const std::vector<uint64_t>& ends) {
  checked_id("id", id, ends.empty() ? 0 : ends.back());
  return static_cast<size_t>(std::upper_bound(ends.begin(), ends.end(), uint64_t{id}) - ends.begin());
}

struct Ends {
  std::vector<uint64_t> vertices, elements;

  explicit Ends(std::span<const client::MeshInput> meshes) {
    uint64_t vertex = 0, element = 0;
    for (const client::MeshInput& mesh : meshes) {
      vertices.push_back(vertex += mesh.vertex_count);
      elements.push_back(element += mesh.triangles.size() + mesh.edges.size() + mesh.points.size());
    }
  }
};

/// The first edge behind each mesh. Two elements of a mesh may share an edge, which counts once.
std::vector<uint64_t> edge_ends(std::span<const client::MeshInput> meshes) {
  std::vector<uint64_t> ends;
  uint64_t end = 0;
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const client::MeshInput& mesh : meshes) {
    edges.clear();
    for (const auto& t : mesh.triangles)
      for (size_t k = 0; k < 3; ++k) edges.emplace_back(std::minmax(t[k], t[(k + 1) % 3]));
    for (const auto& e : mesh.edges) edges.emplace_back(std::minmax(e[0], e[1]));
    std::ranges::sort(edges);
    ends.push_back(end += static_cast<uint64_t>(std::unique(edges.begin(), edges.end()) - edges.begin()));
  }
  return ends;
}

/// Contacts of each kind between two meshes.
std::map<Pair, client::PerKind<uint64_t>> count_pairs(const Touching& touching) {
  std::map<Pair, client::PerKind<uint64_t>> pairs;
  const Ends ends(touching.meshes);
  const auto add = [&](size_t a, size_t b, uint64_t client::PerKind<uint64_t>::*kind) {
    ++(pairs[std::minmax(a, b)].*kind);
  };
  for (const auto& v : touching.output.vertex_triangle.stencils)
    add(mesh_of(v[0], ends.vertices), mesh_of(v[1], ends.vertices), &client::PerKind<uint64_t>::vertex_triangle);
  for (const auto& v : touching.output.edge_edge.stencils)
    add(mesh_of(v[0], ends.vertices), mesh_of(v[2], ends.vertices), &client::PerKind<uint64_t>::edge_edge);
  for (const auto& e : touching.output.triangle_triangle.elements)
    add(mesh_of(e[0], ends.elements), mesh_of(e[1], ends.elements), &client::PerKind<uint64_t>::triangle_triangle);
  if (touching.output.edge_triangle.elements.empty()) return pairs;
  const std::vector<uint64_t> edges = edge_ends(touching.meshes);
  for (const auto& e : touching.output.edge_triangle.elements)
    add(mesh_of(e[0], edges), mesh_of(e[1], ends.elements), &client::PerKind<uint64_t>::edge_triangle);
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
  return plural(sum_of(found), "contact") + " (" + kinds + ")";
}

std::string thickness_text(double distance) {
  return distance > 0 ? " at a thickness of " + format_double("%.6g", distance) : "";
}

/// The distance up to which two meshes are in contact; a mesh and itself, if both are the same.
std::string distance_text(const Touching& touching, const Pair& pair) {
  return thickness_text(touching.spec.thickness() + touching.meshes[pair.first].half_thickness +
                        touching.meshes[pair.second].half_thickness);
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

std::string pair_text(const Touching& touching, const Pair& pair, bool touches) {
  const std::string& first = touching.meshes[pair.first].name;
  if (pair.first == pair.second) return first + (touches ? " touches itself" : " does not touch itself");
  return first + " and " + touching.meshes[pair.second].name + (touches ? " touch" : " do not touch");
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

/// Explains a missing contact that a newcomer may expect: meshes are surfaces, not solids.
std::string inside_text(const Touching& touching) {
  std::vector<Box> boxes;
  size_t at = 0;
  for (const client::MeshInput& mesh : touching.meshes) {
    boxes.push_back(box_of(touching.positions.subspan(at, mesh.vertex_count)));
    at += mesh.vertex_count;
  }
  for (size_t a = 0; a < boxes.size(); ++a)
    for (size_t b = 0; b < boxes.size(); ++b)
      if (a != b && boxes[a].contains(boxes[b]))
        return "; the box around " + touching.meshes[b].name + " is within that around " + touching.meshes[a].name +
               ", but meshes are surfaces: one wholly inside another has no contact";
  return "";
}

}  // namespace

Json touching_json(const Touching& touching) {
  Json out = Json::array();
  for (const auto& [pair, found] : count_pairs(touching))
    out.push_back({{"meshes", {touching.meshes[pair.first].name, touching.meshes[pair.second].name}},
                   {"contact_count", sum_of(found)}});
  return out;
}

std::string touching_text(const Touching& touching) {
  const size_t meshes = touching.meshes.size();
  const Pair all{0, meshes - 1};
  const std::string distance = distances_text(touching);
  if (!touching.output.done.any_contact())
    return (meshes <= 2 ? pair_text(touching, all, false) : "none of the " + std::to_string(meshes) + " meshes touch") +
           distance + inside_text(touching);
  const auto pairs = count_pairs(touching);
  if (pairs.empty())  // only whether there is a contact was asked
    return (meshes <= 2 ? pair_text(touching, all, true) : "some of the " + std::to_string(meshes) + " meshes touch") +
           distance;
  std::string text;
  for (const auto& [pair, found] : pairs)
    text += (text.empty() ? "" : "\n") + pair_text(touching, pair, true) + distance_text(touching, pair) + ": " +
            counts_text(found);
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
