// A client of the local socket that streams frames until it is killed: local_client SOCKET SCENE SIDE OUTPUT_BYTES.
// Keeps some frames in flight, and writes a byte to its output once the first one was answered.
#include <unistd.h>

#include <cstdint>
#include <string>

#include "tests/integration/local/local_stream.hpp"
#include "tests/integration/support/layers.hpp"

int main(int argc, char** argv) {
  namespace test = collided::test;
  constexpr uint32_t kInFlight = 8;
  if (argc != 5) return 2;
  const auto positions = test::pack_points(test::layer_points(static_cast<uint32_t>(std::stoul(argv[3]))));
  const size_t input = kInFlight * ((positions.size() + 4095) / 4096 * 4096);
  test::LocalStream stream(argv[1], argv[2], {.input = input, .output = std::stoul(argv[4]), .window = kInFlight});
  if (!stream.opened()) return 1;
  for (uint64_t id = 1; id <= kInFlight; ++id) stream.send_shared(test::layers_frame(id, positions));
  for (uint64_t id = 1; !stream.receive(id).ended; ++id) {
    if (id == 1 && write(STDOUT_FILENO, "", 1) != 1) return 1;
    stream.send_shared(test::layers_frame(id + kInFlight, positions));
  }
  return 0;
}
