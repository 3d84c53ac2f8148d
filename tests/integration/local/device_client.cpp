// A client that keeps contacts on the device and streams frames until it is killed: device_client ADDRESS SCENE. Writes
// a byte to its output once the first frame was answered.
#include <unistd.h>

#include "tests/integration/local/device_scene.hpp"

int main(int argc, char** argv) {
  using namespace collided;
  constexpr uint32_t kWindow = 4;
  constexpr uint64_t kFrameBytes = 4 << 20;
  if (argc != 3) return 2;
  const test::DeviceMemory memory(kWindow * kFrameBytes);
  client::Client client = client::Client::connect(argv[1]);
  client::FrameStream stream = client.stream(
      client.get_scene(argv[2]),
      {.window = kWindow,
       .local = {.use = client::Local::kOn, .output_bytes = kFrameBytes, .output_cuda_ipc_handle = memory.handle()}});
  for (uint64_t id = 1;; ++id) {
    const std::string positions = test::device_layers_at(id);
    const client::FrameUpdate update{.positions = std::as_bytes(std::span(positions))};
    stream.send(id, {&update, 1});
    if (id < kWindow) continue;
    stream.receive().check();
    if (id == kWindow && write(STDOUT_FILENO, "", 1) != 1) return 1;
  }
}
