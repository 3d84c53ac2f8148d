// A client that streams frames until it is killed: stream_client ADDRESS SCENE SIDE. Keeps some frames in flight, and
// writes a byte to its output once the first one was answered.
#include <unistd.h>

#include <cstdint>
#include <string>

#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/stream.hpp"

int main(int argc, char** argv) {
  namespace test = collided::test;
  constexpr uint64_t kInFlight = 8;
  if (argc != 4) return 2;
  const auto stub = test::pb::CollisionService::NewStub(test::channel_to(argv[1]));
  const auto positions = test::pack_points(test::layer_points(static_cast<uint32_t>(std::stoul(argv[3]))));
  test::Stream stream(*stub, argv[2], kInFlight);
  if (!stream.opened()) return 1;
  for (uint64_t id = 1; id <= kInFlight; ++id) stream.send(test::layers_frame(id, positions));
  for (uint64_t id = 1; !stream.receive(id).ended; ++id) {
    if (id == 1 && write(STDOUT_FILENO, "", 1) != 1) return 1;
    stream.send(test::layers_frame(id + kInFlight, positions));
  }
  return 0;
}
