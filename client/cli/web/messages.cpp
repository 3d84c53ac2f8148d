// What collidectl view sends to its page.

#include "client/cli/web/messages.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "client/app/report/frame_line.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

namespace {

static_assert(std::endian::native == std::endian::little, "arrays are copied as they are");
static_assert(std::numeric_limits<float>::is_iec559);

/// A message under construction: arrays first, which the JSON before them counts.
class Message {
 public:
  Message(MessageKind kind, Json json) : kind_(kind), json_(std::move(json)) { json_["arrays"] = Json::object(); }

  template <class T>
  void add(const char* name, const std::vector<T>& values) {
    static_assert(sizeof(T) % sizeof(uint32_t) == 0);
    json_["arrays"][name] = values.size() * (sizeof(T) / sizeof(uint32_t));
    arrays_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }

  std::string text() const {
    std::string json = json_text(json_);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::array<uint32_t, 2> head{static_cast<uint32_t>(kind_), static_cast<uint32_t>(json.size())};
    return std::string(reinterpret_cast<const char*>(head.data()), sizeof head) + json + arrays_;
  }

 private:
  MessageKind kind_;
  Json json_;
  std::string arrays_;
};

Json meshes_json(const ShownScene& shown) {
  Json meshes = Json::array();
  for (int i = 0; i < shown.scene.spec().meshes_size(); ++i) {
    const v1::MeshSpec& mesh = shown.scene.spec().meshes(i);
    const auto at = static_cast<size_t>(i);
    const uint32_t first = shown.surface.first_vertex[at];
    meshes.push_back({{"name", mesh.name()},
                      {"motion", v1::MeshMotion_Name(mesh.motion())},
                      {"first", first},
                      {"vertices", shown.surface.first_vertex[at + 1] - first},
                      {"triangles", shown.surface.triangle_count[at]}});
  }
  return meshes;
}

[[noreturn]] void throw_loss(const std::string& what) { throw client::Error(grpc::DATA_LOSS, what); }

/// The samples of all meshes, one after the other.
template <class Scalar>
std::vector<std::array<double, 3>> unpack(const client::WatchedFrame& frame) {
  std::vector<std::array<double, 3>> positions;
  for (const v1::VertexSample& sample : frame.positions) {
    const std::string& bytes = sample.positions();
    for (size_t at = 0; at + 3 * sizeof(Scalar) <= bytes.size(); at += 3 * sizeof(Scalar)) {
      std::array<Scalar, 3> xyz;
      std::memcpy(xyz.data(), bytes.data() + at, sizeof xyz);
      positions.push_back({xyz[0], xyz[1], xyz[2]});
    }
  }
  return positions;
}

std::array<double, 3> middle(const std::vector<std::array<double, 3>>& positions) {
  std::array<double, 3> out{};
  if (positions.empty()) return out;
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto [least, most] = std::minmax_element(positions.begin(), positions.end(),
                                                   [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; });
    out[axis] = (*least)[axis] / 2 + (*most)[axis] / 2;
  }
  return out;
}

std::vector<std::array<float, 3>> relative_positions(ShownScene& shown, const client::WatchedFrame& frame) {
  const bool is_double = client::is_double(shown.scene.spec().position_format());
  const auto positions = is_double ? unpack<double>(frame) : unpack<float>(frame);
  if (positions.size() != shown.surface.vertex_count)
    throw_loss("positions: " + std::to_string(positions.size()) + " of " + std::to_string(shown.surface.vertex_count) +
               " vertices");
  if (!shown.has_origin) shown.origin = middle(positions);
  shown.has_origin = true;
  std::vector<std::array<float, 3>> out;
  out.reserve(positions.size());
  for (const auto& at : positions)
    out.push_back({static_cast<float>(at[0] - shown.origin[0]), static_cast<float>(at[1] - shown.origin[1]),
                   static_cast<float>(at[2] - shown.origin[2])});
  return out;
}

/// Of each contact that is shown the shown vertices of its features; `at` says which vertices those are.
template <size_t kVertices, class At>
std::vector<std::array<uint32_t, kVertices>> features(const Surface& surface, size_t count, const At& at) {
  std::vector<std::array<uint32_t, kVertices>> out;
  for (size_t i = 0; i < count; ++i) {
    std::array<uint32_t, kVertices> vertices = at(i);
    for (uint32_t& vertex : vertices) {
      if (vertex >= surface.shown_vertex.size()) throw_loss("contacts name vertex " + std::to_string(vertex));
      vertex = surface.shown_vertex[vertex];
    }
    if (std::find(vertices.begin(), vertices.end(), kNotShown) == vertices.end()) out.push_back(vertices);
  }
  return out;
}

void add_stencils(Message& message, const char* name, const Surface& surface, const client::Contacts& contacts) {
  message.add(name, features<4>(surface, contacts.stencils.size(), [&](size_t i) { return contacts.stencils[i]; }));
}

void add_triangle_pairs(Message& message, const Surface& surface, const client::Contacts& contacts) {
  const auto corners = [&](size_t i) {
    const auto [first, second] = contacts.elements[i];
    const auto &a = surface.scene.element(first), &b = surface.scene.element(second);
    return std::array<uint32_t, 6>{a[0], a[1], a[2], b[0], b[1], b[2]};
  };
  message.add("triangle_triangle", features<6>(surface, contacts.elements.size(), corners));
}

void add_crossings(Message& message, const Surface& surface, const client::Contacts& contacts) {
  const auto ends_and_corners = [&](size_t i) {
    const auto [edge, triangle] = contacts.elements[i];
    const auto& [u, v] = surface.scene.edge(edge);
    const auto& [a, b, c] = surface.scene.element(triangle);
    return std::array<uint32_t, 5>{u, v, a, b, c};
  };
  message.add("edge_triangle", features<5>(surface, contacts.elements.size(), ends_and_corners));
}

}  // namespace

std::string scene_message(const ShownScene& shown) {
  Message message(MessageKind::kScene, {{"epoch", shown.epoch},
                                        {"scene_id", shown.scene.scene_id()},
                                        {"name", shown.scene.spec().display_name()},
                                        {"scene", scene_json(shown.scene)},
                                        {"meshes", meshes_json(shown)},
                                        {"vertex_stride", shown.surface.vertex_stride}});
  message.add("triangles", shown.surface.triangles);
  message.add("edges", shown.surface.edges);
  message.add("points", shown.surface.points);
  return message.text();
}

std::string frame_message(ShownScene& shown, const client::WatchedFrame& frame) {
  const auto positions = relative_positions(shown, frame);
  Json json = {{"epoch", shown.epoch},
               {"frame", frame.frame_id},
               {"skipped_frames", frame.skipped_frames},
               {"omitted_contacts", frame.omitted_contacts},
               {"origin", shown.origin}};
  json.update(frame_result_json(frame.done, shown.scene.spec()));
  Message message(MessageKind::kFrame, std::move(json));
  message.add("positions", positions);
  add_stencils(message, "vertex_triangle", shown.surface, frame.vertex_triangle);
  add_stencils(message, "edge_edge", shown.surface, frame.edge_edge);
  add_triangle_pairs(message, shown.surface, frame.triangle_triangle);
  add_crossings(message, shown.surface, frame.edge_triangle);
  return message.text();
}

std::string status_message(const std::string& state, const std::string& message) {
  return Message(MessageKind::kStatus, {{"state", state}, {"message", message}}).text();
}

}  // namespace collided::cli
