// A triangle falls on another: in which step, and when in it, do they meet? usage: first_contact ADDRESS
#include <array>
#include <collided/client.hpp>
#include <cstdio>
#include <span>
#include <vector>

using namespace collided::client;
namespace v1 = collided::v1;

std::span<const std::byte> bytes_of(const std::vector<float>& positions) { return std::as_bytes(std::span(positions)); }

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: first_contact ADDRESS\n", stderr), 2;
  const std::vector<std::array<uint32_t, 3>> corners{{0, 1, 2}};
  const MeshInput meshes[] = {{.name = "floor", .vertex_count = 3, .triangles = corners, .is_static = true},
                              {.name = "falling", .vertex_count = 3, .triangles = corners}};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  Session session = Session::open(argv[1], spec, meshes);

  const std::vector<float> floor{0, 0, 0, 4, 0, 0, 0, 4, 0};
  for (int step = 0; step <= 5; ++step) {
    const float z = 1 - 0.375f * static_cast<float>(step);  // of the lowest corner, when the step ends
    const std::vector<float> falling{1, 1, z, 1.25f, 1, z + 8, 1, 1.25f, z + 8};
    std::vector<FrameUpdate> updates{{.mesh = 1, .positions = bytes_of(falling)}};
    if (step == 0) updates.push_back({.mesh = 0, .positions = bytes_of(floor)});  // the first frame names every mesh
    const FrameOutput output = session.detect(updates);
    const Contacts& found = output.vertex_triangle;
    std::printf("step %d: %zu contacts\n", step, static_cast<size_t>(output.done.contact_count()));
    for (size_t i = 0; i < found.count; ++i)
      std::printf("  vertex %u, triangle %u, t = %.4f\n", found.elements[i][0], found.elements[i][1], found.toi[i]);
  }
  session.close();
} catch (const Error& error) {
  return std::fprintf(stderr, "first_contact: %s\n", error.what()), 1;
}
