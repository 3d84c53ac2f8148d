// Only what changed is sent: one vertex of a sheet is pulled up to a ceiling, while all others stand still. usage:
// sparse_update ADDRESS
#include <collided/client.hpp>
#include <cstdio>

#include "client/cpp/examples/grid.hpp"

using namespace collided::client;
namespace v1 = collided::v1;

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: sparse_update ADDRESS\n", stderr), 2;
  const Grid sheet = make_grid(100, 0.1, 0);
  const std::vector<std::array<uint32_t, 3>> one{{0, 1, 2}};
  const Points ceiling{{0, 0, 1}, {20, 0, 1}, {0, 20, 1}};
  const MeshInput meshes[] = {{.name = "ceiling", .vertex_count = 3, .triangles = one, .is_static = true},
                              {.name = "sheet", .vertex_count = 101 * 101, .triangles = sheet.triangles}};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  Session session = Session::open(argv[1], spec, meshes);
  const FrameUpdate rest[] = {{.mesh = 0, .positions = bytes_of(ceiling)},
                              {.mesh = 1, .positions = bytes_of(sheet.points)}};
  session.detect(rest);

  const std::vector<uint32_t> pulled{5100};  // ascending where there are several
  for (const double height : {0.5, 1.5}) {
    const Points there{{5, 5, height}};  // of these vertices only
    const FrameUpdate update{.mesh = 1, .positions = bytes_of(there), .indices = std::as_bytes(std::span(pulled))};
    const FrameOutput output = session.detect({&update, 1});
    std::printf("%d bytes, %d vertex meets the ceiling\n", static_cast<int>(output.done.metrics().bytes_in()),
                static_cast<int>(output.vertex_triangle.count));
  }
  session.close();
} catch (const Error& error) {
  return std::fprintf(stderr, "sparse_update: %s\n", error.what()), 1;
}
