// Packets of the local socket, and frames whose messages and positions are in shared memory. An input is packets, each
// after its length in two bytes; a length of 0 is followed by the content of the shared memory.

#include <fcntl.h>
#include <google/protobuf/stubs/logging.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "server/frames/decode.hpp"
#include "server/transport/local/packets.hpp"
#include "server/transport/local/shared_frame.hpp"
#include "tests/fuzz/targets/refusal.hpp"
#include "tests/server/convert/scene_request.hpp"

namespace collided::fuzz {
namespace {

using namespace server;  // NOLINT: the code under test

/// Memory of a client, as the daemon maps it.
class Memory {
 public:
  Memory() {
    const Fd file(memfd_create("region", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    const bool is_ready = ftruncate(file.get(), kBytes) == 0 && fcntl(file.get(), F_ADD_SEALS, F_SEAL_SHRINK) == 0;
    require(is_ready, "a memfd can be sealed");
    region_ = SharedRegion::map(file, {kInput, kBytes - kInput}, Device{});
    own_ = static_cast<char*>(mmap(nullptr, kInput, PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0));
    require(own_ != MAP_FAILED, "a memfd can be mapped");
  }
  void write(std::string_view bytes) {
    std::fill_n(own_, kInput, '\0');
    bytes.copy(own_, kInput);
  }
  const SharedRegion& region() const { return *region_; }
  bool holds(std::span<const std::byte> bytes) const {
    const auto all = region_->input(0, kInput, "");
    return bytes.empty() || (bytes.data() >= all.data() && bytes.data() + bytes.size() <= all.data() + all.size());
  }

 private:
  static constexpr size_t kInput = 4096, kBytes = 2 * kInput;
  std::shared_ptr<SharedRegion> region_;
  char* own_ = nullptr;
};

class Socket {
 public:
  std::string through(std::string_view packet) {
    require(send_packet(client_.get(), packet) == Sent::kYes, "a packet is sent");
    return std::string(receiver_.receive().bytes);
  }

 private:
  static std::array<int, 2> make_pair() {
    std::array<int, 2> ends{};
    require(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) == 0, "there are sockets");
    return ends;
  }

  const std::array<int, 2> ends_ = make_pair();
  const Fd client_{ends_[0]}, daemon_{ends_[1]};
  PacketReceiver receiver_{daemon_.get()};
};

void take(const pb::LocalRequest& request, const Memory& memory) {
  static const ScenePlan plan = parse_scene(server::request(), {}).plan;
  MemoryHold copied(DeviceBytes::of_scene(1 << 20, nullptr));
  IncomingFrame frame;
  if (request.has_shared_frame())
    frame.message = read_frame(&memory.region(), request.shared_frame(), plan, copied);
  else
    frame.message = request.frame();
  place_ranges(&memory.region(), frame);
  if (frame.refusal) std::rethrow_exception(frame.refusal);
  for (const PlacedPositions& placed : frame.placed)
    require(memory.holds(placed.start) && memory.holds(placed.end) && memory.holds(placed.indices),
            "ranges are in the memory that there is");
  parse_frame(frame.message, frame.placed, plan.engine);
}

void take(std::string_view packet, Socket& socket, const Memory& memory) try {
  pb::LocalRequest request;
  const std::string bytes = socket.through(packet);
  require(bytes == packet, "a packet arrives as it was sent");
  if (request.ParseFromString(bytes) && (request.has_frame() || request.has_shared_frame())) take(request, memory);
} catch (...) {
  check_refusal();
}

}  // namespace

void run(Input input) {
  static const google::protobuf::LogSilencer no_words_on_strings_that_are_not_utf8;
  static Memory memory;
  static Socket socket;
  std::vector<std::string_view> packets;
  while (const auto length = input.number<uint16_t>()) packets.push_back(input.take(length));
  memory.write(input.rest());
  for (const std::string_view packet : packets)
    if (!packet.empty()) take(packet, socket, memory);
}

}  // namespace collided::fuzz
