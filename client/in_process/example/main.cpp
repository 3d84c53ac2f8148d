// One program, two places: a triangle falls on another, in this process or in that of a daemon. usage: two_places
// [ADDRESS]
#include <array>
#include <collided/client.hpp>
#include <collided/local.hpp>
#include <cstdio>
#include <span>
#include <vector>

using namespace collided::client;
namespace v1 = collided::v1;

int main(int argc, char** argv) try {
  if (argc > 2) return std::fputs("usage: two_places [ADDRESS]\n", stderr), 2;
  const Client client = argc == 2 ? Client::connect(argv[1]) : collided::local();  // all else is the same
  const std::vector<std::array<uint32_t, 3>> corners{{0, 1, 2}};
  const MeshInput meshes[] = {{.name = "floor", .vertex_count = 3, .triangles = corners, .is_static = true},
                              {.name = "falling", .vertex_count = 3, .triangles = corners}};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  Session session = Session::open(client, spec, meshes);

  const std::vector<float> floor{0, 0, 0, 4, 0, 0, 0, 4, 0};
  for (int step = 0; step <= 5; ++step) {
    const float z = 1 - 0.375f * static_cast<float>(step);  // of the lowest corner, when the step ends
    const std::vector<float> falling{1, 1, z, 1.25f, 1, z + 8, 1, 1.25f, z + 8};
    std::vector<FrameUpdate> updates{{.mesh = 1, .positions = std::as_bytes(std::span(falling))}};
    if (step == 0) updates.push_back({.mesh = 0, .positions = std::as_bytes(std::span(floor))});
    session.submit(updates, [step](FrameResult result) {  // on the session's thread, in the order of the frames
      if (!result.ok()) return void(std::fprintf(stderr, "step %d: %s\n", step, result.error()->what()));
      const Contacts& found = result.output().vertex_triangle;
      std::printf("step %d: %zu contacts\n", step, static_cast<size_t>(found.count));
      for (size_t i = 0; i < found.count; ++i)
        std::printf("  vertex %u, triangle %u, t = %.4f\n", found.elements[i][0], found.elements[i][1], found.toi[i]);
    });
  }
  session.detect({});  // once it is answered, so are those before it
  session.close();
} catch (const Error& error) {
  return std::fprintf(stderr, "two_places: %s\n", error.what()), 1;
}
