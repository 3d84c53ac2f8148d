// Pairs of features that go through each other or touch, in words and as JSON.

#include "client/app/report/meetings.hpp"

#include "client/app/report/contacts.hpp"
#include "client/app/report/numbers.hpp"

namespace collided::cli {

namespace {

bool is_crossing(v1::ContactKind kind) { return kind == v1::CONTACT_KIND_EDGE_TRIANGLE; }

bool is_touching(const client::Contacts& contacts, size_t i) {
  return !contacts.flags.empty() && (contacts.flags[i] & v1::CONTACT_FLAG_TOUCHING) != 0;
}

/// Names features by ids within their meshes.
class Names {
 public:
  Names(const MeetingPlace& place, size_t first_mesh, size_t second_mesh)
      : place_(place), is_one_(first_mesh == second_mesh) {}

  std::string vertex(uint32_t id) const {
    const size_t mesh = place_.scene.mesh_of_vertex(id);
    return "vertex " + local(id, mesh) + of(mesh);
  }
  std::string edge(uint32_t a, uint32_t b) const {
    const size_t mesh = place_.scene.mesh_of_vertex(a);
    return "edge " + local(a, mesh) + "-" + local(b, mesh) + of(mesh);
  }
  std::string element(uint32_t id) const {
    const size_t mesh = place_.scene.mesh_of_element(id);
    return "triangle " + std::to_string(id - place_.scene.first_element(mesh)) + of(mesh);
  }

 private:
  std::string local(uint32_t vertex, size_t mesh) const {
    return std::to_string(vertex - place_.scene.first_vertex(mesh));
  }
  std::string of(size_t mesh) const { return is_one_ ? "" : " of " + place_.meshes[mesh].name; }

  const MeetingPlace& place_;
  bool is_one_;
};

std::string point_text(const std::array<double, 3>& point) {
  return " at (" + format_double("%.6g", point[0]) + ", " + format_double("%.6g", point[1]) + ", " +
         format_double("%.6g", point[2]) + ")";
}

std::array<double, 3> point_of(v1::ContactKind kind, const client::Contacts& contacts, size_t i,
                               const MeetingPlace& place) {
  const auto points = contact_points(kind, contacts, i, {{}, place.positions, &place.scene});
  return points ? points->first : std::array<double, 3>{};
}

std::string features_text(v1::ContactKind kind, const client::Contacts& contacts, size_t i, const MeetingPlace& place) {
  const client::SceneFeatures& scene = place.scene;
  const auto [first, second] = contacts.elements[i];
  if (is_crossing(kind)) {
    const auto& [a, b] = scene.edge(first);
    const Names names(place, scene.mesh_of_edge(first), scene.mesh_of_element(second));
    return names.edge(a, b) + (is_touching(contacts, i) ? " on " : " through ") + names.element(second);
  }
  const auto& v = contacts.stencils[i];
  const bool is_vertex = kind == v1::CONTACT_KIND_VERTEX_TRIANGLE;
  const Names names(place, scene.mesh_of_vertex(v[0]), scene.mesh_of_vertex(v[is_vertex ? 1 : 2]));
  return is_vertex ? names.vertex(v[0]) + " on " + names.element(second)
                   : names.edge(v[0], v[1]) + " on " + names.edge(v[2], v[3]);
}

}  // namespace

void MeetingCounts::add(v1::ContactKind kind, const client::Contacts& contacts, size_t i) {
  ++(is_crossing(kind) && !is_touching(contacts, i) ? crossing : touching);
}

std::string meetings_text(const MeetingCounts& counts) {
  std::string text;
  if (counts.crossing > 0)
    text = counts.crossing == 1 ? "1 edge goes through a triangle"
                                : count_text(counts.crossing) + " edges go through triangles";
  if (counts.touching > 0)
    text += (text.empty() ? "" : ", ") + count_text(counts.touching) +
            (counts.touching == 1 ? " pair touches" : " pairs touch");
  return text;
}

Json meeting_counts_json(const MeetingCounts& counts) {
  return {{"crossing_count", counts.crossing}, {"touching_count", counts.touching}};
}

std::string meeting_text(v1::ContactKind kind, const client::Contacts& contacts, size_t i, const MeetingPlace& place) {
  return features_text(kind, contacts, i, place) + point_text(point_of(kind, contacts, i, place));
}

Json meeting_json(v1::ContactKind kind, const client::Contacts& contacts, size_t i, const MeetingPlace& place) {
  Json out = contact_json(long_name_of(kind), contacts, i);
  if (is_crossing(kind)) out["edge"] = place.scene.edge(contacts.elements[i][0]);
  out["point"] = point_of(kind, contacts, i, place);
  return out;
}

}  // namespace collided::cli
