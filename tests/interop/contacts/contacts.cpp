// The scene of contacts_test.py with the C++ library. usage: interop_contacts ADDRESS; writes the contacts' bytes to
// stdout.

#include <cstdio>
#include <vector>

#include "client/cpp/client.hpp"

using namespace collided::client;
namespace v1 = collided::v1;
using Points = std::vector<std::array<double, 3>>;

namespace {

constexpr uint32_t kSide = 17;

template <class T>
void put(const std::vector<T>& array) {
  std::fwrite(array.data(), sizeof(T), array.size(), stdout);
}

void put(const Contacts& contacts) {
  put(std::vector{static_cast<uint32_t>(contacts.count)});
  put(contacts.elements);
  put(contacts.stencils);
  put(contacts.toi);
  put(contacts.distance);
  put(contacts.weights);
  put(contacts.normals);
  put(contacts.flags);
  put(contacts.features);
}

void put(const PerKind<Contacts>& contacts) {
  put(contacts.vertex_triangle);
  put(contacts.edge_edge);
}

/// A sheet of bumps; every coordinate is exact.
Points sheet(double shift, double height, uint32_t a, uint32_t b) {
  Points points;
  for (uint32_t j = 0; j < kSide; ++j)
    for (uint32_t i = 0; i < kSide; ++i)
      points.push_back({0.25 * i + shift, 0.25 * j + shift, height + (a * i + b * j) % 32 / 64.0});
  return points;
}

std::vector<std::array<uint32_t, 3>> triangles() {
  std::vector<std::array<uint32_t, 3>> out;
  for (uint32_t j = 0; j + 1 < kSide; ++j)
    for (uint32_t i = 0; i + 1 < kSide; ++i) {
      const uint32_t v = j * kSide + i;
      out.push_back({v, v + 1, v + kSide});
      out.push_back({v + 1, v + kSide + 1, v + kSide});
    }
  return out;
}

v1::SceneSpec spec() {
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_DCD_AND_CCD);
  spec.set_thickness(0.25);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  for (int field = v1::ContactField_MIN + 1; field <= v1::ContactField_MAX; ++field)
    if (v1::ContactField_IsValid(field) && field != v1::CONTACT_FIELD_PAIR_STATES)  // those are of solids
      spec.add_fields(static_cast<v1::ContactField>(field));
  return spec;
}

std::span<const std::byte> bytes_of(const Points& points) { return std::as_bytes(std::span(points)); }

}  // namespace

int main(int, char** argv) {
  const auto faces = triangles();
  const MeshInput meshes[] = {{.name = "lower", .vertex_count = kSide * kSide, .triangles = faces, .is_static = true},
                              {.name = "upper", .vertex_count = kSide * kSide, .triangles = faces}};
  Client client = Client::connect(argv[1]);
  FrameStream stream = client.stream(client.create_scene(spec(), meshes), {.local = {.use = Local::kOff}});
  const Points lower = sheet(0, 0, 7, 13);
  for (uint64_t frame = 0, id = 0; frame < 5; ++frame) {
    Points upper = sheet(0.125, 2.0 - static_cast<double>(frame), 11, 5);
    std::vector<uint32_t> indices;
    if (frame == 4) {  // every third vertex alone, back through the lower sheet
      Points some;
      for (uint32_t v = 0; v < kSide * kSide; v += 3) {
        indices.push_back(v);
        some.push_back({upper[v][0], upper[v][1], upper[v][2] + 3});
      }
      upper = some;
    }
    const FrameUpdate above{.mesh = 1, .positions = bytes_of(upper), .indices = std::as_bytes(std::span(indices))};
    const FrameUpdate both[] = {{.mesh = 0, .positions = bytes_of(lower)}, above};
    if (frame == 2) {
      stream.send(++id, {&above, 1},
                  {.advance = true, .advance_mode = v1::ADVANCE_MODE_PER_VERTEX, .limits = true, .trial = true});
      const FrameOutput tried = stream.receive();
      tried.check();
      put(tried.limits);
    }
    stream.send(++id, frame == 0 ? std::span(both) : std::span(&above, 1));
    const FrameOutput output = stream.receive();
    output.check();
    put(static_cast<const PerKind<Contacts>&>(output));
    stream.send(++id, {}, {.mode = v1::DETECTION_MODE_DCD});
    const FrameOutput still = stream.receive();
    still.check();
    put(static_cast<const PerKind<Contacts>&>(still));
  }
  stream.finish();
}
