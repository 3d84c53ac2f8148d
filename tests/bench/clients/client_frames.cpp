// The C++ side of clients_bench.py: frames of a sheet of SIDE * SIDE vertices, of which CELLS * CELLS cells have triangles.
// For each line on standard input it sends as many frames as the line says, one at a time, and prints for each
// microseconds as its client sees it, and those of the daemon's engine.
//
// As a FrameStream, which borrows positions, or as a Session, which like Python's keeps what a lost daemon takes.
//
// usage: collided_client_frames SERVER grpc|shared_memory stream|session SIDE CELLS

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "client/cpp/client.hpp"
#include "client/cpp/session.hpp"

using namespace collided::client;
namespace v1 = collided::v1;
using Clock = std::chrono::steady_clock;

namespace {

std::vector<std::array<uint32_t, 3>> triangles_of(uint32_t side, uint32_t cells) {
  std::vector<std::array<uint32_t, 3>> out;
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t a = y * side + x;
      out.push_back({a, a + 1, a + side});
      out.push_back({a + 1, a + side + 1, a + side});
    }
  return out;
}

std::vector<float> sheet(uint32_t side, float height) {
  std::vector<float> out;
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) out.insert(out.end(), {static_cast<float>(x), static_cast<float>(y), height});
  return out;
}

/// Blocks of frames, as many as standard input says. `detect` sends a frame and waits for its output.
template <class Detect>
void time_frames(uint32_t side, const Detect& detect) {
  const std::vector<float> sheets[] = {sheet(side, 0), sheet(side, 0.25F)};
  uint64_t id = 0;
  for (int frames = 0; std::scanf("%d", &frames) == 1;) {
    for (; frames > 0; --frames) {
      const auto start = Clock::now();
      const FrameUpdate update{.mesh = 0, .positions = std::as_bytes(std::span(sheets[++id % 2]))};
      const FrameOutput output = detect(id, update);
      const std::chrono::duration<double, std::micro> took = Clock::now() - start;
      std::printf("%.1f %.1f ", took.count(), output.done.metrics().engine_milliseconds() * 1e3);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6)
    return std::fputs("usage: collided_client_frames SERVER grpc|shared_memory stream|session SIDE CELLS\n", stderr), 2;
  const auto side = static_cast<uint32_t>(std::atoi(argv[4])), cells = static_cast<uint32_t>(std::atoi(argv[5]));
  const auto triangles = triangles_of(side, cells);
  const MeshInput mesh{.name = "sheet", .vertex_count = side * side, .triangles = triangles};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  StreamOptions options;
  options.local.use = std::strcmp(argv[2], "grpc") == 0 ? Local::kOff : Local::kOn;
  if (std::strcmp(argv[3], "session") == 0) {
    Session session = Session::open(argv[1], spec, {&mesh, 1}, {.stream = options});
    time_frames(side, [&](uint64_t, const FrameUpdate& update) { return session.detect({&update, 1}); });
    return 0;
  }
  Client client = Client::connect(argv[1]);
  FrameStream stream = client.stream(client.create_scene(spec, {&mesh, 1}), options);
  time_frames(side, [&](uint64_t id, const FrameUpdate& update) {
    stream.send(id, {&update, 1});
    FrameOutput output = stream.receive();
    output.check();
    return output;
  });
}
