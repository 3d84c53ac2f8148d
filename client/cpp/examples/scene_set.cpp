// A thousand scenes in one call: in each a tetrahedron falls to a floor, from another height. usage: scene_set ADDRESS
#include <collided/client.hpp>
#include <cstdio>

#include "client/cpp/examples/grid.hpp"

using namespace collided::client;
namespace v1 = collided::v1;

constexpr uint32_t kWorlds = 1000;

/// The bodies of all worlds, one after the other; each after the floor where it is the first frame.
Points positions(double fallen, bool first) {
  Points all;
  for (uint32_t world = 0; world < kWorlds; ++world) {
    if (first) all.insert(all.end(), {{-4, -4, 0}, {4, -4, 0}, {0, 4, 0}});
    const double z = (world + 0.5) / kWorlds - fallen;
    all.insert(all.end(), {{0, 0, z}, {1, 0, z + 1}, {0, 1, z + 1}, {-1, -1, z + 1}});
  }
  return all;
}

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: scene_set ADDRESS\n", stderr), 2;
  const std::vector<std::array<uint32_t, 3>> one{{0, 1, 2}}, faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MeshInput meshes[] = {{.name = "floor", .vertex_count = 3, .triangles = one, .is_static = true},
                              {.name = "body", .vertex_count = 4, .triangles = faces}};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  Client client = Client::connect(argv[1]);
  SceneSet set = SceneSet::create(client, spec, meshes, kWorlds);
  const Points begin = positions(0, true);
  set.detect({.positions = bytes_of(begin)});
  for (const double fallen : {0.25, 0.5, 0.75}) {
    const Points now = positions(fallen, false);
    const SetOutput output = set.detect({.positions = bytes_of(now)});
    uint32_t touching = 0;
    for (uint32_t world = 0; world < kWorlds; ++world)
      touching += output.vertex_triangle.begin[world] < output.vertex_triangle.begin[world + 1] ? 1 : 0;
    std::printf("%d contacts in %u worlds\n", static_cast<int>(output.done.contact_count()), touching);
  }
  set.close();
} catch (const Error& error) {
  return std::fprintf(stderr, "scene_set: %s\n", error.what()), 1;
}
