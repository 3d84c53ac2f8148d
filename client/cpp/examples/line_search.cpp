// A line search: how far along a direction a cloth can go before it touches a tip, halving the step until it is free.
// Each position is sent once: a trial asks about the whole way, and from_last_fraction goes to a point of it. usage:
// line_search ADDRESS
#include <collided/client.hpp>
#include <cstdio>

#include "client/cpp/examples/grid.hpp"

using namespace collided::client;
namespace v1 = collided::v1;

namespace {

FrameOutput ask(FrameStream& stream, uint64_t id, std::span<const FrameUpdate> updates, const FrameOptions& options) {
  stream.send(id, updates, options);
  FrameOutput output = stream.receive();
  output.check();  // throws if the frame was refused
  return output;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: line_search ADDRESS\n", stderr), 2;
  const Grid cloth = make_grid(8, 1.0 / 8, 1);
  const std::vector<std::array<uint32_t, 3>> one{{0, 1, 2}};
  const Points tip{{0.4, 0.4, -0.5}, {0.6, 0.4, -0.5}, {0.5, 0.5, 0.3}};
  const MeshInput meshes[] = {{.name = "tip", .vertex_count = 3, .triangles = one, .is_static = true},
                              {.name = "cloth", .vertex_count = 81, .triangles = cloth.triangles}};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  Client client = Client::connect(argv[1]);
  const v1::Scene scene = client.create_scene(spec, meshes);
  FrameStream stream = client.stream(scene);

  const FrameUpdate rest[] = {{.mesh = 0, .positions = bytes_of(tip)},
                              {.mesh = 1, .positions = bytes_of(cloth.points)}};
  ask(stream, 1, rest, {});
  Points target = cloth.points;
  for (auto& point : target) point[2] -= 2;
  const FrameUpdate whole_way{.mesh = 1, .positions = bytes_of(target)};
  const double first_contact = ask(stream, 2, {&whole_way, 1}, {.trial = true}).done.earliest_toi();
  double fraction = 1;
  while (fraction > first_contact) fraction /= 2;
  const FrameOutput there = ask(stream, 3, {}, {.from_last_fraction = fraction});
  std::printf("first contact at %.3f, went %g, contacts %d, height %g\n", first_contact, fraction,
              static_cast<int>(there.done.contact_count()), 1 - 2 * fraction);
  client.delete_scene(scene.scene_id());
} catch (const Error& error) {
  return std::fprintf(stderr, "line_search: %s\n", error.what()), 1;
}
