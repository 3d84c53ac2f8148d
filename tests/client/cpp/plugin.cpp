// A plug-in of another program, with the static client inside: it shows the one function that its host calls.
#include <collided/client.hpp>
#include <cstring>

extern "C" __attribute__((visibility("default"))) int plugin_vertices(const char* address, char* error,
                                                                      size_t size) try {
  using namespace collided::client;
  Client client = Client::connect(address, {.patience = std::chrono::milliseconds(2000)});
  collided::v1::SceneSpec spec;
  spec.set_mode(collided::v1::DETECTION_MODE_CCD);
  const std::array<uint32_t, 3> corners[] = {{0, 1, 2}};
  const MeshInput mesh{.name = "triangle", .vertex_count = 3, .triangles = corners};
  return static_cast<int>(client.create_scene(spec, {&mesh, 1}, 1).vertex_count());
} catch (const std::exception& e) {
  std::strncpy(error, e.what(), size - 1);
  return -1;
}
