// A cloth that is thick for its cells touches itself all over, even flat: what is close at rest can be left out. usage:
// rest_shape_exclusions ADDRESS
#include <collided/client.hpp>
#include <cstdio>

#include "client/cpp/examples/grid.hpp"

using namespace collided::client;
namespace v1 = collided::v1;

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: rest_shape_exclusions ADDRESS\n", stderr), 2;
  const Grid flat = make_grid(20, 0.01, 0);  // cells of 10 mm
  Points folded = flat.points;
  for (auto& point : folded)
    if (point[0] > 0.1) point = {0.2 - point[0], point[1], 0.006};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_DCD);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  spec.set_thickness(0.008);

  for (const bool excludes : {false, true}) {
    MeshInput cloth{.name = "cloth", .vertex_count = 21 * 21, .triangles = flat.triangles};
    cloth.exclude_rings = excludes ? 1 : 0;  // features that share a vertex, or that an edge connects
    cloth.exclude_rest_pairs = excludes;     // those within the thickness in the first frame
    Session session = Session::open(argv[1], spec, {&cloth, 1});
    const auto count = [&](const Points& points) {
      const FrameUpdate update{.mesh = 0, .positions = bytes_of(points)};
      return static_cast<int>(session.detect({&update, 1}).done.contact_count());
    };
    const int at_rest = count(flat.points), then = count(folded);
    std::printf("%s: flat %d, folded %d contacts\n", excludes ? "without what is close at rest" : "nothing excluded",
                at_rest, then);
    session.close();
  }
} catch (const Error& error) {
  return std::fprintf(stderr, "rest_shape_exclusions: %s\n", error.what()), 1;
}
